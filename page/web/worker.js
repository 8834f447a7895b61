// Beside the page: runs the library, one request after the other. In: the library once, then { id, request, files };
// out: { id, progress } on the way, then { id, answer, heldMb } or { id, failure, heldMb }.
"use strict";
const [decoder, encoder] = [new TextDecoder(), new TextEncoder()];
let library, current, failure;

const bytesAt = (at, length) => new Uint8Array(library.memory.buffer, at, length);

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
  const heldMb = () => Math.round(library.memory.buffer.byteLength / 1e6);
  try {
    give(encoder.encode(JSON.stringify(request)));
    for (const file of files) give(new Uint8Array(await file.arrayBuffer()));
    const length = library.answer();
    const text = decoder.decode(bytesAt(library.answer_at(), length));
    postMessage({ id, answer: JSON.parse(text), heldMb: heldMb() });
  } catch (error) {
    postMessage({
      id,
      failure: failure ?? String(error),
      isTrap: error instanceof WebAssembly.RuntimeError,
      heldMb: heldMb(),
    });
  }
}

let last = Promise.resolve();
onmessage = ({ data }) => {
  last = last.then(async () => {
    if (!data.library) return answer(data);
    const { instance } = await WebAssembly.instantiate(data.library, { page: { said } });
    library = instance.exports;
  });
};
