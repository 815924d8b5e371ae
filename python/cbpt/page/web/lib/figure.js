/**
 * How plots are drawn: colours of light and dark, few enough points to stay fluid, SVG to take away.
 *
 * A figure is a place and a function that builds its traces; it is drawn again when what it shows
 * changes, in the light colours on paper and in files.
 */

/** @import { Points } from "./points.js" */
import { announce, el, trouble } from "./dom.js";
import { plotlyReady } from "./plotly.js";
import { asTraces, layOver } from "./points.js";
import { leftMargin, MOST_PLAIN_POWER, sketch } from "./sketch.js";

/** @typedef {{ dark: boolean, ink: string, quiet: string, line: string, faint: string, card: string,
 *   accent: string, warn: string, levels: (n: number) => string[], diverging: [number, string][],
 *   single: [number, string][] }} Theme */
/** @typedef {{ data: any[], layout: any, points?: Points[] }} Built points: drawn over the traces */

/** Points that one line has at most. */
export const MOST_POINTS = 4000;

/** Numbers of axes: plain, beyond that as powers of ten, never with an ending such as k. */
const NUMBERS = { exponentformat: "power", minexponent: MOST_PLAIN_POWER };

/** What A4 leaves between the margins, and the frame of a card, px. */
const PAPER_WIDTH = 640;

const night = matchMedia("(prefers-color-scheme: dark)");
let onPaper = false;

/** @type {Theme} */
const LIGHT = {
  dark: false,
  ink: "#1d232b",
  quiet: "#5b6572",
  line: "#c9ced4",
  faint: "#eceef0",
  card: "#ffffff",
  accent: "#0a5ca8",
  warn: "#b34700",
  levels: (n) => ramp(["#16316b", "#2476a8", "#35968a", "#9a8420", "#c4622d"], n),
  diverging: [[0, "#174f8f"], [0.25, "#7eabd3"], [0.5, "#f6f6f3"], [0.75, "#eba868"], [
    1,
    "#a34700",
  ]],
  single: [[0, "#f6f6f3"], [0.5, "#8fb8d8"], [1, "#123f73"]],
};

/** @type {Theme} */
const DARK = {
  dark: true,
  ink: "#e4e8ec",
  quiet: "#9aa5b1",
  line: "#404a55",
  faint: "#28303a",
  card: "#1b2027",
  accent: "#6db3f2",
  warn: "#f2a25c",
  levels: (n) => ramp(["#7f9cf0", "#55b4de", "#52c4a8", "#d6c25a", "#f09a62"], n),
  diverging: [[0, "#8cc4f5"], [0.25, "#3d7ab0"], [0.5, "#252c34"], [0.75, "#b06a2c"], [
    1,
    "#ffc08a",
  ]],
  single: [[0, "#252c34"], [0.5, "#3f78a8"], [1, "#a8d8ff"]],
};

/** The colours of now. @returns {Theme} */
export function theme() {
  return night.matches && !onPaper ? DARK : LIGHT;
}

/**
 * Colours along a ramp, ends included.
 * @param {string[]} stops @param {number} n
 */
function ramp(stops, n) {
  if (n <= 1) return [stops[1]];
  return Array.from({ length: n }, (_, k) => {
    const at = (k / (n - 1)) * (stops.length - 1);
    const low = Math.min(Math.floor(at), stops.length - 2);
    const part = (/** @type {string} */ s, /** @type {number} */ i) =>
      parseInt(s.slice(1 + 2 * i, 3 + 2 * i), 16);
    const mixed = [0, 1, 2].map((i) =>
      Math.round(part(stops[low], i) * (1 - at + low) + part(stops[low + 1], i) * (at - low))
    );
    return `#${mixed.map((v) => v.toString(16).padStart(2, "0")).join("")}`;
  });
}

/** @type {Figure[]} */
const figures = [];

