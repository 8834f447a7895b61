// Beside the page: runs the library, one request after the other. In: the library once, then { id, request, files };
// out: { id, progress } on the way, then { id, answer, heldMb } or { id, failure, heldMb }.
"use strict";
const [decoder, encoder] = [new TextDecoder(), new TextEncoder()];
// Of WebAssembly's 4 GB, what a log's rows and its answer need beside the files.
const FILES_MAX = 1e9;
let library, notStarted, current, failure;

// Places above 2 GB come out of WebAssembly as negative numbers.
const bytesAt = (at, length) => new Uint8Array(library.memory.buffer, at >>> 0, length >>> 0);

function said(at, length) {
  const what = JSON.parse(decoder.decode(bytesAt(at, length)));
  if (what.failure) failure = what.failure;
  else postMessage({ id: current, progress: what });
}

function give(bytes) {
  const at = library.room_for(bytes.length);
  bytesAt(at, bytes.length).set(bytes);
}

async function answer({ id, request, files }) {
  current = id;
  failure = undefined;
  const heldMb = () => Math.round((library?.memory.buffer.byteLength ?? 0) / 1e6);
  try {
    const size = files.reduce((sum, file) => sum + file.size, 0);
    if (!library) throw notStarted;
    if (size > FILES_MAX) throw new RangeError(`out of memory: files of ${Math.round(size / 1e6)} MB`);
    give(encoder.encode(JSON.stringify(request)));
    for (const file of files) give(new Uint8Array(await file.arrayBuffer()));
    const length = library.answer() >>> 0;
    const text = decoder.decode(bytesAt(library.answer_at(), length));
    postMessage({ id, answer: JSON.parse(text), heldMb: heldMb() });
  } catch (error) {
    postMessage({ id, failure: failure ?? String(error), heldMb: heldMb() });
  }
}

let last = Promise.resolve();
onmessage = ({ data }) => {
  last = last.then(async () => {
    if (!data.library) return answer(data);
    try {
      const { instance } = await WebAssembly.instantiate(data.library, { page: { said } });
      library = instance.exports;
    } catch (error) {
      notStarted = error;
    }
  });
};
