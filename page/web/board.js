// The view of a board on a serial port: how it lies, what it says, its logs. Bytes go to the library and back; the port
// is the browser's (Web Serial).
import { Engine } from "./engine.js";
import { make, select } from "./elements.js";
import { Vehicle } from "./rig_view.js";
import { text } from "./text.js";

// Between two looks at what came, ms.
const LOOK_MS = 40;
const BAUD_RATES = ["57600", "115200", "460800", "921600"];
const LEVEL = [0, 0, 0],
  STILL = [0, 0, 0, 0];

// Only who asks for it in the address sees it: it was never tried with a board.
export const hasBoard = () => new URLSearchParams(location.search).has("board");

const inBase64 = (bytes) => Uint8Array.from(atob(bytes), (byte) => byte.charCodeAt(0));

// A connection: what came waits for the next look.
class Connection {
  #came = [];
  #isOpen = true;

  static async open(baudRate) {
    const port = await navigator.serial.requestPort();
    await port.open({ baudRate });
    return new Connection(port);
  }

  constructor(port) {
    this.port = port;
    this.reader = port.readable.getReader();
    this.writer = port.writable.getWriter();
    this.ended = this.#read();
  }

  get isOpen() {
    return this.#isOpen;
  }

  take() {
    const came = this.#came;
    this.#came = [];
    return new Blob(came);
  }

  async send(bytes) {
    if (bytes.length > 0) await this.writer.write(bytes);
  }

  async close() {
    if (!this.#isOpen) return;
    this.#isOpen = false;
    await this.reader.cancel().catch(() => {});
    this.reader.releaseLock();
    this.writer.releaseLock();
    await this.port.close().catch(() => {});
  }

  // Until the port is closed or pulled out.
  async #read() {
    try {
      for (;;) {
        const { value, done } = await this.reader.read();
        if (done) return;
        this.#came.push(value);
      }
    } finally {
      await this.close();
    }
  }
}

class BoardView {
  #engine = new Engine();
  #connection = null;
  #want = "same";

  constructor(place, onLog) {
    this.onLog = onLog;
    this.baud = select(text.baud, BAUD_RATES.map((rate) => [rate, rate]), BAUD_RATES[0], null, "baud");
    this.connect = make("button", { type: "button", class: "main", id: "board-connect", onclick: () => this.#toggle() });
    this.problem = make("div", { class: "warning", role: "alert", hidden: true });
    this.state = make("p", { role: "status", id: "board-state" }, text.boardNone);
    this.vehicle = new Vehicle("board", text.boardView);
    this.words = make("ul", { class: "quiet", id: "board-words" });
    this.list = make("button", { type: "button", id: "board-list", onclick: () => (this.#want = "list") }, text.listLogs);
    this.logs = make("div", { id: "board-logs" });
    this.live = make(
      "div",
      { hidden: true },
      this.vehicle.figure,
      make("p", { class: "buttons" }, this.list),
      this.logs,
      make("section", { class: "panel" }, make("h2", {}, text.boardSays), this.words),
    );
    const setUp = make("p", { class: "buttons" }, this.baud, this.connect);
    const lead = make("p", {}, text.boardLead);
    place.replaceChildren(make("h1", {}, text.boardTitle), lead, setUp, this.problem, this.state, this.live);
    this.#showConnected(false);
    if (!navigator.serial) this.#fail(text.noSerial);
  }

  async #toggle() {
    if (this.#connection) return this.#connection.close();
    this.problem.hidden = true;
    try {
      this.#connection = await Connection.open(Number(this.baud.querySelector("select").value));
    } catch (error) {
      // who chooses no port changed their mind
      if (error.name !== "NotFoundError") this.#fail(text.portRefused(error.message));
      return;
    }
    this.#showConnected(true);
    this.#want = "anew";
    await this.#talk();
    this.#connection = null;
    this.#showConnected(false);
  }

  async #talk() {
    while (this.#connection.isOpen) {
      const want = this.#want;
      this.#want = "same";
      try {
        const request = { request: "board", at_ms: performance.now(), want };
        const answer = await this.#engine.request(request, [this.#connection.take()]);
        await this.#connection.send(inBase64(answer.send));
        this.#show(answer);
      } catch (problem) {
        this.#fail(problem?.message ?? problem ?? text.stopped);
      }
      await new Promise((resolve) => setTimeout(resolve, LOOK_MS));
    }
  }

  #show({ vehicle, words, logs, fetching, fetched }) {
    this.live.hidden = !vehicle;
    this.state.textContent = vehicle ? text.boardIs(vehicle.system, vehicle.armed) : text.boardSilent;
    if (vehicle?.attitude_rad) this.vehicle.show([0, LEVEL, vehicle.attitude_rad, STILL], false);
    this.#replace(this.words, words, () => words.map((word) => make("li", {}, word)));
    if (fetching?.silent) {
      this.#want = "nothing";
      this.#fail(text.logSilent(fetching.id));
    }
    this.#replace(this.logs, [logs, fetching], () => (logs ? this.#logRows(logs, fetching) : []));
    if (fetched) this.onLog(new File([inBase64(fetched.bytes)], `log_${fetched.log.id}.ulg`));
  }

  #logRows(logs, fetching) {
    if (logs.length === 0) return [make("p", {}, text.noLogs)];
    return logs.map(({ id, bytes, begun_s }) => {
      const begun = begun_s > 0 ? new Date(1000 * begun_s).toLocaleString() : "";
      const isComing = fetching?.id === id;
      const action = isComing
        ? make("span", { role: "status" }, text.logComes(fetching.share, fetching.bytes_per_s))
        : make("button", { type: "button", onclick: () => (this.#want = { log: id }) }, text.diagnoseLog);
      const stop = isComing
        ? make("button", { type: "button", onclick: () => (this.#want = "nothing") }, text.stop)
        : null;
      return make("p", { class: "buttons" }, make("strong", {}, text.logOf(id, bytes)), begun, action, stop);
    });
  }

  // New children only for new content, so that a button stays what it was under a finger.
  #replace(place, content, children) {
    const key = JSON.stringify(content);
    if (place.dataset.content === key) return;
    place.dataset.content = key;
    place.replaceChildren(...children());
  }

  #showConnected(isConnected) {
    this.connect.textContent = isConnected ? text.disconnect : text.connect;
    this.baud.querySelector("select").disabled = isConnected;
    if (isConnected) return;
    this.live.hidden = true;
    this.state.textContent = text.boardNone;
  }

  #fail(why) {
    this.problem.hidden = false;
    this.problem.replaceChildren(make("p", {}, why));
  }
}

// `onLog` takes a log that was fetched, as a file.
export function startBoard(place, onLog) {
  new BoardView(place, onLog);
}