export class Figure {
  /**
   * @param {HTMLElement} place
   * @param {string} name of the file it is saved as
   * @param {string} label what a screen reader says
   * @param {(theme: Theme) => Built | null} build
   * @param {{ height: number, paper?: number, bar?: boolean, first?: boolean }} options
   *   paper: the height on paper; first: sketched where the plotting library is still to be read
   */
  constructor(place, name, label, build, options) {
    this.place = place;
    this.name = name;
    this.build = build;
    this.options = options;
    this.label = label;
    this.area = el("div", { class: "area", role: "img", "aria-label": label });
    this.area.style.minHeight = `${this.height()}px`;
    this.save = el(
      "button",
      { type: "button", class: "text small no-print", onclick: () => this.saveSvg() },
      "SVG",
      el("span", { class: "visually-hidden" }, ` of ${label}`),
    );
    place.classList.add("plot");
    place.append(this.area);
    this.drawn = false;
    this.asWideAsPaper = false;
    /** @type {SVGElement | null} what stands for the plot until Plotly is there */
    this.sketch = null;
    /** @type {Points[] | undefined} */
    this.points = undefined;
    /** @type {(() => void) | undefined} when Plotly has given the area its events */
    this.onFirst = undefined;
    figures.push(this);
  }

  /** The line below the plot: a note, and the button that saves it. @param {HTMLElement} note */
  under(note) {
    this.place.append(el("div", { class: "under" }, note, this.save));
  }

  /** Of now, px. */
  height() {
    return (onPaper && this.options.paper) || this.options.height;
  }

  /** Draw, or draw again: at once where it is in sight, else as soon as there is time. */
  draw() {
    if (this.isInSight()) this.drawNow();
    else later(this);
  }

  isInSight() {
    const { top, bottom } = this.area.getBoundingClientRect();
    return bottom > 0 && top < innerHeight;
  }

  drawNow() {
    waiting.delete(this);
    if (!this.area.isConnected) return;
    if (!globalThis.Plotly) {
      if (this.options.first) this.drawSketch();
      return later(this);
    }
    if (!this.drawn) this.empty();
    const built = this.build(theme());
    if (!built) return;
    const { data, layout } = this.dressed(built, theme());
    // The browser lays the sheet of paper out only after this; Plotly keeps the width of before
    // where it is not told another.
    if (onPaper) layout.width = PAPER_WIDTH;
    else if (this.asWideAsPaper) layout.width = this.area.clientWidth;
    this.asWideAsPaper = onPaper;
    this.area.style.minHeight = `${this.height()}px`;
    Plotly.react(this.area, data, layout, {
      displaylogo: false,
      responsive: true,
      displayModeBar: this.options.bar ? "hover" : false,
      // Plotly would offer to upload the readings to its makers.
      plotlyServerURL: "",
      modeBarButtonsToRemove: [
        "sendChartToCloud",
        "sendDataToCloud",
        "toImage",
        "lasso2d",
        "autoScale2d",
      ],
      scrollZoom: false,
    });
    this.points = built.points;
    if (!this.drawn) {
      this.drawn = true;
      // Whenever Plotly draws, after a zoom or in another size too.
      /** @type {any} */ (this.area).on("plotly_afterplot", () => this.finish());
      this.onFirst?.();
    }
    this.finish();
  }

  /** What Plotly leaves out. */
  finish() {
    if (this.points) layOver(this.area, this.points);
    const tools = this.area.querySelector("[role=toolbar]");
    tools?.setAttribute("aria-label", `Tools of the plot: ${this.label}`);
  }

  drawSketch() {
    const built = this.build(theme());
    const drawing = built && sketch(
      { ...this.dressed(built, theme()), points: built.points },
      onPaper ? PAPER_WIDTH : this.area.clientWidth,
      theme(),
    );
    this.sketch?.remove();
    this.sketch = drawing;
    if (!drawing) return;
    this.area.style.minHeight = `${this.height()}px`;
    this.area.prepend(drawing);
    widths.observe(this.area);
  }

  /** Before Plotly draws here. */
  empty() {
    if (this.area.contains(document.activeElement)) this.save.focus({ preventScroll: true });
    this.area.replaceChildren();
    this.area.setAttribute("role", "img");
    this.sketch = null;
    widths.unobserve(this.area);
  }

  /** Say that Plotly is not there, and let it be asked for again. @param {string} why */
  lack(why) {
    if (this.drawn || this.area.querySelector(".unplotted")) return;
    // What is inside a picture cannot be reached.
    this.area.setAttribute("role", "group");
    this.area.append(
      el(
        "p",
        { class: "unplotted small quiet" },
        why,
        el("button", { type: "button", class: "no-print", onclick: plan }, "Try again"),
      ),
    );
  }

