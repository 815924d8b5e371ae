/** The server of the workbench; a report has none and asks for nothing. */

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
const FREE = /^(document|job|upload|columns|forget)\b/;

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

/** @param {Promise<Response>} asked */
async function reached(asked) {
  try {
    return await asked;
  } catch {
    throw new Error("The workbench does not answer; is `cbpt workbench` still running?");
  }
}

/**
 * An answer about the files shown when it was asked for, and still.
 * @param {string} route @param {RequestInit} [how]
 */
async function asked(route, how) {
  const of = shown;
  const answer = await reached(fetch(at(route), how));
  const found = await read(answer);
  const files = Number(answer.headers.get("x-cbpt-opened"));
  if (!FREE.test(route) && (files !== of || shown !== of)) {
    throw new Error("Other files have been opened meanwhile.");
  }
  return found;
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

/** A file by its name and bytes. @param {File} file @param {boolean} more whether another follows */
export async function upload(file, more) {
  return read(
    await reached(
      fetch(at(`upload?name=${encodeURIComponent(file.name)}${more ? "&more=1" : ""}`), {
        method: "POST",
        headers: { "content-type": "application/octet-stream" },
        body: file,
      }),
    ),
  );
}
