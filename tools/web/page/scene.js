// The picture: triangles coloured by a field, with the edges of their tets, under an orbiting camera.
// Lengths: the file's box has its middle at the origin and a diagonal of 2.
import * as THREE from "three";
import { OrbitControls } from "./three/OrbitControls.js";

// Viridis (by van der Walt and Smith), at nine places.
const kColours = ["#440154", "#472d7b", "#3b528b", "#2c728e", "#21918c", "#28ae80", "#5ec962", "#addc30", "#fde725"];

export const colourGradient = `linear-gradient(to right, ${kColours.join(", ")})`;

function colourTexture() {
  const bytes = kColours.flatMap((colour) => [1, 3, 5].map((i) => parseInt(colour.slice(i, i + 2), 16)).concat(255));
  const texture = new THREE.DataTexture(new Uint8Array(bytes), kColours.length, 1);
  texture.minFilter = texture.magFilter = THREE.LinearFilter;
  texture.needsUpdate = true;
  return texture;
}

const kVertexShader = `
  in float colour;
  in vec4 barycentric;
  out float value;
  out vec3 edge;
  out vec3 eye;
  void main() {
    vec4 place = modelViewMatrix * vec4(position, 1.0);
    value = colour;
    edge = barycentric.xyz;
    eye = place.xyz;
    gl_Position = projectionMatrix * place;
  }`;
const kFragmentShader = `
  uniform sampler2D colours;
  uniform float places, least, greatest, opacity, edges;
  in float value;
  in vec3 edge;
  in vec3 eye;
  out vec4 pixel;
  void main() {
    float t = clamp((value - least) / max(greatest - least, 1e-30), 0.0, 1.0);
    vec3 colour = texture(colours, vec2((t * (places - 1.0) + 0.5) / places, 0.5)).rgb;
    if (isnan(value)) colour = vec3(0.6);
    vec3 normal = normalize(cross(dFdx(eye), dFdy(eye)));
    colour *= 0.7 + 0.3 * abs(normal.z);
    vec3 width = max(fwidth(edge) * 1.2, vec3(1e-6)); // 0 where the edge is none of the mesh
    vec3 near = smoothstep(vec3(0.0), width, edge);
    // Where triangles are a few pixels wide, edges would be all there is.
    float strength = edges * clamp(1.3 - 1.5 * max(width.x, max(width.y, width.z)), 0.25, 1.0);
    colour *= mix(1.0, 0.45 + 0.55 * min(near.x, min(near.y, near.z)), strength);
    pixel = vec4(colour, opacity);
  }`;

export class Scene {
  /** Throws when the browser has no WebGL 2. */
  constructor(parent) {
    this.parent = parent;
    this.renderer = new THREE.WebGLRenderer({ antialias: true, alpha: true });
    this.renderer.setPixelRatio(window.devicePixelRatio);
    parent.append(this.renderer.domElement);
    this.camera = new THREE.PerspectiveCamera(30, 1, 0.01, 100);
    this.camera.up.set(0, 0, 1);
    this.scene = new THREE.Scene();
    this.model = new THREE.Group(); // in mesh units, relative to the middle
    this.scene.add(this.model);
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.controls.addEventListener("change", () => this.changed());
    this.overlays = []; // called after each picture
    this.parts = {};
    this.shared = {
      colours: { value: colourTexture() },
      places: { value: kColours.length },
      least: { value: 0 },
      greatest: { value: 1 },
      edges: { value: 1 },
    };
    for (const name of ["surface", "slice", "isosurface"]) this.parts[name] = this.makePart();
    new ResizeObserver(() => this.resize()).observe(parent);
    this.resize();
  }

  makePart() {
    const material = new THREE.ShaderMaterial({
      glslVersion: THREE.GLSL3,
      vertexShader: kVertexShader,
      fragmentShader: kFragmentShader,
      uniforms: { ...this.shared, opacity: { value: 1 } },
      side: THREE.DoubleSide,
      polygonOffset: true,
      polygonOffsetFactor: 1,
      polygonOffsetUnits: 1,
    });
    const part = new THREE.Mesh(new THREE.BufferGeometry(), material);
    part.frustumCulled = false;
    part.visible = false;
    this.model.add(part);
    return part;
  }

