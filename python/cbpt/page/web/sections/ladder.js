/** 8. The ladder: the error in sample and held out with each effect added, noise floor, stop mark. */

/** @import { Theme } from "../lib/figure.js" */
/** @import { Rung } from "../types.d.ts" */
import { bodyOf, el, fill, table } from "../lib/dom.js";
import { Figure, safe } from "../lib/figure.js";
import { plain, text } from "../lib/numbers.js";
import {
  documentShown,
  modelOf,
  modelShown,
  on,
  scale,
  setModel,
  size,
  state,
} from "../lib/store.js";

/** Room for the names of the rungs, px. */
const LEFT = 148, RIGHT = 16;
/** Width of a letter of a mark, px. */
const MARK_LETTER = 6;
const HEIGHT = 330, TOP = 26, BOTTOM = 44, LINE = 16;

/** @type {Figure} */
let figure;
/** @type {HTMLElement} */
let note;
/** @type {HTMLElement} */
let rows;

export function setUpLadder() {
  const plot = el("div", { id: "ladder-plot" });
  note = el("span", { class: "small quiet" });
  rows = el("div", { class: "card" });
  fill(
    bodyOf("ladder"),
    el("div", { class: "grid two" }, el("div", { class: "card" }, plot), rows),
  );
  figure = new Figure(plot, "ladder", "Error in sample and held out for each effect added", build, {
    height: HEIGHT,
  });
  figure.under(note);
  on(["document", "model", "models", "unit"], () => {
    figure.options.height = heightFor(rungs());
    figure.draw();
    drawRows();
    fill(note, `● in sample  ◇ held out. ${floorSays()}`);
  });
}

/** The rungs of the diagnosis; below them the steps to the model shown, where it is none of them. @returns {(Rung & { shown?: boolean })[]} */
function rungs() {
  const whole = documentShown();
  const m = modelShown();
  const list = whole.ladder?.rungs.map((r) => ({ ...r, shown: r.key === m.key })) ?? [];
  if (list.some((r) => r.shown) || m.rmse_arcsec === null) return list;
  if (m.ladder?.length) {
    const steps = m.ladder.filter((r) => !list.some((known) => known.key === r.key));
    return [...list, ...steps.map((r, k) => ({ ...r, shown: k === steps.length - 1 }))];
  }
  return [...list, {
    added: "",
    label: m.label,
    key: m.key,
    effects: m.effects,
    in_sample_arcsec: m.rmse_arcsec,
    held_out_arcsec: m.held_out_rmse_arcsec,
    chi2_per_dof: m.chi2_per_dof,
    shown: true,
  }];
}

/** How many rungs are the diagnosis' own. */
function weighed() {
  return documentShown().ladder?.rungs.length ?? 0;
}

/** After which rung the diagnosis stopped, where it went on to look. */
function stopOf() {
  const found = documentShown().ladder;
  return found && found.stop + 1 < found.rungs.length ? found.stop : null;
}

/** What the dotted line is. */
function floorSays() {
  const noise = documentShown().noise;
  if (!noise) return "";
  return noise.noise_floor_arcsec === null
    ? `The noise floor ${noise.noise_floor_of}.`
    : `A model with an error below the noise floor (${noise.noise_floor_of}) fits noise.`;
}

/**
 * A line across between two rungs with a word on it.
 * @param {number} after @param {string} words @param {string} colour @param {string} dash
 */
function mark(after, words, colour, dash) {
  const across = { xref: "paper", x0: 0, x1: 1, y0: after + 0.5, y1: after + 0.5 };
  return {
    shape: { type: "line", ...across, line: { color: colour, width: 2, dash } },
    annotation: {
      xref: "paper",
      x: 1,
      xanchor: "right",
      y: after + 0.5,
      yanchor: dash === "dash" ? "bottom" : "top",
      text: words,
      showarrow: false,
      font: { size: 11, color: colour },
    },
  };
}

