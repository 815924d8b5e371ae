/** 5. The ladder: the error in sample and held out with each effect added, noise floor, stop mark. */

/** @import { Theme } from "./figure.js" */
/** @import { Rung } from "./types.d.ts" */
import { bodyOf, byId, el, fill, table } from "./dom.js";
import { Figure } from "./figure.js";
import { fixed, plain, text } from "./numbers.js";
import { safe } from "./readings.js";
import { documentShown, modelOf, modelShown, on, scale, setModel, state } from "./store.js";

/** @type {Figure} */
let figure;
/** @type {HTMLElement} */
let rows;

export function setUpLadder() {
  const plot = el("div", { id: "ladder-plot" });
  rows = el("div", { class: "card" });
  fill(
    bodyOf("ladder"),
    el("div", { class: "grid two" }, el("div", { class: "card" }, plot), rows),
  );
  figure = new Figure(plot, "ladder", "Error in sample and held out for each effect added", build, {
    height: 330,
  });
  plot.append(
    el(
      "div",
      { class: "under" },
      el(
        "span",
        { class: "small quiet" },
        "● in sample  ◇ held out. ",
        el("span", { id: "floor-says" }),
      ),
      figure.save,
    ),
  );
  on(["document", "model", "models", "unit"], () => {
    figure.draw();
    drawRows();
  });
}

/** The rungs of the diagnosis, and the model shown where it is none of them. @returns {(Rung & { shown?: boolean })[]} */
function rungs() {
  const whole = documentShown();
  const m = modelShown();
  const list = whole.ladder?.rungs.map((r) => ({ ...r, shown: r.key === m.key })) ?? [];
  if (list.some((r) => r.shown) || m.rmse_arcsec === null) return list;
  if (m.ladder?.length) {
    const steps = [...list.slice(0, 1), ...m.ladder];
    return steps.map((r, k) => ({ ...r, shown: k === steps.length - 1 }));
  }
  return [...list, {
    added: "",
    label: whole.ladder ? `shown: ${m.label}` : m.label,
    key: m.key,
    effects: m.effects,
    in_sample_arcsec: m.rmse_arcsec,
    held_out_arcsec: m.held_out_rmse_arcsec,
    chi2_per_dof: m.chi2_per_dof,
    shown: true,
  }];
}

/** After which rung the diagnosis stopped, where it went on to look. @param {Rung[]} list */
function stopOf(list) {
  const found = documentShown().ladder;
  const same = found && list.length > found.stop + 1 && list[found.stop + 1].label ===
      found.rungs[found.stop + 1]?.label;
  return same ? found.stop : null;
}

/** @param {Rung} r */
function nameOf(r) {
  return r.added && r.key !== "refitted" && r.key !== "unknown"
    ? `+ ${r.label.replaceAll("_", " ")}`
    : r.label.replaceAll("_", " ");
}

/** @param {Theme} t */
function build(t) {
  const whole = documentShown();
  const list = rungs();
  const stop = stopOf(list);
  const s = scale();
  const at = list.map((_, k) => k);
  const inside = list.map((r) => r.in_sample_arcsec * s);
  const outside = list.map((r) => (r.held_out_arcsec === null ? null : r.held_out_arcsec * s));
  const floor = whole.noise?.noise_floor_arcsec ? whole.noise.noise_floor_arcsec * s : null;
  const all =
    /** @type {number[]} */ ([...inside, ...outside, floor].filter((v) => v !== null && v > 0));
  const ends = [Math.log10(Math.min(...all) / 1.35), Math.log10(Math.max(...all) * 1.35)];
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
      margin: { l: 148, r: 16, t: 26, b: 44 },
      xaxis: {
        title: `error, rms (${state.unit})`,
        type: "log",
        range: ends,
        tickvals: nice(ends),
        ticktext: nice(ends).map((v) => plain(v)),
        zeroline: false,
      },
      yaxis: {
        tickvals: at,
        ticktext: names.map((n, k) => wrapped(list[k].shown ? `<b>${n}</b>` : n)),
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
        ...(stop !== null
          ? [{
            type: "line",
            xref: "paper",
            x0: 0,
            x1: 1,
            y0: stop + 0.5,
            y1: stop + 0.5,
            line: { color: t.warn, width: 2, dash: "dash" },
          }]
          : []),
      ],
      annotations: [
        ...(floor
          ? [{
            x: Math.log10(floor),
            yref: "paper",
            y: 1,
            yanchor: "bottom",
            text: `noise floor: ${whole.noise.noise_floor_of}`,
            showarrow: false,
            font: { size: 11, color: t.quiet },
          }]
          : []),
        ...(stop !== null
          ? [{
            xref: "paper",
            x: 1,
            xanchor: "right",
            y: stop + 0.5,
            yanchor: "bottom",
            text: whole.ladder?.stop_says,
            showarrow: false,
            font: { size: 11, color: t.warn },
          }]
          : []),
      ],
    },
  };
}

/** Round numbers between two ends of a logarithmic scale. @param {number[]} ends logarithms */
function nice(ends) {
  /** @type {number[]} */
  const found = [];
  for (let decade = Math.floor(ends[0]); decade <= ends[1]; decade++) {
    for (const v of [1, 2, 3, 5]) found.push(Number((v * 10 ** decade).toPrecision(1)));
  }
  return found.filter((v) => Math.log10(v) >= ends[0] && Math.log10(v) <= ends[1]);
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

function drawRows() {
  const whole = documentShown();
  byId("floor-says").textContent = !whole.noise
    ? ""
    : whole.noise.noise_floor_arcsec === null
    ? `The noise floor ${whole.noise.noise_floor_of}.`
    : `Below the noise floor (${whole.noise.noise_floor_of}) a model fits noise.`;
  const s = scale();
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
      fixed(r.in_sample_arcsec * s, 3),
      r.held_out_arcsec === null ? "–" : fixed(r.held_out_arcsec * s, 3),
      [
        text(r.chi2_per_dof),
        whole.ladder?.stop === k &&
        el("span", { class: "visually-hidden" }, " (the answer stops here)"),
      ],
    ]),
  );
  place.querySelectorAll("tbody tr").forEach((tr, k) =>
    tr.classList.toggle("shown", !!list[k].shown)
  );
  fill(
    rows,
    place,
    el(
      "p",
      { class: "small quiet" },
      whole.ladder
        ? `Errors in ${state.unit}; held out by ${whole.ladder.held_out_by}.`
        : whole.reasons.ladder,
    ),
  );
}
