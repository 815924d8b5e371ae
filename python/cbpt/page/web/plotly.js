/**
 * The plotting library: beside the page in the workbench, compressed inside it in a report.
 *
 * Reading it takes longest of all, so it is asked for once the first plot has been sketched.
 */

const SOURCE = "plotly.min.js";

/** @type {Promise<void> | undefined} */
let loading;

/** Begin to fetch the library, and nothing more, while other things are read. */
export function plotlyAhead() {
  if (document.getElementById("plotly")) return;
  const link = document.createElement("link");
  Object.assign(link, { rel: "preload", as: "script", href: SOURCE });
  document.head.append(link);
}

/** Resolved when `Plotly` is there. */
export function plotlyReady() {
  loading ??= load();
  return loading;
}

async function load() {
  if (globalThis.Plotly) return;
  const packed = document.getElementById("plotly");
  const script = document.createElement("script");
  if (packed) {
    const text = atob(packed.textContent ?? "");
    const bytes = new Uint8Array(text.length);
    for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    script.textContent = await new Response(stream).text();
    packed.remove();
    document.head.append(script);
    return;
  }
  script.src = SOURCE;
  await new Promise((done, failed) => {
    script.onload = () => done(undefined);
    script.onerror = () => failed(new Error("The plotting library did not load."));
    document.head.append(script);
  });
}