  /**
   * Fonts, grids and margins, the same in every plot.
   * @param {Built} built @param {Theme} t @returns {Built}
   */
  dressed({ data, layout }, t) {
    const axis = {
      gridcolor: t.faint,
      zerolinecolor: t.line,
      linecolor: t.line,
      tickcolor: t.line,
      ...NUMBERS,
      ticks: "outside",
      ticklen: 4,
      title: { standoff: 6 },
    };
    /** @type {any} */
    const whole = {
      height: this.height(),
      margin: { l: 54, r: 12, t: 10, b: 42 },
      paper_bgcolor: "rgba(0,0,0,0)",
      plot_bgcolor: "rgba(0,0,0,0)",
      font: { family: 'system-ui, "DejaVu Sans", sans-serif', size: 12, color: t.ink },
      hoverlabel: { bgcolor: t.card, bordercolor: t.line, font: { color: t.ink, size: 12 } },
      separators: ".", // no commas in thousands
      showlegend: false,
      hovermode: "closest",
      dragmode: false,
      modebar: { bgcolor: "rgba(0,0,0,0)", color: t.quiet, activecolor: t.accent },
      ...layout,
    };
    for (const key of Object.keys(whole)) {
      if (/^[xy]axis\d*$/.test(key)) {
        const own = whole[key];
        whole[key] = {
          ...axis,
          automargin: key.startsWith("y"), // long numbers would run into the title
          ...own,
          title: { ...axis.title, font: { size: 12, color: t.quiet }, text: own.title ?? "" },
        };
      }
    }
    if (this.options.first) {
      whole.margin = { ...whole.margin, l: Math.max(whole.margin.l, leftMargin(whole)) };
    }
    return {
      data: data.map((d) => d.colorbar ? { ...d, colorbar: { ...NUMBERS, ...d.colorbar } } : d),
      layout: whole,
    };
  }

  async saveSvg() {
    const built = this.build(LIGHT);
    if (!built) return;
    try {
      await plotlyReady();
    } catch (error) {
      return trouble(error instanceof Error ? error.message : String(error));
    }
    if (waiting.size) plan();
    const { data, layout } = this.dressed(built, LIGHT);
    const traces = [...data, ...asTraces(built.points ?? [])];
    const url = await Plotly.toImage({
      data: traces,
      layout: { ...layout, paper_bgcolor: "#ffffff" },
    }, {
      format: "svg",
      width: Math.max(this.area.clientWidth, 640),
      height: this.options.height,
    });
    saveFile(
      `${this.name}.svg`,
      decodeURIComponent(url.slice(url.indexOf(",") + 1)),
      "image/svg+xml",
    );
  }
}

/** @type {(() => void)[]} */
const painters = [];

/** What draws in the colours of now, besides figures. @param {() => void} act */
export function onTheme(act) {
  painters.push(act);
}

/** @param {(figure: Figure) => void} draw */
function repaint(draw) {
  for (const act of painters) act();
  for (const figure of figures) draw(figure);
}

/** Plots that are sketches still. */
function sketchAgain() {
  for (const figure of figures) if (figure.sketch) figure.drawSketch();
}

/** Plotly follows the width itself. */
const widths = new ResizeObserver((seen) => {
  for (const { target } of seen) {
    const figure = figures.find((f) => f.area === target);
    if (onPaper || !figure?.sketch || !target.clientWidth) continue;
    if (Number(figure.sketch.getAttribute("width")) !== target.clientWidth) figure.drawSketch();
  }
});

night.addEventListener("change", () => repaint((f) => f.drawn && f.draw()));
night.addEventListener("change", sketchAgain);
/** What is folded away on the screen. @type {HTMLDetailsElement[]} */
let folded = [];
addEventListener("beforeprint", () => {
  onPaper = true;
  repaint((f) => f.drawNow());
  folded = [...document.querySelectorAll("details")].filter((d) => !d.open);
  for (const part of folded) part.open = true;
});
addEventListener("afterprint", () => {
  onPaper = false;
  // At once and all: one that waits to be seen is as wide as paper and holds the page open.
  repaint((f) => f.drawn && f.drawNow());
  for (const part of folded) part.open = false;
});

addEventListener("afterprint", sketchAgain);