/** Words of a mark where they fit beside the names; else where they stand. @param {string} words */
function fitted(words) {
  const letters = (figure.area.clientWidth - LEFT - RIGHT) / MARK_LETTER;
  return words.length < letters ? words : letters < 40 ? "stop" : "stop: see the table";
}

/** @param {Rung} r */
function nameOf(r) {
  const name = r.label.replaceAll("_", " ") +
    (modelOf(r.key)?.converged === false ? " (rough\u00a0fit)" : "");
  return r.added && r.key !== "refitted" && r.key !== "unknown" ? `+ ${name}` : name;
}

/** @param {Theme} t */
function build(t) {
  const whole = documentShown();
  const list = rungs();
  const stop = stopOf();
  // The words stand in the table too.
  const says = safe(whole.ladder?.stop_says ?? "");
  const marks = [
    stop !== null && mark(stop, fitted(says), t.warn, "dash"),
    weighed() > 0 && list.length > weighed() &&
    mark(weighed() - 1, "steps to the model shown", t.quiet, "solid"),
  ].filter((m) => m !== false);
  const s = scale();
  const at = list.map((_, k) => k);
  const inside = list.map((r) => r.in_sample_arcsec * s);
  const outside = list.map((r) => (r.held_out_arcsec === null ? null : r.held_out_arcsec * s));
  const floor = whole.noise?.noise_floor_arcsec ? whole.noise.noise_floor_arcsec * s : null;
  const all =
    /** @type {number[]} */ ([...inside, ...outside, floor].filter((v) => v !== null && v > 0));
  const span = Math.log10(Math.max(...all) / Math.min(...all));
  const room = 0.09 * span + 0.05;
  const ends = [Math.log10(Math.min(...all)) - room, Math.log10(Math.max(...all)) + room];
  const ticks = nice(ends, Math.max(3, (figure.area.clientWidth - LEFT) / 40));
  const hover = `%{text}: %{x:.3f} ${state.unit}<extra>`;
  const names = list.map((r) => safe(nameOf(r)));
  return {
    data: [
      {
        type: "scatter",
        mode: "lines",
        hoverinfo: "skip",
        line: { color: t.line, width: 3 },
        x: list.flatMap((_, k) => [inside[k], outside[k], null]),
        y: list.flatMap((_, k) => [k, k, null]),
      },
      {
        type: "scatter",
        mode: "markers",
        x: inside,
        y: at,
        text: names,
        hovertemplate: `${hover}in sample</extra>`,
        marker: {
          opacity: 1,
          size: list.map((r) => (r.shown ? 15 : 11)),
          color: t.accent,
          line: { width: list.map((r) => (r.shown ? 3 : 0)), color: t.ink },
        },
      },
      {
        type: "scatter",
        mode: "markers",
        x: outside,
        y: at,
        text: names,
        hovertemplate: `${hover}held out</extra>`,
        marker: {
          size: 12,
          symbol: "diamond-open",
          color: t.warn,
          line: { width: 2.2, color: t.warn },
        },
      },
    ],
    layout: {
      margin: { l: LEFT, r: RIGHT, t: TOP, b: BOTTOM },
      xaxis: {
        title: `error, rms (${state.unit})`,
        type: "log",
        range: ends,
        tickvals: ticks,
        ticktext: ticks.map((v) => plain(v)),
        tickangle: 0,
        zeroline: false,
      },
      yaxis: {
        tickvals: at,
        ticktext: names.map((n, k) => list[k].shown ? `<b>${wrapped(n)}</b>` : wrapped(n)),
        range: [list.length - 0.5, -0.5],
        showgrid: false,
        zeroline: false,
        ticks: "",
      },
      shapes: [
        ...(floor
          ? [{
            type: "line",
            x0: floor,
            x1: floor,
            yref: "paper",
            y0: 0,
            y1: 1,
            line: { color: t.quiet, width: 1.5, dash: "dot" },
          }]
          : []),
        ...marks.map((m) => m.shape),
      ],
      annotations: [
        ...(floor
          ? [{
            x: Math.log10(floor),
            yref: "paper",
            y: 1,
            yanchor: "bottom",
            text: "noise floor",
            showarrow: false,
            font: { size: 11, color: t.quiet },
          }]
          : []),
        ...marks.map((m) => m.annotation),
      ],
    },
  };
}

