// The page: controls -> state -> worker -> picture and numbers. The state is also what a link holds:
//   ?file=URL&error=0.05&boundary=0.01&focus=x,y,z,x,y,z&field=NAME&show=cut,edges&axis=y&plane=0.5&flip=1&level=0.5
//    &camera=...
import { briefUp, percentUp } from "./brief-up.js";
import { FocusBox } from "./focus-box.js";
import { Scene, colourGradient } from "./scene.js";

const $ = (id) => document.getElementById(id);
const kAnything = 1e6; // an error that any mesh keeps
const kSteps = 60; // of a slider between its ends
const kParts = ["surface", "cut", "slice", "isosurface", "edges", "translucent"];

let scene, focusBox, worker, info;
let fileName = "mesh";
let fileUrl = null;
let lastId = 0;
let seen = []; // by field: least and greatest value met so far

const state = {
  error: 0.1, // fraction of the fields' ranges; Infinity: any
  boundary: Infinity, // of the diagonal
  focus: false,
  field: 0,
  show: new Set(["surface", "cut", "edges"]),
  axis: 1,
  plane: 0.5, // of the box
  flip: true, // so that the first view looks at the cut
  level: 0.5, // of the range
};

// ---- sliders of errors: 0 at the left, anything at the right, tenfold every third between ----

function toSlider(bound, least) {
  if (bound === 0) return 0;
  if (bound === Infinity) return kSteps + 1;
  return Math.min(kSteps, Math.max(1, Math.round(1 + (Math.log10(bound / least) * (kSteps - 1)) / 3)));
}
function fromSlider(place, least) {
  if (place === 0) return 0;
  if (place > kSteps) return Infinity;
  return Number((least * 10 ** ((3 * (place - 1)) / (kSteps - 1))).toPrecision(2));
}
const kBounds = { error: 1e-3, boundary: 1e-4 };

function percent(fraction) {
  return `${(100 * fraction).toPrecision(fraction >= 0.9995 ? 4 : 3).replace(/\.?0+$/, "")} %`;
}
function brief(number) {
  return Number(number.toPrecision(4)).toString();
}
function count(number) {
  return number.toLocaleString("en");
}
function size(bytes) {
  return bytes < 1e6 ? `${(bytes / 1e3).toFixed(0)} kB` : `${(bytes / 1e6).toFixed(2)} MB`;
}

// ---- what is shown of the state ----

function showState() {
  for (const name of ["error", "boundary"]) {
    $(name).value = toSlider(state[name], kBounds[name]);
    const bound = state[name];
    $(`${name}-value`).value = bound === Infinity ? "any" : bound === 0 ? "0: the original" : percent(bound);
  }
  $("boundary-value").value = $("boundary-value").value.replace(": the original", "");
  $("focus").checked = state.focus;
  $("field").selectedIndex = state.field;
  $("axis").selectedIndex = state.axis;
  $("plane").value = state.plane;
  $("level").value = state.level;
  for (const part of kParts) $(part).checked = state.show.has(part);
  $("cut").disabled = !state.show.has("surface");
  scene.setStyle({ edges: state.show.has("edges"), translucent: state.show.has("translucent") });
  focusBox.show(state.focus);
}

function showRange() {
  $("legend").style.visibility = info?.fields.length === 0 ? "hidden" : "";
  const [least, greatest] = seen[state.field] ?? [0, 1];
  $("least").textContent = brief(least);
  $("greatest").textContent = brief(greatest);
  $("level-value").value = brief(level());
  scene.setColourRange(least, greatest);
}

function level() {
  const [least, greatest] = seen[state.field] ?? [0, 1];
  return least + state.level * (greatest - least);
}

function plane() {
  const normal = [0, 0, 0];
  const [low, high] = [info.boxMin[state.axis], info.boxMax[state.axis]];
  const sign = state.flip ? -1 : 1;
  normal[state.axis] = sign;
  return { normal, offset: sign * (low + state.plane * (high - low)) };
}

// ---- to and from the worker ----

// With nothing asked at all the answer would be the original.
function fieldBound() {
  if (state.error < Infinity) return state.error;
  return state.focus || state.boundary < Infinity ? null : kAnything;
}

let isAsking = false;
function ask() {
  if (!info || isAsking) return;
  isAsking = true;
  document.body.dataset.state = "busy";
  requestAnimationFrame(() => {
    isAsking = false;
    const request = {
      fieldError: fieldBound(),
      domainError: state.boundary === Infinity ? null : state.boundary,
      focus: state.focus ? { min: [...focusBox.min], max: [...focusBox.max] } : null,
    };
    const drawing = {
      field: info.fields.length > 0 ? state.field : null,
      surface: state.show.has("surface"),
      cut: state.show.has("cut") ? plane() : null,
      slice: state.show.has("slice") ? plane() : null,
      isosurface: state.show.has("isosurface") && seen[state.field] ? { field: state.field, level: level() } : null,
    };
    lastId += 1;
    worker.postMessage({ show: { request, drawing, id: lastId } });
  });
}

