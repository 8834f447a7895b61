// Makes the page's drawings live: values under the cursor, curves hidden by their legend entries, zoom by dragging (a
// double click shows all again), one time axis for all plots over the same span. The samples are read back from the
// drawings, whose grid has 10000 steps to the right and 4000 upward; without this script the drawings stay as they are.
"use strict";
(() => {
  const WIDTH = 10000, HEIGHT = 4000;
  const zoomed = new Map(); // by time span: [min, max] of all its plots
  const live = new Map(); // plots by their element

  const numbers = (text) => text.split(" ").map(Number);
  const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

  // The strokes of a path, each a list of grid points.
  function strokes(path) {
    return path.getAttribute("d").split("M").slice(1).map((stroke) => {
      const at = stroke.match(/-?\d+/g).map(Number);
      const points = [[at[0], at[1]]];
      if (!stroke.includes("h")) {
        for (let i = 2; i + 1 < at.length; i += 2) {
          const last = points[points.length - 1];
          points.push([last[0] + at[i], last[1] + at[i + 1]]);
        }
      }
      return points;
    });
  }

  // A curve as [times, values], times ascending, a null between strokes.
  function curve(paths, x, y) {
    const all = paths.flatMap(strokes).sort((a, b) => a[0][0] - b[0][0]);
    const times = [], values = [];
    let last = -1;
    const push = (at, value) => {
      last = Math.max(at, last + 0.01);
      times.push(x[0] + (x[1] - x[0]) * last / WIDTH);
      values.push(value);
    };
    all.forEach((stroke, index) => {
      if (index > 0) push(last, null);
      for (const [at, up] of stroke) push(at, y[1] - (y[1] - y[0]) * up / HEIGHT);
    });
    return [times, values];
  }

  // The value of a curve at a time, between its samples; null in a gap.
  function valueAt([times, values], time) {
    let low = 0, high = times.length - 1;
    if (high < 0 || time < times[0] || time > times[high]) return null;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (times[middle] <= time) low = middle; else high = middle;
    }
    if (values[low] === null || values[high] === null) return null;
    const share = high > low ? (time - times[low]) / (times[high] - times[low]) : 0;
    return values[low] + share * (values[high] - values[low]);
  }

  // As many digits as a thousandth of the shown span has.
  function text(value, span) {
    const digits = Math.min(9, Math.max(0, 3 - Math.ceil(Math.log10(span))));
    return value.toFixed(digits).replace("-", "\u2212");
  }

  function seriesOf(drawing, x, y) {
    const byName = new Map();
    for (const path of drawing.querySelectorAll("path[data-name]")) {
      byName.set(path.dataset.name, [...(byName.get(path.dataset.name) ?? []), path]);
    }
    return [...byName].map(([name, paths]) => {
      const style = getComputedStyle(paths[0]);
      const dash = paths[0].classList.contains("dots") ? [] : style.strokeDasharray.match(/[\d.]+/g) ?? [];
      const isPoints = paths.every((path) => path.classList.contains("dots"));
      return { name, stroke: style.stroke, dash: dash.map(Number), isPoints, samples: curve(paths, x, y) };
    });
  }

  // Spans of time, as the drawing shades them.
  function shades(drawing) {
    return [...drawing.querySelectorAll("path[data-shade]")].flatMap((path) => {
      const fill = getComputedStyle(path).fill;
      return [...path.getAttribute("d").matchAll(/M(\d+) 0H(\d+)/g)].map((at) => [fill, +at[1], +at[2]]);
    });
  }

  function hoverBox(plot) {
    const box = document.createElement("div");
    box.className = "hover";
    plot.over.append(box);
    return box;
  }

  function showValues(plot, box, series, chart, x) {
    const { left, idx } = plot.cursor;
    const isShown = left >= 0 && idx !== null && idx !== undefined;
    box.hidden = !isShown;
    if (!isShown) return;
    const time = plot.posToVal(left, "x");
    const [low, high] = [plot.scales.y.min, plot.scales.y.max];
    const lines = series.filter((_, index) => plot.series[index + 1].show).flatMap((one) => {
      const value = valueAt(one.samples, time);
      return value === null ? [] : [[one, `${one.name}: ${text(value, high - low)} ${chart.dataset.unit}`.trim()]];
    });
    const [quantity, unit] = chart.dataset.over.split(", ");
    const head = document.createElement("div");
    head.textContent = `${quantity} ${text(time, plot.scales.x.max - plot.scales.x.min)} ${unit ?? ""}`;
    box.replaceChildren(head, ...lines.map(([one, line]) => {
      const row = document.createElement("div");
      row.textContent = line;
      row.style.borderLeft = `4px solid ${one.stroke}`;
      return row;
    }));
    const isRight = left > plot.over.clientWidth / 2;
    box.style.left = isRight ? "auto" : `${left + 12}px`;
    box.style.right = isRight ? `${plot.over.clientWidth - left + 12}px` : "auto";
  }

  function build(chart) {
    const drawing = chart.querySelector("svg");
    const [x, y] = [numbers(chart.dataset.x), numbers(chart.dataset.y)];
    const series = seriesOf(drawing, x, y);
    if (series.length === 0) return;
    const spans = shades(drawing);
    const size = drawing.getBoundingClientRect();
    const values = (_, ticks) => ticks.map((tick) => String(+tick.toPrecision(6)).replace("-", "\u2212"));
    const grid = { stroke: colour("--grid"), width: 1 };
    const axis = { stroke: colour("--quiet"), grid, values, ticks: { show: false }, font: "12px system-ui" };
    const span = `${chart.dataset.over} ${chart.dataset.x}`;
    const isWhole = (plot) => plot.scales.x.min <= x[0] && plot.scales.x.max >= x[1];
    const range = (plot, low, high) => {
      const isAsDrawn = isWhole(plot) || chart.dataset.fixed !== undefined || low === null || low === high;
      return isAsDrawn ? y : uPlot.rangeNum(low, high, 0.05, true);
    };
    let box;
    const plot = new uPlot({
      width: size.width,
      height: size.height,
      legend: { show: false },
      scales: {
        x: { time: false, range: (_, low, high) => (low === null || high === low ? x : [low, high]) },
        y: { range },
      },
      axes: [
        { ...axis, size: 28, gap: 4, label: chart.dataset.over, labelSize: 18, labelGap: 0, labelFont: "12px system-ui" },
        { ...axis, size: 52, gap: 6 },
      ],
      cursor: { y: false, points: { show: false }, sync: { key: span }, drag: { x: true, y: false } },
      // readings that no curve joins have points and no path
      series: [{}, ...series.map((one) => ({
        label: one.name, stroke: one.stroke, dash: one.dash, width: 1.6,
        ...(one.isPoints && { paths: () => null }),
        points: one.isPoints ? { show: true, size: 5, width: 0, fill: one.stroke } : { show: false },
      }))],
      hooks: {
        drawClear: [(plot) => {
          for (const [fill, from, to] of spans) {
            const [left, right] = [from, to].map((at) => plot.valToPos(x[0] + (x[1] - x[0]) * at / WIDTH, "x", true));
            const [start, end] = [Math.max(left, plot.bbox.left), Math.min(right, plot.bbox.left + plot.bbox.width)];
            plot.ctx.fillStyle = fill;
            if (end > start) plot.ctx.fillRect(start, plot.bbox.top, end - start, plot.bbox.height);
          }
        }],
        setScale: [(plot, key) => {
          if (key === "x" && box) zoomed.set(span, [plot.scales.x.min, plot.scales.x.max]);
        }],
        setCursor: [(plot) => { if (box) showValues(plot, box, series, chart, x); }],
      },
    }, uPlot.join(series.map((one) => one.samples)), chart);
    box = hoverBox(plot);
    box.hidden = true;
    plot.root.setAttribute("role", "img");
    plot.root.setAttribute("aria-label", drawing.getAttribute("aria-label"));
    chart.classList.add("live");
    live.set(chart, plot);
    const shown = zoomed.get(span);
    if (shown) plot.setScale("x", { min: shown[0], max: shown[1] });
    for (const hidden of chart.closest("[data-figure]").querySelectorAll(".legend [aria-pressed=false]")) {
      show(plot, hidden.dataset.name, false);
    }
  }

  function show(plot, name, isShown) {
    const index = plot.series.findIndex((one) => one.label === name);
    if (index > 0) plot.setSeries(index, { show: isShown });
  }

  // A legend entry hides and shows its curve in all plots of its figure.
  function makeButton(entry) {
    entry.setAttribute("role", "button");
    entry.setAttribute("aria-pressed", "true");
    entry.tabIndex = 0;
    const toggle = () => {
      const isShown = entry.getAttribute("aria-pressed") === "false";
      entry.setAttribute("aria-pressed", String(isShown));
      for (const chart of entry.closest("[data-figure]").querySelectorAll(".chart.live")) {
        show(live.get(chart), entry.dataset.name, isShown);
      }
    };
    entry.addEventListener("click", toggle);
    entry.addEventListener("keydown", (event) => {
      if (event.key === "Enter" || event.key === " ") { event.preventDefault(); toggle(); }
    });
  }

  function remove(chart) {
    live.get(chart)?.destroy();
    live.delete(chart);
    chart.classList.remove("live");
  }

  const seen = new IntersectionObserver((entries) => {
    for (const entry of entries) {
      if (entry.isIntersecting && !live.has(entry.target)) build(entry.target);
    }
  }, { rootMargin: "300px" });
  const sized = new ResizeObserver((entries) => {
    for (const { target, contentRect } of entries) {
      const plot = live.get(target);
      if (plot && contentRect.width > 0 && Math.abs(contentRect.width - plot.width) > 1) {
        plot.setSize({ width: contentRect.width, height: plot.height });
      }
    }
  });

  function attach(root) {
    for (const chart of root.querySelectorAll(".chart")) { seen.observe(chart); sized.observe(chart); }
    root.querySelectorAll(".legend [data-name]").forEach(makeButton);
  }
  // Before what is in the root is taken out of the document.
  function detach(root) {
    for (const chart of root.querySelectorAll(".chart")) { seen.unobserve(chart); sized.unobserve(chart); remove(chart); }
  }
  globalThis.livePlots = { attach, detach };
  attach(document);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
    for (const chart of [...live.keys()]) { remove(chart); build(chart); }
  });

  // A link to a folded section opens it.
  function open() {
    const target = document.getElementById(location.hash.slice(1));
    const fold = target?.closest("details");
    if (fold) { fold.open = true; fold.scrollIntoView(); }
  }
  addEventListener("hashchange", open);
  open();

  // The file has no date in it, so that the same run gives the same bytes: its own is shown.
  const facts = document.querySelector("footer dl");
  if (facts) {
    const [name, date] = [document.createElement("dt"), document.createElement("dd")];
    name.textContent = "Written";
    date.textContent = document.lastModified;
    facts.append(name, date);
  }
})();
