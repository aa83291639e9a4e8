// The page in a real browser: what it shows is what the program `ptet` says of the same request, to the bit; pointers
// move its controls; what goes wrong is said. Run by test.sh.
//
//   node page_test.js FILE.ptet PTET FOLDER    FOLDER: for what is made on the way, pictures among it
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { copyFileSync, mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import test, { after, before } from "node:test";
import { here, serve, settled, startBrowser } from "./browser.js";

const [file, ptet, folder] = process.argv.slice(2);
mkdirSync(folder, { recursive: true });
copyFileSync(file, join(folder, "mesh.ptet"));

const json = (...args) => JSON.parse(execFileSync(ptet, [...args, "--json"], { encoding: "utf8", maxBuffer: 1 << 26 }));
const info = json("info", file);
info.diagonal = Math.hypot(...info.box.max.map((high, i) => high - info.box.min[i]));
const at = (fraction) => info.box.min.map((low, i) => low + fraction[i] * (info.box.max[i] - low));

let server, browser, page;

before(async () => {
  server = await serve([folder]);
  browser = await startBrowser({ width: 1200, height: 800 });
  page = browser.page;
});
after(async () => {
  await browser.close();
  server.stop();
});

async function show(parameters, from = server) {
  const query = new URLSearchParams({ file: "mesh.ptet", ...parameters });
  await page.goto(`${from.url}index.html?${query}`);
  await settled(page);
}

const text = (id) => page.locator(`#${id}`).textContent();
const value = (id) => page.locator(`#${id}`).getAttribute("data-value").then(Number);
const problem = () => text("problem");

/** Clicks "Copy link", which puts the state into the address. */
async function parameters() {
  await page.click("#link");
  return new URL(page.url()).searchParams;
}

/** What the program makes of the request that the address tells. */
function extracted(query, name) {
  const output = join(folder, `${name}-program.vtu`);
  const args = [];
  if (query.get("error") !== "any") args.push("--field-error", `${100 * query.get("error")}%`);
  else if (query.get("boundary") === "any" && !query.get("focus")) args.push("--field-error", "100000000%");
  if (query.get("boundary") !== "any") args.push("--domain-error", `${100 * query.get("boundary")}%`);
  if (query.get("focus")) args.push("--focus", `box:${query.get("focus")}`);
  return { output, report: json("extract", file, "-o", output, ...args) };
}

/** The page's mesh and its numbers against the program's. */
async function checkAgainstProgram(name) {
  assert.equal(await problem(), "");
  const { output, report } = extracted(await parameters(), name);
  const saving = page.waitForEvent("download");
  await page.click("#save");
  const saved = join(folder, `${name}-page.vtu`);
  await (await saving).saveAs(saved);
  execFileSync("/usr/bin/python3", [join(here, "same_mesh.py"), saved, output], { stdio: "inherit" });
  assert.equal(await value("tets"), report.tets);
  for (const [field, error] of Object.entries(report.achieved.field_error))
    assert.equal(Number(await page.locator(`#errors [data-field="${field}"]`).getAttribute("data-error")), error);
  assert.equal(await value("domain-error"), report.achieved.domain_error);
  return report;
}

/** The fraction of the picture's pixels that have a colour: the background is grey. */
async function coloured(name) {
  const handles = page.locator(".handle");
  await handles.evaluateAll((all) => all.forEach((handle) => (handle.style.visibility = "hidden")));
  const picture = await page.locator("#view").screenshot({ path: join(folder, `${name}.png`) });
  await handles.evaluateAll((all) => all.forEach((handle) => (handle.style.visibility = "")));
  return page.evaluate(async (base64) => {
    const bytes = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
    const bitmap = await createImageBitmap(new Blob([bytes], { type: "image/png" }));
    const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d");
    context.drawImage(bitmap, 0, 0);
    const { data } = context.getImageData(0, 0, bitmap.width, bitmap.height);
    let count = 0;
    for (let i = 0; i < data.length; i += 4)
      if (Math.max(data[i], data[i + 1], data[i + 2]) - Math.min(data[i], data[i + 1], data[i + 2]) > 24) count += 1;
    return (4 * count) / data.length;
  }, picture.toString("base64"));
}

async function drag(locator, dx, dy) {
  const box = await locator.boundingBox();
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x + dx, y + dy, { steps: 8 });
  await page.mouse.up();
  await settled(page);
}

