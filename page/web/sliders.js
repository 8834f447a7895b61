// A number with a slider and a field: the slider spans what is usual, the field takes whatever is allowed.
import { make } from "./elements.js";

const digits = (value) => String(Number(Number(value).toPrecision(4)));
let count = 0;

// `of`: label, meaning, unit, value, slider [least, most], range [least, most] for the field, step; `isFactor` spans
// factors evenly, so that half and double lie alike. `onChange` gets the number.
export function slider(of, onChange) {
  const [low, high] = of.slider;
  const toTrack = (value) =>
    of.isFactor ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low);
  const toValue = (track) => {
    const value = of.isFactor ? low * (high / low) ** track : low + (high - low) * track;
    return of.step ? Math.round(value / of.step) * of.step : Number(value.toPrecision(3));
  };
  const id = `slider-${++count}`;
  const [least, most] = of.range ?? of.slider;
  const field = make("input", {
    type: "number",
    id,
    min: least,
    max: most,
    step: of.step ?? "any",
    value: digits(of.value),
    "aria-describedby": `${id}-meaning`,
  });
  const track = make("input", {
    type: "range",
    min: 0,
    max: 1,
    step: 0.005,
    value: toTrack(of.value),
    "aria-label": of.label,
    "data-key": of.key,
  });
  const say = () => track.setAttribute("aria-valuetext", `${field.value} ${of.unit ?? ""}`);
  track.addEventListener("input", () => {
    field.value = digits(toValue(Number(track.value)));
    say();
    onChange(Number(field.value));
  });
  field.addEventListener("input", () => {
    if (field.value === "" || !field.validity.valid) return;
    track.value = toTrack(Number(field.value));
    say();
    onChange(Number(field.value));
  });
  say();
  const unit = of.unit ? make("span", { class: "quiet" }, ` ${of.unit}`) : null;
  return make(
    "div",
    { class: "slider" },
    make("label", { for: id }, of.label),
    make("span", { class: "amount" }, field, unit),
    track,
    make("p", { class: "quiet", id: `${id}-meaning` }, of.meaning),
  );
}
