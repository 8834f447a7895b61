// The view that diagnoses logs: files in, what was recognised, progress, the answer in the report's own words.
import { catalogue } from "./catalogue.js";
import { Engine } from "./engine.js";
import { checkbox, download, make, showReport } from "./elements.js";
import { fillOptions, mendMap, readOptions } from "./options.js";
import { text } from "./text.js";

const engine = new Engine();
const at = (id) => document.getElementById(id);
// Each { name, file, isNormal, known }: known is what the library recognised.
let logs = [];
let flyNext, isReady;

// `onScript` flies the manoeuvre that a diagnosis suggests.
export function startDiagnose(onScript) {
  flyNext = onScript;
  isReady = catalogue().then((choices) => fillOptions(at("options"), choices));
  isReady.catch(showProblem);
  at("options").addEventListener("change", () => recogniseAll());
  at("choose").addEventListener("click", () => at("file").click());
  at("file").addEventListener("change", () => {
    take([...at("file").files]);
    at("file").value = "";
  });
  at("demonstration").addEventListener("click", () => {
    const csv = at("rig-log").textContent;
    takeLogs([new File([csv], text.demonstrationName, { type: "text/csv" })]);
  });
  at("run").addEventListener("click", run);
  at("clear").addEventListener("click", () => {
    clear();
    at("choose").focus();
  });
  at("stop").addEventListener("click", () => engine.stop());
  startDropping();
}

function startDropping() {
  const isOver = (is) => at("drop").classList.toggle("over", is);
  document.addEventListener("dragover", (event) => {
    event.preventDefault();
    isOver(true);
  });
  document.addEventListener("dragleave", () => isOver(false));
  document.addEventListener("drop", (event) => {
    event.preventDefault();
    isOver(false);
    at("tab-diagnose").click();
    take([...event.dataTransfer.files]);
  });
}

function clear() {
  engine.stop();
  logs = [];
  for (const id of ["overrides", "run-row", "progress", "problem", "downloads"]) at(id).hidden = true;
  at("logs").replaceChildren();
  showReport(at("answer"), "");
  at("run").textContent = text.run;
}

// Another log than those that are there.
export function takeLogs(files) {
  clear();
  take(files);
}

// One log by itself is diagnosed at once; of several somebody says first which are normal.
async function take(files) {
  if (files.length === 0) return;
  await isReady;
  logs.push(...files.map((file) => ({ name: file.name, file, isNormal: false })));
  await recogniseAll();
  if (logs.length === 1 && !logs[0].known?.problem) run();
}

async function recogniseAll() {
  if (logs.length === 0) return;
  const options = readOptions(at("options"));
  for (const log of logs) {
    showProgress({ what: `${text.reading} ${log.name}` });
    try {
      log.known = await engine.request({ request: "recognise", name: log.name, options }, [log.file]);
    } catch (problem) {
      log.known = { problem: problem ?? text.stopped };
    }
  }
  at("progress").hidden = true;
  showLogs();
}

function showLogs() {
  at("logs").replaceChildren(...logs.map(logPanel));
  const isAny = logs.length > 0;
  at("overrides").hidden = at("run-row").hidden = !isAny;
}

