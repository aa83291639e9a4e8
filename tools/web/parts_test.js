// Parts of the page without a browser and without the library: the file it saves, as VTK reads it; the worker's answers
// when something is thrown; the page with a file that has no fields.
//
//   node parts_test.js        needs /usr/bin/python3 with VTK
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { copyFileSync, mkdtempSync, readdirSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import test, { after } from "node:test";
import { fileURLToPath, pathToFileURL } from "node:url";
import { writeVtu } from "./page/vtu.js";

const here = dirname(fileURLToPath(import.meta.url));
const folder = mkdtempSync(join(tmpdir(), "ptet-parts-"));
after(() => rmSync(folder, { recursive: true, force: true }));
writeFileSync(join(folder, "package.json"), '{ "type": "module" }');

/** A module of the page, with others in place of some that it imports. */
function load(name, others) {
  const parts = mkdtempSync(join(folder, "page-"));
  for (const file of readdirSync(join(here, "page"))) copyFileSync(join(here, "page", file), join(parts, file));
  for (const [file, text] of Object.entries(others)) writeFileSync(join(parts, file), text);
  return import(pathToFileURL(join(parts, name)));
}

function turn() {
  return new Promise((resolve) => setTimeout(resolve, 20));
}

// ---- the file that is saved ----

const kRead = `
import json, sys
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader
reader = vtkXMLUnstructuredGridReader()
reader.SetFileName(sys.argv[1])
reader.Update()
grid = reader.GetOutput()
points = grid.GetPoints().GetData()
data = grid.GetPointData()
print(json.dumps({"type": points.GetDataTypeAsString(), "points": vtk_to_numpy(points).tolist(),
                  "tets": vtk_to_numpy(grid.GetCells().GetConnectivityArray()).tolist(),
                  "names": [data.GetArrayName(i) for i in range(data.GetNumberOfArrays())]}))`;

async function saved(positions, type, names) {
  const path = join(folder, "saved.vtu");
  const arrays = names.map((name) => ({
    name,
    type: "float64",
    components: 1,
    bytes: new Uint8Array(new Float64Array([1, 2, 3, 4]).buffer),
  }));
  const blob = writeVtu({
    positions: { name: "", type, components: 3, bytes: new Uint8Array(positions.buffer) },
    arrays,
    tets: new Uint32Array([0, 1, 2, 3]),
  });
  writeFileSync(path, Buffer.from(await blob.arrayBuffer()));
  return JSON.parse(execFileSync("/usr/bin/python3", ["-c", kRead, path], { encoding: "utf8" }));
}

test("positions of every type are saved as they are", async () => {
  const rows = [0, 0, 0, 10, 0, 0, 0, 10, 0, 0, 0, 10];
  for (const [Type, name, inVtk] of [
    [Int8Array, "int8", "signed char"],
    [Uint16Array, "uint16", "unsigned short"],
    [Int32Array, "int32", "int"],
    [Float32Array, "float32", "float"],
    [Float64Array, "float64", "double"],
  ]) {
    const found = await saved(new Type(rows), name, ["f"]);
    assert.equal(found.type, inVtk);
    assert.deepEqual(found.points.flat(), rows, name);
    assert.deepEqual(found.tets, [0, 1, 2, 3]);
  }
});

test("names that XML has no form for do not spoil the file", async () => {
  const names = ["a\u0001b", "c\ud83d\ude00\t<&\">", "plain"];
  const found = await saved(new Float64Array(12), "float64", names);
  assert.deepEqual(found.names, ["a\ufffdb", names[1], "plain"]);
});

// ---- the worker ----

const kLibrary = `
export default async () => ({
  Viewer: class {
    open() { return { fields: [] }; }
    update() { if (globalThis.updateThrows) throw globalThis.updateThrows; return { complete: true }; }
    draw() { if (globalThis.drawThrows) throw globalThis.drawThrows; return { range: [0, 1] }; }
  },
});`;

test("what is thrown while a picture is made is told, and the next one is made", async () => {
  const told = [];
  const unhandled = [];
  const note = (error) => unhandled.push(error);
  process.on("unhandledRejection", note);
  globalThis.self = { postMessage: (message) => told.push(message) };
  try {
    await load("worker.js", { "ptet.js": kLibrary });
    const blob = new Blob([new Uint8Array(5000)]);
    await self.onmessage({ data: { open: blob } });
    const show = async (id) => {
      told.length = 0;
      await self.onmessage({ data: { show: { request: {}, drawing: {}, id } } });
      await turn();
      return told.filter((message) => !message.fetched);
    };
    globalThis.drawThrows = new RangeError("Array buffer allocation failed");
    assert.deepEqual(await show(1), [{ failed: "RangeError: Array buffer allocation failed" }]);
    globalThis.drawThrows = null;
    globalThis.updateThrows = 5271; // as of C++, uncaught
    assert.deepEqual(await show(2), [{ failed: "Error: 5271" }]);
    globalThis.updateThrows = null;
    const answers = await show(3);
    assert.equal(answers.length, 1);
    assert.equal(answers[0].answer.id, 3);
    assert.deepEqual(unhandled, []);
  } finally {
    process.off("unhandledRejection", note);
    delete globalThis.self;
  }
});

// ---- the page ----

/** As much of a document as the page's module touches. */
function standIn() {
  const element = () => ({
    dataset: {},
    style: {},
    handlers: {},
    files: [],
    value: "",
    classList: { toggle() {} },
    addEventListener(event, f) {
      this.handlers[event] = f;
    },
    replaceChildren(...children) {
      this.children = children;
    },
    append() {},
  });
  const elements = {};
  return {
    body: element(),
    getElementById: (id) => (elements[id] ??= element()),
    addEventListener() {},
    createElement: element,
  };
}

test("a file without fields is drawn, and a link to it made", async () => {
  const posted = [];
  let worker, address;
  for (const [name, value] of Object.entries({
    document: standIn(),
    location: { search: "?file=mesh.ptet", href: "http://here/", origin: "http://here", pathname: "/" },
    history: { replaceState: (state, title, url) => (address = url) },
    requestAnimationFrame: (f) => f(),
    Option: class {},
    navigator: {},
    Worker: class {
      constructor() {
        worker = this;
      }
      postMessage(message) {
        posted.push(message);
      }
      terminate() {}
    },
  }))
    Object.defineProperty(globalThis, name, { value, configurable: true, writable: true });
  await load("main.js", {
    "scene.js": `export const colourGradient = "";
      export class Scene { cameraPlace = [0, 0, 0, 1, 1, 1]; setStyle() {} setBox() {} setColourRange() {} show() {} lookFrom() {} }`,
    "focus-box.js": "export class FocusBox { min = [0, 0, 0]; max = [1, 1, 1]; set() {} show() {} }",
  });
  const opened = { tets: 1, vertices: 4, boxMin: [0, 0, 0], boxMax: [1, 1, 1], diagonal: 1.7, fields: [] };
  worker.onmessage({ data: { opened } });
  const { show } = posted.at(-1);
  assert.equal(show.drawing.field, null);
  assert.equal(show.drawing.surface, true);
  const mesh = {
    tets: 1,
    vertices: 4,
    fieldError: [],
    rmsError: [],
    domainError: 0,
    milliseconds: 1,
    drawMilliseconds: 1,
    limitedBy: "nothing",
    damaged: [],
    complete: true,
  };
  worker.onmessage({ data: { answer: { id: show.id, mesh, picture: { range: [Infinity, -Infinity] } } } });
  assert.equal(document.body.dataset.state, "done");
  assert.equal(document.getElementById("legend").style.visibility, "hidden");
  await document.getElementById("link").handlers.click();
  assert.equal(new URL(address).searchParams.get("file"), "mesh.ptet");
  assert.equal(new URL(address).searchParams.get("field"), "");
});
