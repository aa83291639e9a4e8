// Off the page's thread: the library, the file's bytes and the loop that goes from what is wanted to what is shown.
//
//   wanted -> update with the blocks that are there -> triangles -> page
//      ^------ blocks that were missing come in <- fetch
//
// from the page  { open: URL or File }, { show: { request, drawing, id } }, { save: true }, { retry: true }
// to the page    { opened }, { answer }, { fetched }, { saved }, { failed: message }
import createModule from "./ptet.js";
import { RangeSource, SourceError } from "./range-source.js";
import { writeVtu } from "./vtu.js";

let viewer, source;
let wanted = null; // { request, drawing, id }
let isStale = false; // something came in since the last pass
let isRunning = false;
let mayRetry = true;

const kBetweenPictures = 150; // ms, while blocks come in

function tell(message, transfer = []) {
  self.postMessage(message, transfer);
}

function tellFetched() {
  tell({ fetched: { bytes: source.bytesFetched, of: source.size, requests: source.requests } });
}

function report(error) {
  tell({ failed: error instanceof SourceError ? error.message : `${error.name ?? "Error"}: ${error.message ?? error}` });
}

/** A turn for messages that are waiting. */
function pause(milliseconds) {
  return new Promise((resolve) => setTimeout(resolve, milliseconds));
}

/** Calls the library until it has all the bytes it wants; what it answers then. */
async function untilThere(call) {
  while (true) {
    source.beginPass();
    const result = call();
    if (result.error !== "io") return result;
    if (source.failure) throw source.failure;
    const came = new Promise((resolve) => (source.changed = resolve));
    source.fetchMissing(false);
    await came;
    tellFetched();
  }
}

async function open(file) {
  const module = await createModule();
  viewer = new module.Viewer();
  source = new RangeSource(file, () => {});
  await source.open();
  const info = await untilThere(() => viewer.open(source, source.size));
  if (info.error) throw new SourceError(info.message);
  source.changed = () => {
    tellFetched();
    isStale = true;
    run();
  };
  tellFetched();
  tell({ opened: info });
}

function pass() {
  const { request, drawing, id } = wanted;
  source.beginPass();
  const answer = viewer.update(request);
  if (answer.error) return { failed: answer.message };
  source.fetchMissing(mayRetry);
  mayRetry = false;
  const begin = performance.now();
  const picture = viewer.draw(drawing);
  if (picture.error) return { failed: picture.message };
  answer.drawMilliseconds = performance.now() - begin;
  answer.isLoading = !answer.complete && source.isLoading;
  answer.failure = answer.complete ? null : (source.failure?.message ?? null);
  return { answer: { id, mesh: answer, picture } };
}

function buffersOf(picture) {
  return ["surface", "slice", "isosurface"].flatMap((name) =>
    picture[name] ? Object.values(picture[name]).map((array) => array.buffer) : [],
  );
}

async function run() {
  if (isRunning || !wanted) return;
  isRunning = true;
  try {
    while (isStale) {
      isStale = false;
      const result = pass();
      tell(result, result.answer ? buffersOf(result.answer.picture) : []);
      await pause(result.answer?.mesh.isLoading ? kBetweenPictures : 0);
    }
  } catch (error) {
    report(error); // nobody waits for this function
  } finally {
    isRunning = false;
  }
}

function ask() {
  isStale = true;
  mayRetry = true; // whoever asks anew may have the network back
  run();
}

self.onmessage = async ({ data }) => {
  try {
    if (data.open) await open(data.open);
    if (data.show) {
      wanted = data.show;
      ask();
    }
    if (data.retry) ask();
    if (data.save) {
      const mesh = viewer.mesh();
      if (mesh.error) throw new SourceError(mesh.message);
      tell({ saved: writeVtu(mesh) });
    }
  } catch (error) {
    report(error);
  }
};
