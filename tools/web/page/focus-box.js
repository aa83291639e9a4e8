// A box with a handle on each side and one in the middle. The handles are buttons over the picture: they can be dragged
// with any pointer, and moved by the arrow keys.
import * as THREE from "three";

const kAxes = ["x", "y", "z"];
const kLeastSide = 0.005; // of the diagonal

export class FocusBox {
  /** `changed()` is called when the user moves it. */
  constructor(scene, changed) {
    this.scene = scene;
    this.changed = changed;
    this.min = [0, 0, 0];
    this.max = [1, 1, 1];
    const material = new THREE.LineBasicMaterial({ color: 0xd9541e });
    this.lines = new THREE.LineSegments(new THREE.EdgesGeometry(new THREE.BoxGeometry(1, 1, 1)), material);
    // What hides it is seen through faintly.
    const behind = new THREE.LineBasicMaterial({ color: 0xd9541e, transparent: true, opacity: 0.35, depthTest: false });
    this.lines.add(new THREE.LineSegments(this.lines.geometry, behind));
    this.lines.visible = false;
    scene.model.add(this.lines);
    this.handles = [this.makeHandle("focus box", -1, 0)];
    for (let axis = 0; axis < 3; ++axis)
      for (const side of [-1, 1])
        this.handles.push(this.makeHandle(`focus box, ${side < 0 ? "low" : "high"} ${kAxes[axis]} side`, axis, side));
    scene.overlays.push(() => this.place());
  }

  makeHandle(label, axis, side) {
    const element = document.createElement("button");
    element.className = axis < 0 ? "handle is-middle" : "handle";
    element.setAttribute("aria-label", label);
    element.hidden = true;
    this.scene.parent.append(element);
    const handle = { element, axis, side };
    element.addEventListener("pointerdown", (event) => {
      element.setPointerCapture(event.pointerId);
      handle.at = [event.clientX, event.clientY];
      element.focus();
      event.preventDefault();
    });
    element.addEventListener("pointermove", (event) => {
      if (!element.hasPointerCapture(event.pointerId)) return;
      const [x, y] = handle.at;
      handle.at = [event.clientX, event.clientY];
      this.drag(handle, event.clientX - x, event.clientY - y);
    });
    element.addEventListener("keydown", (event) => {
      const way = { ArrowLeft: [-4, 0], ArrowRight: [4, 0], ArrowUp: [0, -4], ArrowDown: [0, 4] }[event.key];
      if (!way) return;
      event.preventDefault();
      this.drag(handle, ...way);
    });
    return handle;
  }

  pointOf({ axis, side }) {
    return this.min.map((low, i) => (i !== axis ? 0.5 * (low + this.max[i]) : side < 0 ? low : this.max[i]));
  }

  /** The middle moves across the view, a side along its axis by what of that way is seen. */
  drag(handle, dx, dy) {
    const point = this.pointOf(handle);
    const { axis, side } = handle;
    if (axis < 0) {
      const way = this.scene.fromScreen(point, dx, dy);
      this.min = this.min.map((x, i) => x + way[i]);
      this.max = this.max.map((x, i) => x + way[i]);
    } else {
      const unit = this.diagonal * 0.01;
      const from = this.scene.toScreen(point);
      const to = this.scene.toScreen(point.map((x, i) => (i === axis ? x + unit : x)));
      const along = [to.x - from.x, to.y - from.y];
      const squared = along[0] ** 2 + along[1] ** 2;
      if (squared < 0.01) return; // seen end on
      const way = ((dx * along[0] + dy * along[1]) / squared) * unit;
      const least = kLeastSide * this.diagonal;
      if (side < 0) this.min[axis] = Math.min(this.min[axis] + way, this.max[axis] - least);
      else this.max[axis] = Math.max(this.max[axis] + way, this.min[axis] + least);
    }
    this.update();
    this.changed();
  }

  set(min, max, diagonal) {
    this.min = [...min];
    this.max = [...max];
    this.diagonal = diagonal;
    this.update();
  }

  show(isShown) {
    this.lines.visible = isShown;
    this.update();
  }

  update() {
    if (!this.scene.middle) return;
    this.lines.position.set(...this.min.map((low, i) => 0.5 * (low + this.max[i]) - this.scene.middle[i]));
    this.lines.scale.set(...this.min.map((low, i) => this.max[i] - low));
    this.scene.changed();
  }

  place() {
    for (const handle of this.handles) {
      const { element } = handle;
      element.hidden = !this.lines.visible;
      if (element.hidden) continue;
      const { x, y, isBehind } = this.scene.toScreen(this.pointOf(handle));
      element.hidden = isBehind;
      element.style.left = `${x}px`;
      element.style.top = `${y}px`;
    }
  }
}
