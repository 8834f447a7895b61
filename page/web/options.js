// The form of what a person knows better than the page guessed: the options of `sil diagnose`.
import { checkbox, field, make, select } from "./elements.js";
import { text } from "./text.js";

const OWN = "own";

// Fills the form; the catalogue names models and maps.
export function fillOptions(form, catalogue) {
  const maps = [["", text.mapAsFile], ...catalogue.maps.map((name) => [name, name]), [OWN, text.mapOwn]];
  const models = [
    ["", text.modelShown],
    ...catalogue.models.map(({ name, called }) => [name, called]),
    [OWN, text.modelFile],
  ];
  const rigs = [["", text.asShown], ...Object.entries(text.rigs)];
  const controllers = [
    ["", text.controllerUnknown],
    ["pid", text.pid],
    ["mpc", text.mpc],
  ];
  const number = (label, name, attributes = {}) => field(label, { name, type: "number", step: "any", ...attributes });
  const area = (name, label) =>
    make(
      "label",
      { class: "field wide", hidden: true },
      label,
      make("textarea", { name, rows: 12, spellcheck: "false" }),
    );
  const reveal = () => {
    form.elements.mapText.parentElement.hidden = form.elements.map.value !== OWN;
    form.elements.modelText.parentElement.hidden = form.elements.model.value !== OWN;
  };
  form.replaceChildren(
    select(text.map, maps, "", reveal, "map"),
    select(text.model, models, "", reveal, "model"),
    select(text.rig, rigs, "", null, "rig"),
    select(text.controller, controllers, "", null, "controller"),
    select(text.effort, Object.entries(text.efforts), "usual", null, "effort"),
    number(text.from, "from_s"),
    number(text.to, "to_s"),
    number(text.flight, "flight", { min: 1, step: 1 }),
    number(text.frameTurn, "frame_turn_deg"),
    field(text.known, { name: "known", type: "text" }),
    checkbox(text.whole, false, null, "whole"),
    checkbox(text.unchecked, false, null, "unchecked"),
    checkbox(text.untouched, false, null, "untouched"),
    area("mapText", text.mapText),
    area("modelText", text.modelFile),
  );
  form.addEventListener("submit", (event) => event.preventDefault());
}

// Opens the form with a map to be mended.
export function mendMap(form, map) {
  form.elements.map.value = OWN;
  form.elements.mapText.value = map;
  form.elements.mapText.parentElement.hidden = false;
  form.closest("details").open = true;
  form.elements.mapText.focus();
}

// What the form says, as the library reads it; what is empty is left out.
export function readOptions(form) {
  const { elements } = form;
  const said = {};
  const or = (name) => (elements[name].value === OWN ? elements[`${name}Text`].value : elements[name].value);
  for (const name of ["map", "model"]) if (or(name)) said[name] = or(name);
  for (const name of ["rig", "controller"]) if (elements[name].value) said[name] = elements[name].value;
  if (elements.effort.value !== "usual") said.effort = elements.effort.value;
  for (const name of ["from_s", "to_s", "flight", "frame_turn_deg"]) {
    if (elements[name].value !== "") said[name] = Number(elements[name].value);
  }
  for (const name of ["whole", "unchecked", "untouched"]) if (elements[name].checked) said[name] = true;
  const known = elements.known.value.split(/[\s,;]+/).filter(Boolean);
  if (known.length > 0) said.known = known;
  return said;
}
