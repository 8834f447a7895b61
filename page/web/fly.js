// The view that flies: a state, its form, and the flight under both controllers after each move.
import { catalogue } from "./catalogue.js";
import { controls } from "./controls.js";
import { download, make, showReport } from "./elements.js";
import { Engine } from "./engine.js";
import { hasState, readState, writeState } from "./link.js";
import { RigView } from "./rig_view.js";
import { stepsScript } from "./step_drawing.js";
import { text } from "./text.js";
import { GROUPS, TUNING } from "./tuning.js";

// Margins take several times as long as the flight: they are measured aside, once nothing is moved any more.
const [engine, aside] = [new Engine(), new Engine()];
const STILL_MS = 400;
const at = (id) => document.getElementById(id);

const usual = () => ({
  rig: "gimbal",
  level: "f450",
  effects: [],
  known: false,
  manoeuvre: "sequence",
  steps: {},
  script: "",
  seed: 0,
  rate_hz: 400,
  control_horizon: 5,
  tuning: {},
});
let state = usual();
let choices, view, values;
let isFlying = false,
  isStale = true,
  still;

export function startFly() {
  view = new RigView(at("rig-view"));
  at("link").addEventListener("click", copyLink);
  at("reset").addEventListener("click", () => {
    state = usual();
    showControls();
    fly();
  });
  at("controls").addEventListener("submit", (event) => event.preventDefault());
  addEventListener("hashchange", () => {
    if (hasState()) {
      isStale = true;
      takeLink();
      showFlight();
    }
  });
}

// Called whenever the view is seen: the first time it flies.
export async function showFlight() {
  if (!isStale) return;
  isStale = false;
  try {
    choices = await catalogue();
  } catch (problem) {
    return showProblem(problem);
  }
  takeLink();
  showControls();
  await fly();
}

// Flies a script that a diagnosis wrote.
export function flyScript(script, rig) {
  state = { ...usual(), rig, manoeuvre: "script", script };
  if (choices) {
    showControls();
    fly();
  } else writeState(state);
}

function takeLink() {
  if (!hasState()) return;
  const linked = readState();
  if (linked === null) return showProblem(text.badLink);
  state = { ...usual(), ...linked };
}

function showControls() {
  controls(at("controls"), state, choices, values, (isOtherForm) => {
    if (isOtherForm) showControls();
    fly();
  });
}

function requested(margins) {
  const effects = state.effects.map(({ name, place, values }) => {
    const parts = [place ? place.join("=") : null, ...Object.entries(values).map((pair) => pair.join("="))];
    return `${name}:${parts.filter(Boolean).join(",")}`;
  });
  const controllers = ["pid", "mpc"].map((controller) => {
    const [factors, own] = [{}, {}];
    for (const { key, isFactor } of GROUPS[controller].flatMap((group) => TUNING[group])) {
      if (state.tuning[key] !== undefined) (isFactor ? factors : own)[key] = state.tuning[key];
    }
    return { controller, rate_hz: state.rate_hz, control_horizon: state.control_horizon, factors, values: own };
  });
  const script = { sequence: null, drawn: stepsScript(state.steps), script: state.script }[state.manoeuvre];
  return {
    request: "fly",
    model: `${state.level}-${state.rig}`,
    effects,
    known: state.known,
    controllers,
    script,
    seed: state.seed,
    margins,
  };
}

// One flight at a time; of moves made meanwhile the last one is flown next.
async function fly() {
  writeState(state);
  clearTimeout(still);
  aside.stop();
  if (isFlying) {
    isFlying = "again";
    return;
  }
  isFlying = true;
  const begun = performance.now();
  at("flight").setAttribute("aria-busy", "true");
  delete at("flight").dataset.margins;
  try {
    const flight = await engine.request(requested(false));
    at("fly-problem").hidden = true;
    showReport(at("flight"), flight.fragment);
    view.show(flight.motion, state.rig === "gimbal");
    values = Object.assign({}, ...flight.tuning);
    showFiles(flight);
  } catch (problem) {
    showProblem(problem);
  }
  at("flight").setAttribute("aria-busy", "false");
  at("flight").dataset.ms = String(Math.round(performance.now() - begun));
  const isAgain = isFlying === "again";
  isFlying = false;
  if (isAgain) fly();
  else still = setTimeout(measureMargins, STILL_MS);
}

async function measureMargins() {
  try {
    const { fragment } = await aside.request(requested(true));
    showReport(at("flight"), fragment);
    at("flight").dataset.margins = "measured";
  } catch {
    // moved on meanwhile; what can't be flown has been said
  }
}

function showProblem(problem) {
  at("fly-problem").hidden = false;
  at("fly-problem").replaceChildren(make("pre", {}, problem ?? text.stopped));
}

function showFiles({ files, script, vehicle }) {
  const toml = "application/toml";
  at("fly-downloads").replaceChildren(
    make(
      "p",
      { class: "buttons" },
      make("strong", {}, text.flightFiles),
      download(text.vehicleFile, "vehicle.toml", vehicle, toml),
      ...["pid", "mpc"].map((name, index) => download(text.controllerFile(name), `${name}.toml`, files[index], toml)),
      download(text.scriptText, "script.toml", script, toml),
    ),
  );
  at("fly-downloads").hidden = false;
}

async function copyLink() {
  writeState(state);
  let said = text.linkShown;
  try {
    await navigator.clipboard.writeText(location.href);
    said = text.linkCopied;
  } catch {
    // without the permission the address bar has it
  }
  at("link-said").textContent = said;
}