test("a link's requests give the program's meshes", async () => {
  const box = [...at([0.1, 0.2, 0.1]), ...at([0.4, 0.6, 0.5])].join(",");
  await show({ error: "0.05" });
  await checkAgainstProgram("error");
  await show({ error: "0.2", boundary: "0.005" });
  await checkAgainstProgram("boundary");
  await show({ error: "any", focus: box });
  const report = await checkAgainstProgram("focus");
  assert.ok(report.tets > info.base.tets);
  await show({ error: "0" });
  await checkAgainstProgram("exact");
});

test("a coarser mesh comes first, and only what is asked for is fetched", async () => {
  await page.addInitScript(() => {
    window.steps = [];
    document.addEventListener("DOMContentLoaded", () => {
      const watch = (id) => document.getElementById(id);
      new MutationObserver(() => window.steps.push([watch("tets").dataset.value, watch("limited-by").textContent])).observe(
        watch("time"),
        { childList: true },
      );
    });
  });
  await show({ error: "0.05" });
  const steps = await page.evaluate(() => window.steps);
  // The base, and what blocks lay near enough to it to be read with it.
  assert.equal(steps[0][1], "loading");
  assert.equal(steps.at(-1)[1], "error");
  assert.ok(info.base.tets <= Number(steps[0][0]) && Number(steps[0][0]) < Number(steps.at(-1)[0]), `${steps}`);
  const all = Number(await page.locator("#fetched").getAttribute("data-bytes"));
  await show({ error: "any" });
  const first = Number(await page.locator("#fetched").getAttribute("data-bytes"));
  assert.ok(first < all && all < info.file_bytes, `${first}, ${all} of ${info.file_bytes} bytes`);
});

test("the slider is dragged: finer, within the error, the program's mesh", async () => {
  await show({ error: "any" });
  const coarse = await value("tets");
  await drag(page.locator("#error"), -60, 0); // from its middle, where a press puts it
  const query = await parameters();
  const asked = Number(query.get("error"));
  assert.ok(asked > 0 && asked < 0.05, `error ${asked}`);
  assert.ok((await value("tets")) > coarse);
  const report = await checkAgainstProgram("slider");
  for (const field of info.fields.filter((f) => f.governing))
    assert.ok(report.achieved.field_error[field.name] <= asked * field.range * (1 + 1e-12));
});

test("the focus box is dragged by its handles", async () => {
  await show({ error: "any" });
  await page.check("#focus");
  await settled(page);
  const small = (await parameters()).get("focus").split(",").map(Number);
  const tets = await value("tets");
  await drag(page.getByLabel("focus box, high x side"), 60, 0);
  const wide = (await parameters()).get("focus").split(",").map(Number);
  assert.ok(wide[3] > small[3], `${small} became ${wide}`);
  assert.deepEqual([...wide.slice(0, 3), ...wide.slice(4)], [...small.slice(0, 3), ...small.slice(4)]);
  assert.ok((await value("tets")) > tets);
  await checkAgainstProgram("handle");
  await drag(page.getByLabel("focus box", { exact: true }), -30, 20);
  const moved = (await parameters()).get("focus").split(",").map(Number);
  for (let axis = 0; axis < 3; ++axis) {
    const [before, behind] = [wide[axis + 3] - wide[axis], moved[axis + 3] - moved[axis]];
    assert.ok(Math.abs(before - behind) < 1e-9 * info.diagonal);
  }
  assert.ok(moved[2] < wide[2], "down on the screen is down");
  await checkAgainstProgram("moved");
  await page.screenshot({ path: join(folder, "page.png") });
});

