// The library in a worker: requests with their answers, progress, and a stop that ends it at once.
import { text } from "./text.js";

// A worker that holds more memory than this after an answer is replaced: WebAssembly's memory never shrinks.
const KEPT_MB = 256;

let unpacked;
function library() {
  unpacked ??= (async () => {
    const packed = Uint8Array.from(atob(document.getElementById("engine").textContent), (byte) => byte.charCodeAt(0));
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
    return new Response(stream).arrayBuffer();
  })();
  return unpacked;
}

export class Engine {
  #worker;
  #waiting = new Map();
  #next = 1;

  // Resolves to the answer; rejects with a message for a person, or with null if it was stopped.
  request(request, files = [], onProgress = () => {}) {
    const id = this.#next++;
    return new Promise((resolve, reject) => {
      this.#waiting.set(id, { resolve, reject, onProgress });
      this.#worker ??= this.#start();
      this.#worker.then((worker) => worker?.postMessage({ id, request, files }));
    });
  }

  // Whatever is under way ends without an answer.
  stop() {
    this.#end(() => null);
  }

  async #start() {
    const address = URL.createObjectURL(
      new Blob([document.getElementById("worker").textContent], { type: "text/javascript" }),
    );
    const worker = new Worker(address);
    worker.onmessage = ({ data }) => this.#take(data);
    worker.onerror = (event) => this.#end(() => text.crashed(event.message));
    worker.postMessage({ library: await library() });
    URL.revokeObjectURL(address);
    return worker;
  }

  #take({ id, progress, answer, failure, heldMb }) {
    const waiting = this.#waiting.get(id);
    if (!waiting) return;
    if (progress) return waiting.onProgress(progress);
    this.#waiting.delete(id);
    if (answer) {
      if (answer.error === undefined) waiting.resolve(answer.ok);
      else waiting.reject(answer.error);
      if (heldMb > KEPT_MB && this.#waiting.size === 0) this.stop();
      return;
    }
    // the library's word, or the browser's about a file or about a worker that it has no room for
    const isMemory = /memory|NotReadable|allocation/i.test(failure);
    waiting.reject(isMemory ? text.outOfMemory(heldMb) : text.crashed(failure));
    this.stop();
  }

  #end(why) {
    this.#worker?.then((worker) => worker?.terminate());
    this.#worker = undefined;
    for (const { reject } of this.#waiting.values()) reject(why());
    this.#waiting.clear();
  }
}
