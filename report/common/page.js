// Interactive views in place of the still pictures: curves from the page, drawn by uPlot. Without this script, and on
// paper, the still pictures show the same curves.
"use strict";
(() => {
  const HEIGHT = 190, FONT = "12px system-ui, sans-serif";
  const ink = (role) => (role.startsWith("#") ? role : getComputedStyle(document.documentElement).getPropertyValue("--" + role).trim());
  // Numbers are steps of a 65535th of their range; the last step stands for a value that is not finite.
  const numbers = ({ low, high, steps }) => Array.from(new Uint16Array(Uint8Array.from(atob(steps), (c) => c.charCodeAt(0)).buffer), (k) => (k === 65535 ? null : low + (k / 65534) * (high - low)));
  const decades = (u, index, low, high) => {
    const found = [];
    for (let power = Math.floor(Math.log10(low)); power <= Math.ceil(Math.log10(high)); power += 1) {
      for (const lead of [1, 2, 5]) { const x = Number((lead * 10 ** power).toPrecision(1)); if (x >= low && x <= high) { found.push(x); } }
    }
    return found;
  };
  const faint = (f) => ink(f.ink) + Math.round(255 * f.opacity).toString(16).padStart(2, "0");
  // Steps of an axis far within a zoom differ in a later digit than three decimals show.
  const plain = (u, splits) => splits.map((x) => (x == null ? "" : String(Number(x.toPrecision(10)) || 0)));
  const written = (u, x) => (x == null ? "–" : String(Number(x.toPrecision(4))));

  const axis = (label, log) => ({
    label, labelFont: FONT, font: FONT, labelSize: 16, gap: 3, stroke: ink("text"), ticks: { stroke: ink("axis"), width: 1, size: 4 },
    grid: { stroke: ink("grid"), width: 1 }, size: 22, ...(log ? { splits: decades, values: (u, splits) => splits.map((x) => (String(x).match(/^[0.]*1[0e-]*/) ? String(x) : "")) } : { values: plain }),
  });

  // A long label of the y axis is written smaller, so that no part of it lies beyond the plot.
  const fitted = (label, height) => {
    const c = document.createElement("canvas").getContext("2d");
    c.font = FONT;
    return FONT.replace("12px", Math.min(12, (12 * (height - 48)) / Math.max(c.measureText(label).width, 1)).toFixed(1) + "px");
  };

  // Bands, levels and marks lie below the curves.
  const drawGround = (panel) => (u) => {
    const { left, top, width, height } = u.bbox, c = u.ctx;
    c.save(); c.beginPath(); c.rect(left, top, width, height); c.clip();
    for (const [low, high] of panel.bands) {
      const a = u.valToPos(high, "y", true), b = u.valToPos(low, "y", true);
      c.fillStyle = ink("band"); c.globalAlpha = 0.55; c.fillRect(left, a, width, b - a); c.globalAlpha = 1;
    }
    c.strokeStyle = ink("measured"); c.lineWidth = 1; c.setLineDash([4, 4]);
    for (const y of panel.levels) { const p = u.valToPos(y, "y", true); c.beginPath(); c.moveTo(left, p); c.lineTo(left + width, p); c.stroke(); }
    for (const x of panel.marks) { const p = u.valToPos(x, "x", true); c.beginPath(); c.moveTo(p, top); c.lineTo(p, top + height); c.stroke(); }
    c.restore();
  };

  // A curve in a plane, as a loop of friction over velocity: its abscissa goes to and fro.
  const drawPlane = (curve) => (u, index) => {
    const [xs, ys] = u.data[index], c = u.ctx, { left, top, width, height } = u.bbox, ratio = window.devicePixelRatio;
    c.save(); c.beginPath(); c.rect(left, top, width, height); c.clip();
    c.globalAlpha = curve.opacity; c.strokeStyle = c.fillStyle = ink(curve.ink); c.lineWidth = curve.width * ratio;
    c.setLineDash(curve.dashed ? [5 * ratio, 4 * ratio] : []); c.beginPath();
    xs.forEach((x, i) => {
      const px = u.valToPos(x, "x", true), py = u.valToPos(ys[i], "y", true);
      if (curve.dots) { c.fillRect(px - ratio, py - ratio, 2 * ratio, 2 * ratio); } else if (i) { c.lineTo(px, py); } else { c.moveTo(px, py); }
    });
    if (!curve.dots) { c.stroke(); }
    c.restore();
    return null;
  };

  // The point of a curve in a plane that stands next to the pointer; its rows are not in the order of its abscissa.
  const nearest = (u, index) => {
    const { left, top } = u.cursor;
    if (index === 0 || left < 0) { return null; }
    const [xs, ys] = u.data[index];
    let best = null, least = Infinity;
    xs.forEach((x, i) => {
      if (x == null || ys[i] == null) { return; }
      const far = Math.hypot(u.valToPos(x, "x") - left, u.valToPos(ys[i], "y") - top);
      if (far < least) { [best, least] = [i, far]; }
    });
    return best;
  };
  const unitless = (label) => (label || "").split(" [")[0];
  const pair = (panel) => (u, _, index, i) => (i == null ? "–" : `${unitless(panel.x_label) || "x"} ${written(u, u.data[index][0][i])}, ${unitless(panel.y_label) || "y"} ${written(u, u.data[index][1][i])}`);

  const scale = (range, log) => ({ time: false, auto: false, distr: log ? 3 : 1, min: range[0], max: range[1], range: (u, low, high) => [low ?? range[0], high ?? range[1]] });

  // After a zoom in time the ordinate follows what is seen; without zoom it is that of the still picture.
  const followZoom = (panel) => (u, key) => {
    if (key !== "x" || !panel.joint) { return; }
    const { min, max } = u.scales.x, whole = min <= panel.x_range[0] && max >= panel.x_range[1];
    let [low, high] = panel.y_range;
    if (!whole) {
      const seen = [...panel.bands.flat()];
      u.data.slice(1).forEach((ys) => u.data[0].forEach((x, i) => { if (x >= min && x <= max && ys[i] != null) { seen.push(ys[i]); } }));
      const a = Math.min(...seen), b = Math.max(...seen), rim = 0.05 * (b - a || 1);
      if (seen.length && !panel.y_log) { [low, high] = [a - rim, b + rim]; }
    }
    if (u.scales.y.min !== low || u.scales.y.max !== high) { u.setScale("y", { min: low, max: high }); }
  };

  const makePanel = (panel, box, key) => {
    const curves = panel.curves;
    const fills = panel.fills.flatMap((f) => [numbers(f.high), numbers(f.low)]);
    const data = panel.joint ? [numbers(curves[0].x), ...fills, ...curves.map((c) => numbers(c.y))] : [null, ...curves.map((c) => [numbers(c.x), numbers(c.y)])];
    const named = curves.some((c) => c.label);
    const series = curves.map((c) => ({
      label: c.label || panel.y_label || "y", class: c.label || !named ? null : "edge", stroke: ink(c.ink), fillMark: faint(c), width: c.width, alpha: c.opacity, dash: c.dashed ? [5, 4] : undefined,
      points: { show: c.dots && panel.joint, size: 3, fill: ink(c.ink) }, value: panel.joint ? written : pair(panel),
      ...(panel.joint ? (c.dots ? { paths: () => null } : {}) : { facets: [{ scale: "x", auto: false }, { scale: "y", auto: false }], paths: drawPlane(c) }),
    }));
    const reset = (u) => { u.batch(() => { u.setScale("x", { min: panel.x_range[0], max: panel.x_range[1] }); u.setScale("y", { min: panel.y_range[0], max: panel.y_range[1] }); }); };
    const height = panel.joint ? HEIGHT : 1.5 * HEIGHT;
    const options = {
      mode: panel.joint ? 1 : 2, width: Math.max(box.clientWidth, 200), height, padding: [6, 10, 0, 0],
      scales: { x: scale(panel.x_range, panel.x_log), y: scale(panel.y_range, panel.y_log) },
      axes: [axis(panel.x_label, panel.x_log), { ...axis(panel.y_label, panel.y_log), labelFont: fitted(panel.y_label || "", height), size: 56 }],
      series: [panel.joint ? { label: panel.x_label || "x", value: written } : {}, ...fills.map(() => ({ class: "edge", width: 0, points: { show: false } })), ...series],
      bands: panel.fills.map((f, i) => ({ series: [2 * i + 1, 2 * i + 2], fill: faint(f) })),
      legend: { markers: { width: 0, fill: (u, i) => u.series[i].fillMark } }, hooks: { drawAxes: [drawGround(panel)], setScale: [followZoom(panel)] },
      cursor: {
        drag: { x: true, y: !panel.joint }, bind: { dblclick: () => () => { group(key).forEach((goBack) => goBack()); return null; } },
        ...(panel.joint ? { sync: { key, scales: ["x", null] } } : { dataIdx: nearest, points: { size: 7 } }),
      },
    };
    const made = new uPlot(options, data, box);
    group(key).push(() => reset(made));
    return made;
  };

  const groups = new Map();
  const group = (key) => { if (!groups.has(key)) { groups.set(key, []); } return groups.get(key); };
  const drawn = [];

  const make = (store, number) => {
    const panels = JSON.parse(store.textContent), figure = store.parentElement, still = figure.querySelector(".still");
    const live = document.createElement("div");
    live.className = "live"; live.setAttribute("role", "img"); live.setAttribute("aria-label", figure.querySelector("img").alt);
    figure.insertBefore(live, still);
    const columns = new Map();
    for (const panel of panels) {
      if (!columns.has(panel.column)) { columns.set(panel.column, live.appendChild(document.createElement("div"))); }
    }
    const plots = panels.map((panel) => {
      const column = columns.get(panel.column);
      if (panel.title) { const title = column.appendChild(document.createElement("p")); title.className = "panel-title"; title.textContent = panel.title; }
      const box = column.appendChild(document.createElement("div"));
      return [makePanel(panel, box, number + ":" + panel.column), box];
    });
    drawn.push({ store, live, plots, number });
  };

  const clear = (one) => { one.plots.forEach(([plot]) => plot.destroy()); one.live.remove(); };
  const stores = [...document.querySelectorAll("script.panels")];
  const waiting = new Map(stores.map((store, number) => [store.parentElement, [store, number]]));
  const watcher = new IntersectionObserver((seen) => {
    for (const one of seen) {
      const entry = waiting.get(one.target);
      if (one.isIntersecting && entry) { waiting.delete(one.target); watcher.unobserve(one.target); make(...entry); }
    }
  }, { rootMargin: "1200px" });
  waiting.forEach((_, figure) => watcher.observe(figure));

  const redraw = () => { const all = drawn.splice(0); groups.clear(); all.forEach((one) => { clear(one); make(one.store, one.number); }); };
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
  let width = innerWidth;
  addEventListener("resize", () => { if (innerWidth !== width) { width = innerWidth; drawn.forEach(({ plots }) => plots.forEach(([plot, box]) => plot.setSize({ width: Math.max(box.clientWidth, 200), height: plot.height }))); } });

  // A still picture tells the mark next to the pointer; with arrow keys, one mark after another.
  const beyond = (low, high, place) => Math.max(low - place, 0, place - high);
  const tellMarks = (store) => {
    const figure = store.parentElement, still = figure.querySelector(".still"), image = still.querySelector("img"), line = figure.querySelector(".told");
    const both = JSON.parse(store.textContent), spot = document.createElement("span");
    const marks = () => both[image.currentSrc === image.src ? 0 : 1];
    let told = -1;
    const tell = (number) => {
      told = number;
      const [x, y, text] = marks()[number];
      if (!spot.parentElement) { spot.className = "spot"; still.append(spot); }
      spot.style.left = x * image.clientWidth + "px"; spot.style.top = y * image.clientHeight + "px";
      line.textContent = text;
    };
    line.textContent = "–";
    still.addEventListener("pointermove", (event) => {
      const box = image.getBoundingClientRect();
      const far = marks().map(([, , , [left, top, right, bottom]]) => Math.hypot(
        box.width * beyond(left, right, (event.clientX - box.left) / box.width), box.height * beyond(top, bottom, (event.clientY - box.top) / box.height)));
      tell(far.indexOf(Math.min(...far)));
    });
    still.addEventListener("keydown", (event) => {
      const step = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key], count = marks().length;
      if (!step) { return; }
      event.preventDefault();
      tell(told < 0 ? (step > 0 ? 0 : count - 1) : (told + step + count) % count);
      still.scrollLeft = spot.offsetLeft - still.clientWidth / 2; // a picture that is wider than a phone follows
    });
  };
  const marked = [...document.querySelectorAll("script.marks")];
  marked.forEach(tellMarks);

  // A cell of a matrix tells the names of its row and its column.
  const cells = document.querySelectorAll("td.shade");
  cells.forEach((cell) => cell.addEventListener("pointerenter", () => {
    cell.title = cell.parentElement.cells[0].textContent + ", " + cell.dataset.label + ": " + cell.textContent;
  }));

  const hints = [];
  if (stores.length) { hints.push("Figures of curves: drag over a part to enlarge it, double-click to go back; the line below reads values at the pointer."); }
  if (marked.length) { hints.push("Figures of bars and intervals: the line below tells the value next to the pointer; arrow keys go from one to the next."); }
  if (cells.length) { hints.push("Matrices: a cell under the pointer tells its row and column."); }
  if (document.querySelectorAll("figure").length > stores.length + marked.length) { hints.push("Other figures are still pictures."); }
  const hint = document.createElement("p");
  hint.className = "hint"; hint.textContent = hints.join(" ");
  document.querySelector("nav").after(hint);
})();
