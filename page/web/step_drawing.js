// A manoeuvre drawn by hand: a drawing with a column for each half second, in which the reference is set by pointer or
// keys.
import { draw, make, select } from "./elements.js";
import { text } from "./text.js";

const [STEP_S, COLUMNS, ANGLE_MAX_DEG, GRID_DEG] = [0.5, 20, 45, 5];
const AXES = ["roll", "pitch"];
const [WIDTH, HEIGHT] = [400, 180];
const USUAL = { roll: [0, 0, 20, 20, 20, 20, 20, 20], pitch: [] };

const anglesOf = (steps, axis) =>
  Array.from({ length: COLUMNS }, (_, index) => (steps[axis] ?? USUAL[axis])[index] ?? 0);

// The script that flies what was drawn.
export function stepsScript(steps) {
  const [roll, pitch] = AXES.map((axis) => anglesOf(steps, axis));
  const waypoints = roll.map(
    (angle, index) => `[[step]]\nat_s = ${index * STEP_S}\nroll_deg = ${angle}\npitch_deg = ${pitch[index]}\n`,
  );
  return `name = "drawn by hand"\nduration_s = ${COLUMNS * STEP_S}\n${waypoints.join("")}`;
}

// The drawing; it changes `state.steps` and tells so.
export function stepDrawing(state, onChange) {
  let axis = "roll";
  let column = 2;
  const svg = draw("svg", {
    viewBox: `0 0 ${WIDTH} ${HEIGHT}`,
    class: "drawing",
    tabindex: 0,
    role: "slider",
    "aria-valuemin": -ANGLE_MAX_DEG,
    "aria-valuemax": ANGLE_MAX_DEG,
  });
  const [zero, marker, curve] = [
    draw("path", { class: "zero", d: `M0 ${HEIGHT / 2}H${WIDTH}` }),
    draw("rect", { class: "marker", y: 0, width: WIDTH / COLUMNS, height: HEIGHT }),
    draw("path", { class: "curve" }),
  ];
  svg.append(marker, zero, curve);
  const said = make("output", { class: "quiet" });

  const show = () => {
    const angles = anglesOf(state.steps, axis);
    const up = (angle) => (HEIGHT / 2) * (1 - angle / ANGLE_MAX_DEG);
    curve.setAttribute(
      "d",
      `M0 ${up(angles[0])}${angles.map((angle, index) => `V${up(angle)}H${((index + 1) * WIDTH) / COLUMNS}`).join("")}`,
    );
    marker.setAttribute("x", (column * WIDTH) / COLUMNS);
    said.textContent = text.drawValue(axis, column * STEP_S, angles[column]);
    svg.setAttribute("aria-label", text.drawn);
    svg.setAttribute("aria-valuenow", angles[column]);
    svg.setAttribute("aria-valuetext", said.textContent);
  };
  const set = (angle) => {
    const angles = anglesOf(state.steps, axis);
    const rounded = GRID_DEG * Math.round(angle / GRID_DEG);
    angles[column] = Math.max(-ANGLE_MAX_DEG, Math.min(ANGLE_MAX_DEG, rounded));
    state.steps = { roll: anglesOf(state.steps, "roll"), pitch: anglesOf(state.steps, "pitch"), [axis]: angles };
    show();
    onChange();
  };
  const point = (event) => {
    const box = svg.getBoundingClientRect();
    column = Math.max(0, Math.min(COLUMNS - 1, Math.floor(((event.clientX - box.left) / box.width) * COLUMNS)));
    set(ANGLE_MAX_DEG * (1 - (2 * (event.clientY - box.top)) / box.height));
  };
  svg.addEventListener("pointerdown", (event) => {
    svg.setPointerCapture(event.pointerId);
    point(event);
  });
  svg.addEventListener("pointermove", (event) => {
    if (svg.hasPointerCapture(event.pointerId)) point(event);
  });
  svg.addEventListener("keydown", (event) => {
    const aside = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    const up = { ArrowUp: GRID_DEG, ArrowDown: -GRID_DEG }[event.key];
    if (!aside && !up) return;
    event.preventDefault();
    if (aside) {
      column = (column + aside + COLUMNS) % COLUMNS;
      show();
    } else set(anglesOf(state.steps, axis)[column] + up);
  });
  const level = () => {
    state.steps = { roll: anglesOf({ roll: [] }, "roll"), pitch: anglesOf({ pitch: [] }, "pitch") };
    show();
    onChange();
  };
  show();
  return make(
    "div",
    {},
    select(
      text.drawAxis,
      AXES.map((name) => [name, name]),
      axis,
      (event) => {
        axis = event.target.value;
        show();
      },
      "draw-axis",
    ),
    svg,
    said,
    make("p", { class: "quiet" }, text.drawHelp),
    make("button", { type: "button", onclick: level }, text.clearDrawing),
  );
}
