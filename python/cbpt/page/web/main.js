/**
 * The page: one document, nine sections, two uses.
 *
 * A report has its document inside; the workbench asks its server for it, and for more. The first
 * plot comes first, then the other sections, then the plotting library.
 *
 *   dom, numbers, api, store     elements, texts of numbers, the server, what is shown now
 *   figure, points, sketch       how plots are drawn and saved; one that stands before its library
 *   plotly                       the library
 *   drop                         files dropped on the page, however early
 *   readings                     the first plot
 *   sections                     all that is not needed for it:
 *     models, bar                which effects are on; their switches and the error left
 *     answer ... export          the other eight sections, in the order of the page
 *     upload, job                files and the diagnosis under way, in the workbench alone
 */

/** @import { PageDocument } from "./types.d.ts" */
import { get, isLive } from "./api.js";
import { trouble } from "./dom.js";
import { listenToDrops } from "./drop.js";
import { painted } from "./figure.js";
import { plotlyAhead, plotlyReady } from "./plotly.js";
import { setUpReadings } from "./readings.js";
import { setDocument } from "./store.js";

/** Before anything else may go wrong silently. */
addEventListener(
  "error",
  (event) => trouble(`The page has met a mistake of its own: ${event.message}`),
);
addEventListener(
  "unhandledrejection",
  (event) => trouble(String(event.reason?.message ?? event.reason)),
);

async function start() {
  const inside = document.getElementById("document");
  if (isLive()) listenToDrops();
  const asked = inside ? JSON.parse(inside.textContent ?? "null") : get("document");
  setUpReadings();
  /** @type {PageDocument | null} */
  const found = await asked;
  if (found) {
    setDocument(found);
    await painted();
    // When the first plot was to be seen, since the page was asked for.
    performance.mark("cbpt-first-plot");
  }
  plotlyAhead();
  const { setUpSections } = await import("./sections.js");
  setUpSections();
  await plotlyReady().catch(() => {}); // each plot that waits for it says so
}

start().catch((error) => trouble(error.message));