function fail(message) {
  $("problem").textContent = message;
  $("problem").hidden = false;
  document.body.dataset.state = "failed";
}

/** `file`: a URL or a File. `place`: parameters of a link. */
function open(file, place = new URLSearchParams()) {
  worker?.terminate();
  info = null;
  seen = [];
  $("controls").disabled = true;
  $("problem").hidden = true;
  $("fetched").textContent = "";
  document.body.dataset.state = "opening";
  fileUrl = typeof file === "string" ? file : null;
  fileName = (fileUrl ? new URL(file, location.href).pathname.split("/").pop() : file.name).replace(/\.ptet$/, "");
  worker = new Worker("worker.js", { type: "module" });
  worker.onerror = (event) => fail(`The library could not be started in this browser: ${event.message ?? "no message"}`);
  worker.onmessage = ({ data }) => {
    if (data.opened) opened(data.opened, place);
    if (data.fetched) showFetched(data.fetched);
    if (data.answer) answered(data.answer);
    if (data.saved) download(data.saved);
    if (data.failed) fail(data.failed);
  };
  worker.postMessage({ open: fileUrl ? new URL(file, location.href).href : file });
}

function opened(description, place) {
  info = description;
  $("controls").disabled = false;
  $("field").replaceChildren(
    ...info.fields.map((field) => new Option(field.components > 1 ? `${field.name} (length)` : field.name)),
  );
  scene.setBox(info.boxMin, info.boxMax, info.diagonal);
  const near = (fraction) => info.boxMin.map((low, i) => low + fraction * (info.boxMax[i] - low));
  focusBox.set(near(0.375), near(0.625), info.diagonal);
  const governing = info.fields.findIndex((field) => field.governing);
  state.field = Math.max(governing, 0);
  $("errors").replaceChildren(...info.fields.filter((field) => field.governing).map(errorRow));
  follow(place);
  showState();
  ask();
}

function errorRow(field) {
  const row = document.createElement("tr");
  row.append(document.createElement("th"), document.createElement("td"));
  row.firstChild.textContent = field.name;
  row.dataset.field = field.name;
  return row;
}

function showFetched({ bytes, of, requests }) {
  $("fetched").textContent = `${size(bytes)}, ${percent(bytes / of)} of the file, in ${requests} requests`;
  Object.assign($("fetched").dataset, { bytes, of, requests });
}

function describe(mesh) {
  const share = (of) => (of === 0 ? "" : ` (${percent(of)})`);
  const shareUp = (of) => (of === 0 ? "" : ` (${percentUp(of)})`); // what is stated is a bound
  $("tets").textContent = count(mesh.tets) + share(mesh.tets / info.tets);
  $("tets").dataset.value = mesh.tets;
  $("vertices").textContent = count(mesh.vertices) + share(mesh.vertices / info.vertices);
  info.fields
    .filter((field) => field.governing)
    .forEach((field, i) => {
      const { dataset, lastChild: cell } = $("errors").children[i];
      const text = (value) => briefUp(value) + shareUp(field.range > 0 ? value / field.range : 0);
      cell.textContent = text(mesh.fieldError[i]);
      dataset.error = mesh.fieldError[i];
      if (mesh.rmsError.length === 0) return;
      cell.append(document.createElement("br"), `RMS ${text(mesh.rmsError[i])}`);
      dataset.rms = mesh.rmsError[i];
    });
  $("domain-error").textContent = `${briefUp(mesh.domainError)}${shareUp(mesh.domainError / info.diagonal)}`;
  $("domain-error").dataset.value = mesh.domainError;
  $("limited-by").textContent = mesh.isLoading ? "loading" : mesh.limitedBy;
  $("time").textContent =
    `${mesh.milliseconds.toFixed(1)} ms for the mesh, ` + `${mesh.drawMilliseconds.toFixed(1)} ms for the picture`;
  const text = mesh.isLoading
    ? "Still loading: coarser than asked so far. The errors are those of this mesh."
    : mesh.failure
      ? `Coarser than asked: ${mesh.failure}`
      : mesh.damaged.length > 0
        ? `Coarser than asked: ${mesh.damaged.length === 1 ? "a block of the file is" : `${mesh.damaged.length} blocks of the file are`} damaged. ${mesh.damaged[0]}`
        : mesh.complete
          ? ""
          : "Coarser than asked: there is not enough memory in the page for more.";
  $("state").textContent = text;
  $("state").classList.toggle("is-warning", !mesh.isLoading && text !== "");
  $("retry").hidden = !mesh.failure;
}

