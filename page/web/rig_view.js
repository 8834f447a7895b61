// The vehicle in its gimbal under each controller, seen from behind, right and above, at a time that plays.
import { draw, make } from "./elements.js";
import { text } from "./text.js";

// Body axes are forward, right, down. The eye is behind, to the right and above.
const EYE = { turn: -0.6, rise: 0.45 };
// At first the vehicle is shown in a manoeuvre, not at rest.
const FIRST_SHARE = 0.09;
const ARM = Math.SQRT1_2;
const MOTORS = [
  [ARM, ARM],
  [-ARM, -ARM],
  [ARM, -ARM],
  [-ARM, ARM],
];
const RING = 1.35;

// Body to world by Z-Y-X angles (roll, pitch, yaw), as in docs/rig.md.
function turned([x, y, z], [roll, pitch, yaw]) {
  const [cr, sr, cp, sp, cy, sy] = [roll, pitch, yaw].flatMap((angle) => [Math.cos(angle), Math.sin(angle)]);
  [y, z] = [cr * y - sr * z, sr * y + cr * z];
  [x, z] = [cp * x + sp * z, -sp * x + cp * z];
  return [cy * x - sy * y, sy * x + cy * y, z];
}

function seen([forward, right, down]) {
  const [c, s] = [Math.cos(EYE.turn), Math.sin(EYE.turn)];
  const [ahead, aside] = [c * forward - s * right, s * forward + c * right];
  return [100 * aside, 100 * (down * Math.cos(EYE.rise) - ahead * Math.sin(EYE.rise))];
}

const line = (points, isClosed) =>
  `M${points
    .map((point) =>
      seen(point)
        .map((number) => number.toFixed(1))
        .join(" "),
    )
    .join("L")}${isClosed ? "Z" : ""}`;

function circle(radius, angles, centre = [0, 0, 0]) {
  return line(
    Array.from({ length: 37 }, (_, step) => {
      const at = (step * Math.PI) / 18;
      return turned([centre[0] + radius * Math.cos(at), centre[1] + radius * Math.sin(at), centre[2]], angles);
    }),
    true,
  );
}

export class Vehicle {
  // The label says what the drawing shows.
  constructor(name, label) {
    this.name = name;
    this.label = label;
    this.svg = draw("svg", { viewBox: "-165 -120 330 240", role: "img", class: `vehicle ${name}` });
    this.parts = Object.fromEntries(
      ["stand", "ring", "reference", "arms", "nose"].map((part) => [part, draw("path", { class: part })]),
    );
    this.rotors = MOTORS.map(() => [draw("path", { class: "rotor" }), draw("path", { class: "lift" })]);
    this.svg.append(...Object.values(this.parts), ...this.rotors.flat());
    this.caption = make("figcaption", {});
    this.figure = make("figure", { class: "vehicle-figure" }, this.svg, this.caption);
  }

  // The gimbal's ring turns about pitch, the body in it about roll.
  show([, reference, angles, commands], isOnGimbal) {
    const [roll, pitch, yaw] = angles;
    const ring = [0, pitch, yaw];
    const parts = {
      stand: isOnGimbal
        ? [
            line([
              [0, RING + 0.15, 0],
              [0, RING, 0],
            ]),
            line([
              [0, -RING - 0.15, 0],
              [0, -RING, 0],
            ]),
          ].join("")
        : "",
      ring: isOnGimbal ? circle(RING, ring) + line([turned([RING, 0, 0], ring), turned([-RING, 0, 0], ring)]) : "",
      reference: circle(1.05, [...reference, yaw]),
      arms: MOTORS.map(([x, y]) => line([[0, 0, 0], turned([x, y, 0], angles)])).join(""),
      nose: line(
        [
          [0, 0, 0],
          [0.5, 0, 0],
        ].map((point) => turned(point, angles)),
      ),
    };
    for (const [part, path] of Object.entries(parts)) this.parts[part].setAttribute("d", path);
    this.rotors.forEach(([rotor, lift], index) => {
      const [x, y] = MOTORS[index];
      rotor.setAttribute("d", circle(0.3, angles, [x, y, -0.06]));
      lift.setAttribute(
        "d",
        line(
          [
            [x, y, -0.06],
            [x, y, -0.06 - 0.6 * commands[index]],
          ].map((point) => turned(point, angles)),
        ),
      );
    });
    const degrees = (radians) => (radians * 180) / Math.PI;
    this.caption.textContent = `${this.name.toUpperCase()}: ${text.attitude(degrees(roll), degrees(pitch))}`;
    this.svg.setAttribute("aria-label", `${this.label}: ${this.caption.textContent}`);
  }
}

export class RigView {
  #vehicles = [];
  #motion = [];
  #isOnGimbal = true;
  #begun = null;

  constructor(place) {
    this.place = place;
    this.time = make("input", { type: "range", min: 0, max: 1, step: 0.04, value: 0, "aria-label": text.time });
    this.time.addEventListener("input", () => {
      this.#pause();
      this.#draw();
    });
    this.button = make(
      "button",
      { type: "button", onclick: () => (this.#begun === null ? this.#play() : this.#pause()) },
      text.play,
    );
    this.clock = make("output", { class: "quiet" });
    this.figures = make("div", { class: "vehicles" });
    place.append(this.figures, make("p", { class: "buttons player" }, this.button, this.time, this.clock));
  }

  // A new flight; the time stays where it is.
  show(motion, isOnGimbal) {
    this.#motion = motion;
    this.#isOnGimbal = isOnGimbal;
    if (this.#vehicles.length !== motion.length) {
      this.#vehicles = motion.map(({ name }) => new Vehicle(name, text.rigView(name)));
      this.figures.replaceChildren(...this.#vehicles.map(({ figure }) => figure));
    }
    const isFirst = this.time.max === "1";
    this.time.max = String(motion[0].pictures.at(-1)[0]);
    if (isFirst) this.time.value = String(FIRST_SHARE * Number(this.time.max));
    this.#draw();
  }

  #draw() {
    const time = Number(this.time.value);
    this.clock.textContent = `${time.toFixed(1)} s`;
    this.#vehicles.forEach((vehicle, index) => {
      const { pictures } = this.#motion[index];
      const step = pictures.length > 1 ? pictures[1][0] - pictures[0][0] : 1;
      vehicle.show(pictures[Math.min(pictures.length - 1, Math.round(time / step))], this.#isOnGimbal);
    });
  }

  #play() {
    if (Number(this.time.value) >= Number(this.time.max)) this.time.value = "0";
    this.#begun = performance.now() - 1000 * Number(this.time.value);
    this.button.textContent = text.pause;
    requestAnimationFrame((now) => this.#next(now));
  }

  #next(now) {
    if (this.#begun === null) return;
    const time = (now - this.#begun) / 1000;
    this.time.value = String(time);
    this.#draw();
    if (time >= Number(this.time.max)) this.#pause();
    else requestAnimationFrame((later) => this.#next(later));
  }

  #pause() {
    this.#begun = null;
    this.button.textContent = text.play;
  }
}
