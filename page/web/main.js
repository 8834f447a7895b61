// The page begins: strings, tabs, and the views as they are first seen.
import { fillIn } from "./text.js";
import { hasBoard, startBoard } from "./board.js";
import { startDiagnose, takeLogs } from "./diagnose.js";
import { startFly, flyScript, showFlight } from "./fly.js";
import { startQuiz } from "./quiz.js";
import { hasState } from "./link.js";

const views = ["diagnose", "fly", "quiz", ...(hasBoard() ? ["board"] : [])];

function show(view) {
  for (const name of views) {
    const tab = document.getElementById(`tab-${name}`);
    const isShown = name === view;
    document.getElementById(name).hidden = !isShown;
    tab.setAttribute("aria-selected", String(isShown));
    tab.tabIndex = isShown ? 0 : -1;
  }
  document.body.classList.toggle("wide", view === "fly");
  if (view === "fly") showFlight();
}

function startTabs() {
  for (const [index, name] of views.entries()) {
    const tab = document.getElementById(`tab-${name}`);
    tab.addEventListener("click", () => show(name));
    tab.addEventListener("keydown", (event) => {
      const by = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
      if (!by) return;
      const next = views[(index + by + views.length) % views.length];
      show(next);
      document.getElementById(`tab-${next}`).focus();
    });
  }
}

fillIn(document);
startTabs();
startFly();
startDiagnose((script, rig) => {
  show("fly");
  flyScript(script, rig);
});
startQuiz();
if (hasBoard()) {
  document.getElementById("tab-board").hidden = false;
  startBoard(document.getElementById("board"), (log) => {
    show("diagnose");
    takeLogs([log]);
  });
}
show(hasState() ? "fly" : "diagnose");
document.documentElement.dataset.ready = "yes";
