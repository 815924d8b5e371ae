/**
 * The page: one document, fifteen sections, two uses: the answer first, then all that it rests on.
 *
 * A report has its document inside; the workbench asks its server for it, and for more. The first
 * plot comes first, then the other sections, then the plotting library.
 *
 *   lib/        what sections share
 *     dom, numbers, api, store   elements, numbers as text, the server, what is shown now
 *     figure, points, sketch     how plots are drawn and saved; one that stands before its library
 *     limits                     how far axes reach
 *     drawing                    the drive to scale
 *     plotly                     the library
 *     models, casefile           which effects are on; the case file with them
 *     drop                       files dropped on the page, however early
 *   sections/   what is seen
 *     readings                   the first plot
 *     all                        everything that the first plot does not wait for:
 *       bar                      the switches of effects and the error left
 *       answer ... export        the other sections, in the order of the page
 *       sheet                    the data sheet, in the workbench alone
 *       upload, job              files and the diagnosis under way, in the workbench alone
 */

/** @import { PageDocument } from "./types.d.ts" */
import { get, isLive } from "./lib/api.js";
import { trouble } from "./lib/dom.js";
import { listenToDrops } from "./lib/drop.js";
import { painted } from "./lib/figure.js";
import { plotlyAhead, plotlyReady } from "./lib/plotly.js";
import { setUpReadings } from "./sections/readings.js";
import { setDocument } from "./lib/store.js";

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
  const { setUpSections } = await import("./sections/all.js");
  setUpSections();
  await plotlyReady().catch(() => {}); // each plot that waits for it says so
}

start().catch((error) => trouble(error.message));
