/** The server of the workbench; a report has none and asks for nothing. */

/** Whether a server stands behind the page. */
export function isLive() {
  return document.documentElement.dataset.mode !== "report";
}

/**
 * Where a route is, with the key of the workbench that has sent this page: the next one may listen
 * at the same address.
 * @param {string} route
 */
function at(route) {
  const sent = document.getElementById("document-address")?.getAttribute("href")?.split("?")[1];
  return `api/${route}${route.includes("?") ? "&" : "?"}${sent}`;
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

/** @param {string} route */
export async function get(route) {
  return read(await reached(fetch(at(route))));
}

/** @param {string} route @param {unknown} content */
export async function post(route, content) {
  return read(
    await reached(fetch(at(route), {
      method: "POST",
      headers: { "content-type": "application/json" },
      body: JSON.stringify(content),
    })),
  );
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