  setBox(boxMin, boxMax, diagonal) {
    this.middle = boxMin.map((low, i) => 0.5 * (low + boxMax[i]));
    this.model.scale.setScalar(2 / diagonal);
  }

  /** `direction`: from the middle to the eye; its length 1 shows the whole box. */
  lookFrom(direction) {
    this.camera.position.set(...direction).multiplyScalar(4);
    this.controls.target.set(0, 0, 0);
    this.controls.update();
    this.changed();
  }

  /** Where the camera is, as lookFrom takes it, and what it looks at. */
  get cameraPlace() {
    return [...this.camera.position.toArray(), ...this.controls.target.toArray()];
  }
  set cameraPlace(numbers) {
    this.camera.position.fromArray(numbers);
    this.controls.target.fromArray(numbers, 3);
    this.controls.update();
    this.changed();
  }

  show(picture) {
    for (const [name, part] of Object.entries(this.parts)) {
      const triangles = picture[name];
      part.visible = triangles !== undefined;
      part.geometry.dispose();
      part.geometry = new THREE.BufferGeometry();
      if (!triangles) continue;
      part.geometry.setAttribute("position", new THREE.BufferAttribute(triangles.positions, 3));
      part.geometry.setAttribute("colour", new THREE.BufferAttribute(triangles.colours, 1));
      part.geometry.setAttribute("barycentric", new THREE.BufferAttribute(triangles.barycentric, 4, true));
    }
    this.changed();
  }

  setColourRange(least, greatest) {
    this.shared.least.value = least;
    this.shared.greatest.value = greatest;
    this.changed();
  }

  setStyle({ edges, translucent }) {
    this.shared.edges.value = edges ? 1 : 0;
    const { material } = this.parts.surface;
    material.uniforms.opacity.value = translucent ? 0.25 : 1;
    material.transparent = translucent;
    material.depthWrite = !translucent;
    this.changed();
  }

  /** Pixels from the left upper corner of the view, of a point in mesh units. */
  toScreen(point) {
    const place = this.model.localToWorld(new THREE.Vector3(...point.map((x, i) => x - this.middle[i])));
    place.project(this.camera);
    const { clientWidth: width, clientHeight: height } = this.parent;
    return { x: (0.5 + 0.5 * place.x) * width, y: (0.5 - 0.5 * place.y) * height, isBehind: place.z > 1 };
  }

  /** Mesh units that a way of so many pixels is, right and down, at a point. */
  fromScreen(point, dx, dy) {
    const place = this.model.localToWorld(new THREE.Vector3(...point.map((x, i) => x - this.middle[i])));
    const depth = place.clone().sub(this.camera.position).dot(this.camera.getWorldDirection(new THREE.Vector3()));
    const perPixel = (2 * depth * Math.tan((this.camera.fov * Math.PI) / 360)) / this.parent.clientHeight;
    const right = new THREE.Vector3().setFromMatrixColumn(this.camera.matrixWorld, 0);
    const up = new THREE.Vector3().setFromMatrixColumn(this.camera.matrixWorld, 1);
    const way = right.multiplyScalar(dx * perPixel).addScaledVector(up, -dy * perPixel);
    return way.divideScalar(this.model.scale.x).toArray();
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.parent;
    this.renderer.setSize(width, height);
    this.camera.aspect = width / Math.max(height, 1);
    this.camera.updateProjectionMatrix();
    this.changed();
  }

  changed() {
    if (this.isDue) return;
    this.isDue = true;
    requestAnimationFrame(() => {
      this.isDue = false;
      this.renderer.render(this.scene, this.camera);
      for (const overlay of this.overlays) overlay();
    });
  }
}