function answered({ id, mesh, picture }) {
  $("problem").hidden = true;
  const [least, greatest] = picture.range;
  const before = seen[state.field];
  if (least <= greatest)
    seen[state.field] = before ? [Math.min(before[0], least), Math.max(before[1], greatest)] : [least, greatest];
  describe(mesh);
  showRange();
  scene.show(picture);
  if (!before && state.show.has("isosurface")) ask();
  if (id === lastId && !isAsking) document.body.dataset.state = mesh.isLoading ? "loading" : "done";
}

function download(blob) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = `${fileName}.vtu`;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60000);
}

// ---- links ----

function numbers(text, howMany) {
  const list = text ? text.split(",").map(Number) : [];
  return list.length === howMany && list.every(Number.isFinite) ? list : null;
}

function follow(place) {
  const bound = (name) => {
    const text = place.get(name);
    if (text === "any") state[name] = Infinity;
    else if (text !== null && Number(text) >= 0) state[name] = Number(text);
  };
  bound("error");
  bound("boundary");
  const box = numbers(place.get("focus"), 6);
  if (box) focusBox.set(box.slice(0, 3), box.slice(3), info.diagonal);
  if (box) state.focus = true;
  const field = info.fields.findIndex((f) => f.name === place.get("field"));
  if (field >= 0) state.field = field;
  if (place.has("show")) state.show = new Set(place.get("show").split(","));
  if (place.has("axis")) state.axis = Math.max(0, ["x", "y", "z"].indexOf(place.get("axis")));
  for (const name of ["plane", "level"])
    if (numbers(place.get(name), 1)) state[name] = Math.min(1, Math.max(0, Number(place.get(name))));
  if (place.has("flip")) state.flip = place.get("flip") === "1";
  const camera = numbers(place.get("camera"), 6);
  if (camera) scene.cameraPlace = camera;
  else scene.lookFrom([0.55, -0.75, 0.37]);
}

function linkToHere() {
  const place = new URLSearchParams({
    file: fileUrl ?? "",
    error: state.error === Infinity ? "any" : state.error,
    boundary: state.boundary === Infinity ? "any" : state.boundary,
    field: info.fields[state.field]?.name ?? "",
    show: [...state.show].join(","),
    axis: "xyz"[state.axis],
    plane: state.plane,
    flip: state.flip ? 1 : 0,
    level: state.level,
    camera: scene.cameraPlace.map((x) => Number(x.toPrecision(5))).join(","),
  });
  if (state.focus) place.set("focus", [...focusBox.min, ...focusBox.max].join(","));
  return `${location.origin}${location.pathname}?${place}`;
}

// ---- controls ----

function connect() {
  const onChange = (id, event, change) =>
    $(id).addEventListener(event, () => {
      change($(id));
      showState();
      showRange();
      ask();
    });
  for (const name of ["error", "boundary"])
    onChange(name, "input", (slider) => (state[name] = fromSlider(Number(slider.value), kBounds[name])));
  onChange("focus", "change", (box) => (state.focus = box.checked));
  onChange("field", "change", (list) => (state.field = list.selectedIndex));
  onChange("axis", "change", (list) => (state.axis = list.selectedIndex));
  onChange("plane", "input", (slider) => (state.plane = Number(slider.value)));
  onChange("level", "input", (slider) => (state.level = Number(slider.value)));
  onChange("flip", "click", () => (state.flip = !state.flip));
  for (const part of kParts)
    onChange(part, "change", (box) => (box.checked ? state.show.add(part) : state.show.delete(part)));
  $("open").addEventListener("submit", (event) => {
    event.preventDefault();
    if ($("url").value.trim() !== "") open($("url").value.trim());
  });
  $("disk").addEventListener("change", () => {
    if ($("disk").files.length > 0) open($("disk").files[0]);
  });
  $("save").addEventListener("click", () => worker.postMessage({ save: true }));
  $("retry").addEventListener("click", () => {
    document.body.dataset.state = "busy";
    worker.postMessage({ retry: true });
  });
  $("link").addEventListener("click", async () => {
    history.replaceState(null, "", linkToHere());
    await navigator.clipboard?.writeText(location.href).catch(() => {});
    $("link").textContent = "It is in the address bar";
    setTimeout(() => ($("link").textContent = "Copy link"), 2000);
  });
  document.addEventListener("dragover", (event) => event.preventDefault());
  document.addEventListener("drop", (event) => {
    event.preventDefault();
    if (event.dataTransfer.files.length > 0) open(event.dataTransfer.files[0]);
  });
}

function start() {
  $("colours").style.background = colourGradient;
  try {
    scene = new Scene($("view"));
  } catch (error) {
    $("open").inert = true;
    fail(
      `This browser cannot draw here: it has no WebGL 2. Is hardware acceleration off, or the graphics driver blocked? ` +
        `(${error.message})`,
    );
    return;
  }
  focusBox = new FocusBox(scene, ask);
  connect();
  const place = new URLSearchParams(location.search);
  if (!place.get("file")) return;
  $("url").value = place.get("file");
  open(place.get("file"), place);
}

start();
