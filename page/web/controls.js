// The form of a flight: whatever is changed goes into the state, and the caller is told. A change of what there is to
// choose from makes another form.
import { checkbox, make, select } from "./elements.js";
import { slider } from "./sliders.js";
import { stepDrawing } from "./step_drawing.js";
import { text } from "./text.js";
import { TUNING } from "./tuning.js";

// On a phone the form lies before the flight: folded, both are seen.
const isNarrow = () => matchMedia("(max-width: 52rem)").matches;

// `values`: the tuning that flew last, by key.
export function controls(form, state, catalogue, values, onChange) {
  const group = (title, isOpen, ...children) =>
    make(
      "details",
      { class: "panel", open: isOpen, "data-group": title },
      make("summary", {}, title),
      ...children.filter(Boolean),
    );
  const wasOpen = new Map([...form.querySelectorAll("details")].map((fold) => [fold.dataset.group, fold.open]));
  const at = (title, otherwise) => wasOpen.get(title) ?? (otherwise && !isNarrow());
  form.replaceChildren(
    group(text.vehicle, at(text.vehicle, true), ...vehicle(state, catalogue, onChange)),
    group(text.effects, at(text.effects, true), ...effects(state, catalogue, onChange)),
    group(text.manoeuvre, at(text.manoeuvre, true), ...manoeuvre(state, catalogue, onChange)),
    group(
      text.pid,
      at(text.pid, true),
      make("p", { class: "quiet" }, text.follows),
      ...tuning("pid", state, catalogue, values, onChange),
    ),
    group(
      text.mpc,
      at(text.mpc, false),
      horizon(state, onChange),
      ...tuning("mpc", state, catalogue, values, onChange),
    ),
    group(text.limits, at(text.limits, false), ...tuning("limits", state, catalogue, values, onChange)),
    group(text.loop, at(text.loop, false), ...loop(state, onChange)),
  );
}

function vehicle(state, catalogue, onChange) {
  const rigs = ["gimbal", "free"].map((rig) => [rig, text.rigs[rig]]);
  const levels = catalogue.models
    .filter(({ rig }) => rig === state.rig)
    .map(({ name }) => name.slice(0, -state.rig.length - 1));
  const toRig = (event) => {
    state.rig = event.target.value;
    const isThere = ({ name }) => name === `${state.level}-${state.rig}`;
    if (!catalogue.models.some(isThere)) state.level = "f450";
    state.effects = state.effects.filter(({ name }) => of(catalogue, name).rigs.includes(state.rig));
    onChange(true);
  };
  return [
    select(text.rig, rigs, state.rig, toRig, "rig"),
    select(
      text.level,
      levels.map((level) => [level, text.levels[level]]),
      state.level,
      (event) => {
        state.level = event.target.value;
        onChange(false);
      },
      "level",
    ),
  ];
}

const of = (catalogue, name) => catalogue.effects.find((effect) => effect.name === name);

function effects(state, catalogue, onChange) {
  const panels = state.effects.map((chosen) => {
    const effect = of(catalogue, chosen.name);
    const places = effect.places[state.rig];
    const remove = () => {
      state.effects = state.effects.filter((other) => other !== chosen);
      onChange(true);
    };
    const place =
      places &&
      select(
        text.place[places[0]],
        places[1].map((name) => [name, name]),
        chosen.place[1],
        (event) => {
          chosen.place = [places[0], event.target.value];
          onChange(false);
        },
      );
    const sliders = effect.parameters.map((parameter) =>
      slider(
        {
          ...parameter,
          key: parameter.name,
          label: labelOf(parameter.name),
          value: chosen.values[parameter.name],
        },
        (number) => {
          chosen.values[parameter.name] = number;
          onChange(false);
        },
      ),
    );
    return make(
      "fieldset",
      {},
      make("legend", {}, effect.name.replaceAll("_", " ")),
      make("p", { class: "quiet" }, effect.summary),
      ...[place].filter(Boolean),
      ...sliders,
      make("button", { type: "button", onclick: remove }, text.remove),
    );
  });
  const there = catalogue.effects.filter(({ rigs }) => rigs.includes(state.rig));
  const choices = [
    ["", text.pickEffect],
    ...there.map(({ name, summary }) => [name, `${name.replaceAll("_", " ")}: ${summary}`]),
  ];
  const add = select(
    text.addEffect,
    choices,
    "",
    (event) => {
      const effect = of(catalogue, event.target.value);
      const places = effect.places[state.rig];
      const values = Object.fromEntries(effect.parameters.map(({ name, example }) => [name, example]));
      state.effects.push({ name: effect.name, place: places ? [places[0], places[1][0]] : null, values });
      onChange(true);
    },
    "add-effect",
  );
  const known = checkbox(
    text.controllersKnow,
    state.known,
    (event) => {
      state.known = event.target.checked;
      onChange(false);
    },
    "known",
  );
  return [...panels, add, state.effects.length > 0 ? known : null];
}

function manoeuvre(state, catalogue, onChange) {
  const kinds = [
    ["sequence", text.sequence],
    ["drawn", text.drawn],
    ["script", text.scripted],
  ];
  const kind = select(
    text.manoeuvre,
    kinds,
    state.manoeuvre,
    (event) => {
      state.manoeuvre = event.target.value;
      if (state.manoeuvre === "script" && !state.script) state.script = catalogue.sequence;
      onChange(true);
    },
    "manoeuvre",
  );
  if (state.manoeuvre === "drawn") return [kind, stepDrawing(state, () => onChange(false))];
  if (state.manoeuvre !== "script") return [kind];
  const script = make("textarea", {
    rows: 10,
    spellcheck: "false",
    onchange: (event) => {
      state.script = event.target.value;
      onChange(false);
    },
  });
  script.value = state.script;
  return [kind, make("label", { class: "field wide" }, text.scriptText, script)];
}

// The key in words, without controller and unit: the unit stands beside it or in its meaning.
const labelOf = (key) =>
  key
    .replace(/^mpc_/, "")
    .replace(/(_rad)?(_1)?_(s2?|rad|hz|nm|deg|v|m|kg)$/, "")
    .replaceAll("_", " ");

function tuning(group, state, catalogue, values, onChange) {
  return TUNING[group].map((of) => {
    const { meaning } = catalogue.tuning.find(({ key }) => key === of.key);
    const value = state.tuning[of.key] ?? (of.isFactor ? 1 : (values?.[of.key] ?? of.slider[0]));
    return slider(
      {
        ...of,
        value,
        meaning,
        label: labelOf(of.key),
        unit: of.isFactor ? text.times : "",
      },
      (number) => {
        if (of.isFactor && number === 1) delete state.tuning[of.key];
        else state.tuning[of.key] = number;
        onChange(false);
      },
    );
  });
}

function horizon(state, onChange) {
  return slider(
    {
      key: "control_horizon",
      label: text.controlHorizon,
      meaning: "",
      value: state.control_horizon,
      slider: [1, 30],
      step: 1,
    },
    (number) => {
      state.control_horizon = number;
      onChange(false);
    },
  );
}

function loop(state, onChange) {
  return [
    slider(
      { key: "rate_hz", label: text.rate, meaning: "", value: state.rate_hz, slider: [50, 1000], step: 50 },
      (number) => {
        state.rate_hz = number;
        onChange(false);
      },
    ),
    slider(
      { key: "seed", label: text.seed, meaning: "", value: state.seed, slider: [0, 20], range: [0, 1e9], step: 1 },
      (number) => {
        state.seed = number;
        onChange(false);
      },
    ),
  ];
}