/**
 * Round numbers between two ends of a logarithmic scale.
 * @param {number[]} ends logarithms @param {number} most
 */
function nice(ends, most) {
  /** @type {number[]} */
  let found = [];
  for (const steps of [[1, 2, 3, 5], [1, 2, 5], [1, 3], [1]]) {
    found = [];
    for (let decade = Math.floor(ends[0]); decade <= ends[1]; decade++) {
      for (const v of steps) found.push(Number((v * 10 ** decade).toPrecision(1)));
    }
    found = found.filter((v) => Math.log10(v) >= ends[0] && Math.log10(v) <= ends[1]);
    if (found.length <= most) break;
  }
  return found;
}

/** So that names of several lines do not run into each other, px. @param {Rung[]} list */
function heightFor(list) {
  const lines = list.map((r) => wrapped(nameOf(r)).split("<br>").length);
  return Math.max(HEIGHT, TOP + BOTTOM + list.length * (LINE * Math.max(...lines) + 4));
}

/** Plotly breaks no lines itself. @param {string} name */
function wrapped(name) {
  const words = name.split(" ");
  let line = "";
  /** @type {string[]} */
  const lines = [];
  for (const word of words) {
    if (line && (line + word).length > 22) {
      lines.push(line);
      line = word;
    } else line = line ? `${line} ${word}` : word;
  }
  return [...lines, line].join("<br>");
}

/** What an error held out far below the one in sample means, where there is one. @param {Rung[]} list */
function looseSays(list) {
  const loose = documentShown().ladder?.loose;
  const found = loose &&
    list.some((r) =>
      r.effects.length > 0 && (r.held_out_arcsec ?? Infinity) < loose.below * r.in_sample_arcsec
    );
  return found ? ` ${loose.says}` : "";
}

function drawRows() {
  const whole = documentShown();
  const list = rungs();
  const place = table(
    "Error ladder",
    ["model", { text: "in sample", number: true }, { text: "held out", number: true }, {
      text: "χ²/dof",
      number: true,
    }],
    list.map((r, k) => [
      modelOf(r.key)
        ? el("button", {
          type: "button",
          class: "text",
          "aria-pressed": String(!!r.shown),
          onclick: () => setModel(r.key),
        }, nameOf(r))
        : nameOf(r),
      size(r.in_sample_arcsec),
      size(r.held_out_arcsec),
      [
        text(r.chi2_per_dof),
        whole.ladder?.stop === k &&
        el(
          "span",
          { class: "visually-hidden" },
          whole.answer_key === null
            ? whole.undecided
              ? " (the readings do not decide)"
              : " (the best library effect; it does not explain the readings)"
            : " (the answer stops here)",
        ),
      ],
    ]),
  );
  place.querySelectorAll("tbody tr").forEach((tr, k) => {
    tr.classList.toggle("shown", !!list[k].shown);
    tr.classList.toggle("stop", stopOf() === k);
    tr.classList.toggle("apart", weighed() > 0 && weighed() === k);
  });
  fill(
    rows,
    place,
    el(
      "p",
      { class: "small quiet" },
      whole.ladder
        ? `Each row holds all effects of the rows above it; the errors do not add up. Errors in ${state.unit}; held out by ${whole.ladder.held_out_by}.${
          stopOf() === null ? "" : ` Dashed: ${whole.ladder.stop_says}.`
        }${looseSays(list)}`
        : whole.reasons.ladder,
    ),
  );
}
