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

/** Resolved when `Plotly` is there; after a failure the next call asks for it again. */
export function plotlyReady() {
  loading ??= load().catch((error) => {
    loading = undefined;
    throw error;
  });
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
    document.head.append(script);
  } else {
    script.src = SOURCE;
    await new Promise((done) => {
      script.onload = script.onerror = done;
      document.head.append(script);
    });
  }
  // What blocks scripts may also leave an empty one.
  if (!globalThis.Plotly) {
    script.remove();
    throw new Error("The plotting library did not load.");
  }
  packed?.remove();
}
