// The bytes of a file that is read in parts: over HTTP by range requests, or from the user's own disk.
//
//   wasm --read(offset, bytes)--> there: filled, true     not there: noted, false
//   worker --fetchMissing()-----> what was noted since beginPass() is fetched, coarse parts (those in front) first
//
// Parts are kept until a pass misses nothing: then all that was asked for has been decoded.

const kGap = 8192; // ranges so near to one another are fetched by one request
const kLongest = 1 << 19; // bytes a request, so that something is shown before all is there
const kAtOnce = 6; // requests at a time
const kFirst = 4096; // bytes of the first request, which tells the size

/** An error to show as it is. */
export class SourceError extends Error {}

class HttpFile {
  constructor(url) {
    this.url = url;
  }

  async fetch(begin, end) {
    const stop = new AbortController();
    let response;
    try {
      response = await fetch(this.url, { headers: { Range: `bytes=${begin}-${end - 1}` }, signal: stop.signal });
    } catch (error) {
      throw new SourceError(
        `${this.url} cannot be reached: the network or the server is down, or the server is another one than that of ` +
          `this page and does not allow it (CORS). (${error.message})`,
      );
    }
    if (response.status !== 206) {
      stop.abort(); // the body may be the whole file
      if (response.status === 404) throw new SourceError(`There is no file at ${this.url} (404).`);
      if (response.status === 416) throw new SourceError(`The file at ${this.url} is empty, or shorter than it was.`);
      if (response.ok)
        throw new SourceError(
          `The server of ${this.url} does not answer range requests, so only the whole file could be fetched. ` +
            `Use one that does: tools/web/serve.py, nginx, Apache, any object store.`,
        );
      throw new SourceError(`The server answered ${response.status} ${response.statusText} for ${this.url}.`);
    }
    const range = /^bytes (\d+)-\d+\/(\d+)$/.exec(response.headers.get("Content-Range") ?? "");
    if (!range)
      throw new SourceError(`The server of ${this.url} does not say how long the file is (Content-Range is missing).`);
    const mark = response.headers.get("ETag") ?? response.headers.get("Last-Modified");
    const size = Number(range[2]);
    if (this.size !== undefined && (size !== this.size || mark !== this.mark))
      throw new SourceError(`${this.url} has changed on the server. Open it again.`);
    this.size = size;
    this.mark = mark;
    const bytes = new Uint8Array(await response.arrayBuffer());
    if (Number(range[1]) !== begin || bytes.length !== Math.min(end, size) - begin)
      throw new SourceError(`The server of ${this.url} answered with other bytes than it was asked for.`);
    return bytes;
  }

  /** The size, and the first bytes, which the library wants anyway. */
  async open() {
    const bytes = await this.fetch(0, kFirst);
    return { size: this.size, bytes };
  }
}

class LocalFile {
  constructor(blob) {
    this.blob = blob;
  }

  async fetch(begin, end) {
    try {
      return new Uint8Array(await this.blob.slice(begin, end).arrayBuffer());
    } catch (error) {
      throw new SourceError(`${this.blob.name} cannot be read any more. (${error.message})`);
    }
  }

  async open() {
    return { size: this.blob.size, bytes: await this.fetch(0, Math.min(kFirst, this.blob.size)) };
  }
}

/** Sorted, overlapping and near ones (up to `gap` apart) made one. */
function united(ranges, gap) {
  const result = [];
  for (const [begin, end] of [...ranges].sort((a, b) => a[0] - b[0])) {
    const last = result.at(-1);
    if (last && begin <= last[1] + gap) last[1] = Math.max(last[1], end);
    else result.push([begin, end]);
  }
  return result;
}

export class RangeSource {
  /** `file`: a URL, or a File of the user's. `changed()` is called when bytes came or could not be had. */
  constructor(file, changed) {
    this.file = typeof file === "string" ? new HttpFile(file) : new LocalFile(file);
    this.changed = changed;
    this.parts = []; // { begin, end, bytes }
    this.missing = [];
    this.queue = [];
    this.underWay = new Map(); // begin -> end
    this.bytesFetched = 0;
    this.requests = 0;
    this.failure = null;
  }

  async open() {
    this.requests += 1;
    const { size, bytes } = await this.file.open();
    this.size = size;
    this.keep(0, bytes);
  }

  keep(begin, bytes) {
    this.bytesFetched += bytes.length;
    this.parts.push({ begin, end: begin + bytes.length, bytes });
  }

  /** For the library: fills `into` or answers false. */
  read(offset, into) {
    const end = offset + into.length;
    for (let at = offset; at < end; ) {
      const part = this.parts.find((p) => p.begin <= at && at < p.end);
      if (!part) {
        this.missing.push([offset, end]);
        return false;
      }
      const to = Math.min(end, part.end);
      into.set(part.bytes.subarray(at - part.begin, to - part.begin), at - offset);
      at = to;
    }
    return true;
  }

  beginPass() {
    this.missing = [];
  }

  /** Whether bytes are still to come for what the last pass asked. */
  get isLoading() {
    return this.queue.length > 0 || this.underWay.size > 0;
  }

  /** After a pass: asks for what it missed, and for nothing else any more. `again`: also after a failure. */
  fetchMissing(again) {
    if (again) this.failure = null;
    this.queue = [];
    if (this.missing.length === 0) {
      if (this.underWay.size === 0) this.parts = [];
      return;
    }
    if (this.failure) return;
    const there = united([...this.parts.map((part) => [part.begin, part.end]), ...this.underWay], 0);
    const wanted = [];
    for (let [begin, end] of united(this.missing, 0)) {
      for (const [from, to] of there) {
        if (to <= begin || from >= end) continue;
        if (from > begin) wanted.push([begin, from]);
        begin = Math.max(begin, to);
        if (begin >= end) break;
      }
      if (begin < end) wanted.push([begin, end]);
    }
    for (const [begin, end] of united(wanted, kGap))
      for (let from = begin; from < end; from += kLongest) this.queue.push([from, Math.min(end, from + kLongest)]);
    this.startNext();
  }

  startNext() {
    while (this.underWay.size < kAtOnce && this.queue.length > 0) {
      const [begin, end] = this.queue.shift();
      this.underWay.set(begin, end);
      this.requests += 1;
      this.file
        .fetch(begin, end)
        .then((bytes) => this.keep(begin, bytes))
        .catch((error) => {
          this.failure = error;
          this.queue = [];
        })
        .finally(() => {
          this.underWay.delete(begin);
          this.startNext();
          this.changed();
        });
    }
  }
}
