// Making elements: make("button", { class: "main", onclick }, "text", child, ...).
export function make(name, attributes = {}, ...children) {
  const element = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (value === undefined || value === null || value === false) continue;
    if (key.startsWith("on")) element.addEventListener(key.slice(2), value);
    else element.setAttribute(key, value === true ? "" : value);
  }
  element.append(...children.filter((child) => child !== null && child !== undefined));
  return element;
}

// A drawing's element.
export function draw(name, attributes = {}) {
  const element = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  return element;
}

// A field with its label; choices are [value, shown].
export function select(label, choices, value, onchange, name) {
  const options = choices.map(([of, shown]) => make("option", { value: of, selected: of === value }, shown));
  return make("label", { class: "field" }, label, make("select", { onchange, name }, ...options));
}

export function checkbox(label, isChecked, onchange, name) {
  return make(
    "label",
    { class: "check" },
    make("input", { type: "checkbox", checked: isChecked, onchange, name }),
    label,
  );
}

export function field(label, attributes) {
  return make("label", { class: "field" }, label, make("input", attributes));
}

// A file to keep, made in the page.
export function download(label, name, content, type) {
  const save = () => {
    const address = URL.createObjectURL(new Blob([content], { type }));
    make("a", { href: address, download: name }).click();
    setTimeout(() => URL.revokeObjectURL(address), 1000);
  };
  return make("button", { type: "button", onclick: save, "data-file": name }, label);
}

// Shows a part of a report: its plots come alive, its links stay within it, and folds that were open stay open.
export function showReport(place, fragment) {
  const titles = (folds) => [...folds].map((fold) => fold.querySelector("summary").textContent);
  const open = new Set(titles(place.querySelectorAll("details[open]")));
  globalThis.livePlots.detach(place);
  place.innerHTML = fragment;
  for (const fold of place.querySelectorAll("details")) fold.open = open.has(titles([fold])[0]);
  globalThis.livePlots.attach(place);
  for (const link of place.querySelectorAll('a[href^="#"]')) {
    link.addEventListener("click", (event) => {
      event.preventDefault();
      const target = place.querySelector(link.getAttribute("href"));
      const fold = target?.closest("details");
      if (fold) fold.open = true;
      (fold ?? target)?.scrollIntoView();
    });
  }
}