/** For the screen to show what is there, before the page is busy again. */
const REST_MS = 50;
/** @type {Set<Figure>} */
const waiting = new Set();
/** Which plan holds: a later one takes the place of those before. */
let latest = 0;

/** @param {Figure} figure */
function later(figure) {
  waiting.add(figure);
  plan();
}

/** What waits is drawn once Plotly is there; where it is not to be had, each plot says so. */
function plan() {
  document.documentElement.removeAttribute("data-drawn");
  const mine = ++latest;
  // What is in sight is on the screen before the rest is drawn.
  painted().then(plotlyReady).then(
    () => setTimeout(drawNext, REST_MS, mine),
    (error) => {
      if (mine !== latest) return;
      for (const figure of waiting) figure.lack(error.message);
      announce(error.message);
      document.documentElement.dataset.drawn = "true";
    },
  );
}

/** One figure at a time, so that the page answers in between. @param {number} mine */
function drawNext(mine) {
  if (mine !== latest) return;
  const next = [...waiting].find((figure) => !paused || figure.isInSight());
  next?.drawNow();
  if (waiting.size) setTimeout(drawNext, next ? 0 : REST_MS, mine);
  else markDrawn();
}

let paused = false;

/** Draw nothing out of sight until `resume`: what is on its way is drawn first. */
export function pause() {
  paused = true;
}

/** What waits is drawn as soon as there is time. */
export function resume() {
  paused = false;
  if (waiting.size) plan();
  else markDrawn();
}

/** Told to whoever looks on (tests, scripts): nothing is left to draw. */
export function markDrawn() {
  if (!waiting.size) document.documentElement.dataset.drawn = "true";
}

/** Resolved once what has changed is on the screen; at once where the page is not to be seen. @returns {Promise<void>} */
export function painted() {
  return new Promise((done) => {
    if (document.hidden) setTimeout(done, 0);
    // The second frame begins when the first is there.
    else requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(done, 0)));
  });
}

/**
 * At most `most` of the rows, in order: of each stretch along x the ends, the lowest and highest.
 * What stands out is always drawn; computing never sees a thinned table.
 * @param {number[]} rows indices
 * @param {readonly (number | null)[]} x
 * @param {readonly (number | null)[]} y
 * @param {number} most
 * @returns {number[]}
 */
export function thin(rows, x, y, most) {
  if (rows.length <= most) return rows;
  const sorted = [...rows].sort((a, b) => (x[a] ?? 0) - (x[b] ?? 0));
  const stretches = Math.max(1, Math.floor(most / 4));
  const keep = new Set();
  for (let k = 0; k < stretches; k++) {
    const from = Math.floor((k * sorted.length) / stretches);
    const to = Math.floor(((k + 1) * sorted.length) / stretches);
    if (to <= from) continue;
    let low = sorted[from], high = sorted[from];
    for (let i = from; i < to; i++) {
      if ((y[sorted[i]] ?? 0) < (y[low] ?? 0)) low = sorted[i];
      if ((y[sorted[i]] ?? 0) > (y[high] ?? 0)) high = sorted[i];
    }
    for (const row of [sorted[from], low, high, sorted[to - 1]]) keep.add(row);
  }
  return rows.filter((row) => keep.has(row));
}

/**
 * Hand a file to whoever reads the page.
 * @param {string} name @param {string} content @param {string} type
 */
export function saveFile(name, content, type) {
  const url = URL.createObjectURL(new Blob([content], { type }));
  const link = el("a", { href: url, download: name });
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(url), 10000);
  announce(`${name} saved`);
}

/** An SVG element of the page as a file. @param {SVGElement} drawing @param {string} name */
export function saveDrawing(drawing, name) {
  const copy = /** @type {SVGElement} */ (drawing.cloneNode(true));
  copy.setAttribute("xmlns", "http://www.w3.org/2000/svg");
  saveFile(`${name}.svg`, new XMLSerializer().serializeToString(copy), "image/svg+xml");
}

/** Plotly reads a few tags in texts: a name from a file has none. @param {unknown} name */
export function safe(name) {
  return String(name).replaceAll("&", "&amp;").replaceAll("<", "&lt;").replaceAll(">", "&gt;")
    .replaceAll("%{", "% {");
}
