/**
 * The plotting library: beside the page in the workbench, compressed inside it in a report.
 *
 * The workbench runs this module before the others are there: reading the library takes longest.
 */

/** @type {Promise<void> | undefined} */
let loading;

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
  script.src = "plotly.min.js";
  await new Promise((done, failed) => {
    script.onload = () => done(undefined);
    script.onerror = () => failed(new Error("The plotting library did not load."));
    document.head.append(script);
  });
}

plotlyReady().catch(() => {}); // told where it is waited for