test("every kind of picture draws something of its own", async () => {
  const shares = {};
  for (const what of ["", "surface", "surface,cut,edges", "slice", "isosurface", "surface,slice,translucent"]) {
    await show({ error: "0.02", show: what });
    shares[what] = await coloured(`picture-${what.replaceAll(",", "-") || "none"}`);
  }
  assert.equal(shares[""], 0);
  for (const [what, share] of Object.entries(shares)) assert.ok(what === "" || share > 0.01, `${what}: ${share}`);
  assert.ok(shares.slice < shares.surface && shares.isosurface < shares.surface, JSON.stringify(shares));
  await drag(page.locator("#view canvas"), 120, 30);
  assert.ok((await coloured("turned")) > 0.01);
});

test("a file from the disk needs no server", async () => {
  await page.goto(`${server.url}index.html`);
  await page.setInputFiles("#disk", file);
  await page.waitForFunction(() => document.body.dataset.state === "done");
  await checkAgainstProgram("disk");
});

test("a mesh without fields is shown, and its boundary error stated", async () => {
  await show({ file: "bare.ptet", boundary: "0" });
  assert.equal(await problem(), "");
  assert.equal(await page.locator("#errors [data-field]").count(), 0);
  assert.equal(await value("domain-error"), 0);
  const report = json("extract", join(folder, "bare.ptet"), "-o", join(folder, "bare-program.vtu"), "--domain-error", "0");
  assert.equal(await value("tets"), report.tets);
  assert.ok(report.tets > 0);
});

test("what cannot be opened says why", async () => {
  const bytes = readFileSync(file);
  writeFileSync(join(folder, "other.ptet"), "This is no such file. ".repeat(40));
  writeFileSync(join(folder, "empty.ptet"), "");
  writeFileSync(join(folder, "short.ptet"), bytes.subarray(0, bytes.length - 10000));
  const expected = {
    "nowhere.ptet": /There is no file at .*nowhere\.ptet \(404\)/,
    "other.ptet": /not a \.ptet file/,
    "empty.ptet": /empty/,
    "short.ptet": /corrupt/,
    "http://127.0.0.1:1/x.ptet": /cannot be reached/,
  };
  for (const [name, pattern] of Object.entries(expected)) {
    await show({ file: name });
    assert.match(await problem(), pattern);
    assert.ok(await page.locator("#problem").isVisible());
  }
  const without = await serve([folder], ["--no-ranges"]);
  await show({}, without);
  without.stop();
  assert.match(await problem(), /does not answer range requests/);
});

test("damaged blocks make the mesh coarser, and the page says so", async () => {
  const bytes = readFileSync(file);
  for (let place = Math.floor(bytes.length * 0.6); place < bytes.length * 0.62; ++place) bytes[place] ^= 0x55;
  writeFileSync(join(folder, "damaged.ptet"), bytes);
  await show({ file: "damaged.ptet", error: "0" });
  assert.match(await text("state"), /Coarser than asked: .*damaged/);
  const tets = await value("tets");
  assert.ok(tets > info.base.tets && tets < info.tets, `${tets} tets`);
});

test("a server that goes away, and comes back", async () => {
  const own = await serve([folder]);
  await show({ error: "any" }, own);
  own.stop();
  await page.locator("#error").fill("20");
  await page.waitForFunction(() => document.getElementById("state").textContent.includes("cannot be reached"));
  const again = await serve([folder], ["--port", new URL(own.url).port]);
  await page.click("#retry");
  await settled(page);
  assert.equal(await text("state"), "");
  await checkAgainstProgram("again");
  again.stop();
});

test("a browser without WebGL is told so", async () => {
  const blind = await startBrowser({ width: 800, height: 600, extra: ["--disable-3d-apis"] });
  await blind.page.goto(`${server.url}index.html?file=mesh.ptet`);
  await settled(blind.page);
  assert.match(await blind.page.locator("#problem").textContent(), /no WebGL 2/);
  await blind.close();
});
