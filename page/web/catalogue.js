// What there is to choose from, asked of the library once, by a worker of its own that nobody stops.
import { Engine } from "./engine.js";

let asked;

export function catalogue() {
  if (!asked) {
    const engine = new Engine();
    asked = engine.request({ request: "catalogue" }).finally(() => engine.stop());
  }
  return asked;
}
