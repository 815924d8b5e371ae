/** All of the page that the first plot does not wait for: its other sections, files, contents, units. */

import { isLive } from "../lib/api.js";
import { setUpAnswer } from "./answer.js";
import { setUpBar } from "./bar.js";
import { setUpCandidates } from "./candidates.js";
import { setUpChanged } from "./changed.js";
import { byId, el, fill } from "../lib/dom.js";
import { setUpDrive } from "./drive.js";
import { setUpExport } from "./export.js";
import { setUpFigures } from "./figures.js";
import { markDrawn } from "../lib/figure.js";
import { setUpJob } from "./job.js";
import { setUpLadder } from "./ladder.js";
import { setUpNext } from "./next.js";
import { setUpOwn } from "./own.js";
import { documentShown, on, state, tell, tellNewcomers } from "../lib/store.js";
import { setUpSelection } from "./selection.js";
import { setUpSheet } from "./sheet.js";
import { setUpTable } from "./table.js";
import { setUpTell } from "./tell.js";
import { openUpload, setUpUpload } from "./upload.js";
import { setUpWhere } from "./where.js";
import { setUpWhy } from "./why.js";

/** Everything but the first plot. */
export function setUpSections() {
  const unit = /** @type {HTMLSelectElement} */ (byId("unit"));
  on(["document"], () => {
    const choices = Object.keys(documentShown().units);
    fill(unit, choices.map((u) => el("option", { value: u, selected: u === state.unit }, u)));
  });
  unit.addEventListener("change", () => {
    state.unit = unit.value;
    tell("unit");
  });
  for (const part of document.querySelectorAll("[data-live]")) {
    if (part instanceof HTMLElement) part.hidden = !isLive();
  }
  // The order is that of drawing: what is looked at first comes first.
  for (
    const part of [
      setUpBar,
      setUpAnswer,
      setUpSelection,
      setUpLadder,
      setUpWhere,
      setUpCandidates,
      setUpFigures,
      setUpNext,
      setUpWhy,
      setUpChanged,
      setUpOwn,
      setUpTable,
      setUpDrive,
      setUpTell,
      setUpExport,
      setUpSheet,
      setUpUpload,
      setUpJob,
    ]
  ) part();
  followSections();
  if (state.document) tellNewcomers("document");
  else openUpload();
  markDrawn();
}

/** The entry of the contents whose section is in sight. */
function followSections() {
  const links = [...document.querySelectorAll(".contents a")];
  const seen = new Set();
  const observer = new IntersectionObserver((entries) => {
    for (const e of entries) {
      if (e.isIntersecting) seen.add(e.target.id);
      else seen.delete(e.target.id);
    }
    const first = links.find((a) => seen.has(a.getAttribute("href")?.slice(1)));
    for (const a of links) {
      if (a === first) a.setAttribute("aria-current", "true");
      else a.removeAttribute("aria-current");
    }
  }, { rootMargin: "-15% 0px -60% 0px" });
  document.querySelectorAll("main > section[aria-labelledby]").forEach((s) => observer.observe(s));
}
