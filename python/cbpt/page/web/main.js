/**
 * The page: one document, nine sections, two uses.
 *
 * A report has its document inside; the workbench asks its server for it, and for more.
 *
 *   dom, numbers, api, store     elements, texts of numbers, the server, what is shown now
 *   figure, points               how plots are drawn and saved
 *   models, bar                  which effects are on; their switches and the error left
 *   answer ... export            the nine sections, in the order of the page
 *   upload, job                  files and the diagnosis under way, in the workbench alone
 */

/** @import { PageDocument } from "./types.d.ts" */
import { get, isLive } from "./api.js";
import { setUpAnswer } from "./answer.js";
import { setUpBar } from "./bar.js";
import { setUpCandidates } from "./candidates.js";
import { byId, el, fill, trouble } from "./dom.js";
import { markDrawn } from "./figure.js";
import { setUpDrive } from "./drive.js";
import { setUpExport } from "./export.js";
import { setUpJob } from "./job.js";
import { setUpLadder } from "./ladder.js";
import { setUpNext } from "./next.js";
import { ANGLE_UNITS } from "./numbers.js";
import { setUpOwn } from "./own.js";
import { plotlyReady } from "./plotly.js";
import { setUpReadings } from "./readings.js";
import { setDocument, state, tell } from "./store.js";
import { openUpload, setUpUpload } from "./upload.js";
import { setUpWhere } from "./where.js";

/** Before anything else may go wrong silently. */
addEventListener(
  "error",
  (event) => trouble(`The page has met a mistake of its own: ${event.message}`),
);
addEventListener(
  "unhandledrejection",
  (event) => trouble(String(event.reason?.message ?? event.reason)),
);

function setUp() {
  const unit = /** @type {HTMLSelectElement} */ (byId("unit"));
  fill(unit, Object.keys(ANGLE_UNITS).map((u) => el("option", { value: u }, u)));
  unit.addEventListener("change", () => {
    state.unit = /** @type {keyof typeof ANGLE_UNITS} */ (unit.value);
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
      setUpReadings,
      setUpLadder,
      setUpWhere,
      setUpCandidates,
      setUpOwn,
      setUpNext,
      setUpDrive,
      setUpExport,
      setUpUpload,
      setUpJob,
    ]
  ) part();
  followSections();
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

async function start() {
  const inside = document.getElementById("document");
  const asked = inside ? JSON.parse(inside.textContent ?? "null") : get("document");
  setUp();
  /** @type {PageDocument | null} */
  const found = await asked;
  if (!found) return openUpload();
  await plotlyReady();
  setDocument(found);
  markDrawn();
}

start().catch((error) => trouble(error.message));