function logPanel(log) {
  const { known } = log;
  const normal = checkbox(text.normal, log.isNormal, (event) => {
    log.isNormal = event.target.checked;
  });
  const remove = make(
    "button",
    {
      type: "button",
      onclick: () => {
        logs = logs.filter((of) => of !== log);
        showLogs();
      },
    },
    text.remove,
  );
  const foot = logs.length > 1 ? make("p", { class: "buttons" }, normal, remove) : null;
  if (known.problem) {
    const draft = known.map
      ? make("button", { type: "button", onclick: () => mendMap(at("options"), known.map) }, text.takeDraft)
      : null;
    const problem = make(
      "div",
      { class: "warning log-problem", role: "alert" },
      make("strong", {}, `${text.unreadable}: `),
      make("pre", {}, known.problem),
    );
    return make("section", { class: "panel log" }, make("h2", {}, log.name), problem, draft, foot);
  }
  const lines = [
    [text.format, [known.format]],
    [text.size, [text.rowsOf(known.rows, known.duration_s, known.rate_hz)]],
    [text.holds, [known.has.join(", ")]],
    [text.reached, [known.reached.join(", ")]],
    [text.noted, [...known.comments, ...known.notes]],
  ].filter(([, values]) => values.length > 0);
  const list = lines.flatMap(([name, values]) => [
    make("dt", {}, name),
    make("dd", {}, ...values.map((value) => make("p", {}, value))),
  ]);
  const facts =
    known.facts.length > 0
      ? make("details", {}, make("summary", {}, text.says), ...known.facts.map((fact) => make("p", {}, fact)))
      : null;
  const map = known.map
    ? make(
        "details",
        {},
        make("summary", {}, text.map),
        make("pre", {}, known.map),
        make("button", { type: "button", onclick: () => mendMap(at("options"), known.map) }, text.takeDraft),
        download(text.mapFile, "map.toml", known.map, "application/toml"),
      )
    : null;
  const summary = make(
    "summary",
    {},
    make("strong", {}, log.name),
    ` ${text.rowsOf(known.rows, known.duration_s, known.rate_hz)}, ${known.format}`,
  );
  return make(
    "section",
    { class: "panel log" },
    make("details", { open: logs.length === 1 }, summary, make("dl", {}, ...list), facts, map),
    foot,
  );
}

// The present step, and when the page first heard of it.
let step = {};

// What a step still takes at the pace that it has had, in words; nothing of one that has just begun.
function timeLeft({ done, total, what }) {
  if (step.what !== what) step = { what, done, since_ms: performance.now() };
  const took_s = (performance.now() - step.since_ms) / 1000;
  const left_s = (took_s * (total - done)) / (done - step.done);
  return took_s > 1 && left_s > 1 && Number.isFinite(left_s) ? text.timeLeft(left_s) : "";
}

function showProgress(progress) {
  const { done, total, what } = progress;
  if (at("progress").hidden) {
    at("progress").hidden = false;
    at("progress").scrollIntoView({ block: "nearest" });
  }
  at("progress-text").textContent = what + (total ? timeLeft(progress) : "");
  const bar = at("progress-bar");
  if (total) bar.value = done / total;
  else bar.removeAttribute("value");
}

function showProblem(problem) {
  at("progress").hidden = true;
  at("problem").hidden = false;
  at("problem").replaceChildren(make("pre", {}, problem ?? text.stopped));
  at("problem").scrollIntoView({ block: "nearest" });
}

async function run() {
  engine.stop();
  at("problem").hidden = at("downloads").hidden = true;
  showReport(at("answer"), "");
  showProgress({ what: text.preparing });
  const request = {
    request: "diagnose",
    logs: logs.map(({ name, isNormal }) => ({ name, normal: isNormal })),
    options: readOptions(at("options")),
  };
  try {
    const answer = await engine.request(
      request,
      logs.map(({ file }) => file),
      showProgress,
    );
    showAnswer(answer);
  } catch (problem) {
    showProblem(problem);
  }
  at("run").textContent = text.runAgain;
}

function showAnswer(answer) {
  at("progress").hidden = true;
  const files = [
    [text.report, "diagnosis.html", answer.report, "text/html"],
    [text.json, "diagnosis.json", answer.json, "application/json"],
    [text.plain, "diagnosis.txt", answer.text, "text/plain"],
    [text.extended, "extended.toml", answer.extended, "application/toml"],
    [text.script, "next.toml", answer.script, "application/toml"],
  ].filter(([, , content]) => content);
  const buttons = files.map(([label, name, content, type]) => download(label, name, content, type));
  const next = answer.next ? make("p", { class: "note" }, make("strong", {}, `${text.next}: `), answer.next) : null;
  const fly =
    answer.script && answer.rig
      ? make("button", { type: "button", onclick: () => flyNext(answer.script, answer.rig) }, text.flyIt)
      : null;
  at("downloads").replaceChildren(
    make("p", { class: "buttons" }, make("strong", {}, text.downloads), ...buttons, fly),
    ...[next].filter(Boolean),
  );
  at("downloads").hidden = false;
  for (const panel of at("logs").querySelectorAll("details")) panel.open = false;
  showReport(at("answer"), answer.fragment);
  at("answer").focus({ preventScroll: true });
  at("answer").scrollIntoView({ block: "start" });
}
