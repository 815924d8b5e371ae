/** 4. What to measure next: the run in the words of a rig, what it tells apart, how many it takes. */

import { bodyOf, el, fill } from "../lib/dom.js";
import { asSentence, inPrint, nameOf } from "../lib/names.js";
import { documentShown, on } from "../lib/store.js";

/** Log odds from which a run decides, 20 : 1. */
const DECIDES = Math.log(20);

export function setUpNext() {
  on(["document"], draw);
}

function draw() {
  const whole = documentShown();
  const r = whole.next_run;
  const title = !r && whole.answer?.unknown
    ? "Where to measure more"
    : !r
    ? "No further run is suggested"
    : r.largest_gain < DECIDES || whole.undecided
    ? "The run that tells most"
    : "The run that decides";
  fill(
    bodyOf("next"),
    el(
      "div",
      { class: "card" },
      el("h3", {}, title),
      r
        ? [
          el("p", { class: "sentence" }, asSentence(inPrint(r.in_words))),
          el("p", { class: "quiet" }, brings(r)),
        ]
        : el(
          "p",
          { class: "quiet" },
          asSentence(whole.reasons.next_run ?? "the readings have not been diagnosed yet"),
        ),
    ),
  );
}

/** What the run tells, how often it has to be made, and what no run tells. @param {any} r */
function brings(r) {
  const whole = documentShown();
  const others = r.separates.filter((/** @type {string} */ n) => n !== r.most_probable);
  // A combination with an effect without a name predicts nothing: the best of the others stands for it.
  const best = whole.combinations[0]?.key === null
    ? `the combination with ${named(r.most_probable)}`
    : "the most probable combination";
  const apart = others.length < r.separates.length
    ? `${best} from ${thoseWith(others)}`
    : `these explanations apart: ${others.map(named).join("; ")}`;
  const beside = whole.answer?.verdict.rivals.length || whole.undecided
    ? ""
    : " It is not needed for the answer above, but for what may be at work beside it.";
  const rest = r.untold.length
    ? ` No run within reach tells ${best} from ${
      thoseWith(r.untold)
    }; other knowledge, such as a drawing or a calibration, can.`
    : "";
  if (r.largest_gain >= DECIDES) {
    return `One such run is expected to tell ${apart}.${beside}${rest}`;
  }
  return r.runs
    ? `No single run decides; about ${r.runs} runs like this tell ${apart}.${beside}${rest}`
    : "No run like the previous ones decides; other knowledge, such as a drawing, can.";
}

/** Combinations by what they have beside the others. @param {string[]} names */
function thoseWith(names) {
  return `${names.length > 1 ? "those" : "that"} with ${names.map(named).join("; ")}`;
}

/** @param {string} name */
function named(name) {
  return name === "nothing" ? "no effect" : nameOf(name);
}
