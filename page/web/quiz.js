// The quiz: an effect is hidden in the vehicle; look, guess, and let the diagnosis answer.
import { catalogue } from "./catalogue.js";
import { Engine } from "./engine.js";
import { make, select, showReport } from "./elements.js";
import { text } from "./text.js";

// Each rig with the vehicle that flies in it.
const MODELS = { gimbal: "f450-gimbal", free: "f450-free" };
const CHOICES = 5;

const engine = new Engine();
const words = (name) => name.replaceAll("_", " ");
let place;
let rig = "gimbal";

export function startQuiz() {
  place = document.getElementById("quiz");
  begin(make("p", { class: "buttons" }, ...anew(text.quizStart, "main")));
}

// Where the vehicle flies, and the button that hides an effect in it.
function anew(label, look) {
  const choose = (event) => {
    rig = event.target.value;
  };
  return [
    select(text.rig, Object.entries(text.quizRigs), rig, choose, "quiz-rig"),
    make("button", { type: "button", class: look, "data-hide": true, onclick: hide }, label),
  ];
}

function begin(...children) {
  place.replaceChildren(make("h1", {}, text.quizTitle), make("p", {}, text.quizLead), ...children);
}

const anyOf = (list) => list[Math.floor(Math.random() * list.length)];

function shuffled(list) {
  const pairs = list.map((one) => [Math.random(), one]).sort(([a], [b]) => a - b);
  return pairs.map(([, one]) => one);
}

// An effect of the catalogue, at its example's size, somewhere on the vehicle.
function shortForm(effect) {
  const where = effect.places[rig];
  const parts = [
    where ? `${where[0]}=${anyOf(where[1])}` : null,
    ...effect.parameters.map(({ name, example }) => `${name}=${example}`),
  ];
  return `${effect.name}:${parts.filter(Boolean).join(",")}`;
}

async function hide() {
  begin(make("p", { role: "status", class: "panel" }, text.working));
  try {
    const { effects } = await catalogue();
    const [hidden, ...others] = shuffled(effects.filter(({ rigs }) => rigs.includes(rig)));
    const seed = Math.floor(Math.random() * 1e6);
    const { log, fragment } = await engine.request({ request: "hide", model: MODELS[rig], effect: shortForm(hidden), seed });
    ask(hidden, shuffled([hidden, ...others.slice(0, CHOICES - 1)]), log, fragment);
  } catch (problem) {
    begin(make("div", { class: "warning", role: "alert" }, make("pre", {}, problem ?? text.stopped)), ...anew(text.quizNew));
  }
}

function ask(hidden, choices, log, fragment) {
  const choice = ({ name, summary }, index) =>
    make(
      "label",
      { class: "check" },
      make("input", { type: "radio", name: "guess", value: name, checked: index === 0 }),
      `${words(name)}: ${summary}`,
    );
  const form = make(
    "form",
    { class: "panel" },
    make("fieldset", {}, make("legend", {}, text.quizWhich), ...choices.map(choice)),
    make("p", { class: "buttons" }, make("button", { type: "submit", class: "main" }, text.quizAnswer)),
    make("p", { class: "buttons" }, ...anew(text.quizNew)),
  );
  const figures = make("article", {});
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    answer(hidden, form.elements.guess.value, log, form, figures);
  });
  begin(form, figures);
  showReport(figures, fragment);
}

async function answer(hidden, guess, log, form, figures) {
  const said = make("div", { class: "panel", role: "status" }, text.working);
  form.replaceWith(said);
  const request = { request: "diagnose", logs: [{ name: "quiz.csv" }], options: { model: MODELS[rig], effort: "quick" } };
  try {
    const { fragment, causes } = await engine.request(request, [new Blob([log])], ({ what }) => {
      said.textContent = what;
    });
    const diagnosis = causes.includes(hidden.name)
      ? text.quizAgrees
      : text.quizMisses(causes.map(words).join(", ") || text.quizNothing);
    said.replaceChildren(
      make("p", {}, make("strong", {}, text.quizHidden(`${words(hidden.name)}, ${hidden.summary}`))),
      make("p", {}, guess === hidden.name ? text.quizRight : text.quizWrong),
      make("p", {}, diagnosis),
      make("p", { class: "buttons" }, ...anew(text.quizNew)),
    );
    showReport(figures, fragment);
  } catch (problem) {
    said.replaceChildren(make("pre", {}, problem ?? text.stopped), ...anew(text.quizNew));
  }
}
