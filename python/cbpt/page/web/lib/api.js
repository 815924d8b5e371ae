/**
 * The server of the workbench; a report has none and asks for nothing.
 *
 *   isLive         whether there is a server
 *   get, post      ask it; most routes are about the files shown, and the answer is of these or none
 *   upload         hand it a file
 *   compareWith    hand it a second table, to be told what changed
 *   handOver       what may open other files: meanwhile nothing is asked about those shown
 *   Superseded     thrown where other files have taken the place of those that were asked about
 */

/** @import { ChangeSection } from "../types.d.ts" */

/** Whether a server stands behind the page. */
export function isLive() {
  return document.documentElement.dataset.mode !== "report";
}

/** Which of its files the page shows. */
let shown = 0;

/** Other files are shown. @param {number} opened their number */
export function showsFiles(opened) {
  shown = opened;
}

/** Routes that are about no files, or about others than those shown. */
const FREE = /^(document|upload|columns|forget)\b/;

/** The files that were asked about are shown no more; nobody waits for the answer. */
export class Superseded extends Error {
  constructor() {
    super("Other files have been opened meanwhile.");
  }
}

/** The last thing that may open other files: settled once the page shows what came of it. */
let settled = Promise.resolve();
/** What has been asked about the files shown and is not answered yet. @type {Set<AbortController>} */
const underWay = new Set();

/**
 * Do something that may open other files, up to the point where the page shows them. The server may
 * have them before the page knows, and would refuse what is asked about the former ones. So what is
 * under way is taken back, and what is asked meanwhile waits; both are asked (again) if the files
 * have stayed, and are `Superseded` if not.
 * @template T
 * @param {() => Promise<T>} act
 * @returns {Promise<T>}
 */
export function handOver(act) {
  for (const request of underWay) request.abort();
  const done = settled.then(act);
  settled = done.then(() => {}, () => {});
  return done;
}

/** Wait until nothing is handed over. */
async function standing() {
  let last;
  do await (last = settled); while (last !== settled);
}

/**
 * Where a route is, with the key of the workbench that has sent this page and the number of its
 * files: another may listen at the same address, and have other files.
 * @param {string} route
 */
function at(route) {
  const sent = document.getElementById("document-address")?.getAttribute("href")?.split("?")[1];
  const files = FREE.test(route) ? "" : `&opened=${shown}`;
  return `api/${route}${route.includes("?") ? "&" : "?"}${sent}${files}`;
}

/** @param {Response} answer */
async function read(answer) {
  const type = answer.headers.get("content-type") ?? "";
  if (!type.includes("application/json")) {
    throw new Error(`The server answered ${answer.status} ${answer.statusText}.`);
  }
  const found = await answer.json();
  if (!answer.ok) throw new Error(found.error ?? `The server answered ${answer.status}.`);
  return found;
}

/** @param {string} route @param {RequestInit} [how] */
async function reached(route, how) {
  try {
    return await fetch(at(route), how);
  } catch (error) {
    if (how?.signal?.aborted) throw error;
    throw new Error("The workbench does not answer; is `cbpt workbench` still running?");
  }
}

/** @param {string} route @param {RequestInit} [how] @returns {Promise<any>} */
function asked(route, how) {
  return FREE.test(route) ? reached(route, how).then(read) : ofShown(route, how);
}

/**
 * An answer about the files shown when it was asked for, and still.
 * @param {string} route @param {RequestInit} [how]
 */
async function ofShown(route, how) {
  const of = shown;
  for (;;) {
    await standing();
    if (shown !== of) throw new Superseded();
    const request = new AbortController();
    underWay.add(request);
    try {
      const answer = await reached(route, { ...how, signal: request.signal });
      const found = await read(answer);
      if (Number(answer.headers.get("x-cbpt-opened")) !== of) throw new Superseded();
      return found;
    } catch (error) {
      if (!request.signal.aborted) throw error;
    } finally {
      underWay.delete(request);
    }
  }
}

/** @param {string} route */
export function get(route) {
  return asked(route);
}

/** @param {string} route @param {unknown} content */
export function post(route, content) {
  return asked(route, {
    method: "POST",
    headers: { "content-type": "application/json" },
    body: JSON.stringify(content),
  });
}

/** What changes which readings are shown, inside `handOver`. @param {string} route @param {unknown} content */
export function tellAtOnce(route, content) {
  return reached(route, {
    method: "POST",
    headers: { "content-type": "application/json" },
    body: JSON.stringify(content),
  }).then(read);
}

/** A file by its name and bytes. @param {File} file @param {boolean} more whether another follows */
export function upload(file, more) {
  return asked(`upload?name=${encodeURIComponent(file.name)}${more ? "&more=1" : ""}`, bytes(file));
}

/** A second table by its name and bytes. @param {File} file @returns {Promise<ChangeSection>} */
export function compareWith(file) {
  return asked(`change?name=${encodeURIComponent(file.name)}`, bytes(file));
}

/** @param {File} file @returns {RequestInit} */
function bytes(file) {
  return {
    method: "POST",
    headers: { "content-type": "application/octet-stream" },
    body: file,
  };
}
