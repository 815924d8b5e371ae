/** Files: a case and a table dropped on the page, and what the columns mean where names leave doubt. */

import { get, handOver, isLive, post, upload } from "../lib/api.js";
import { announce, byId, el, fill, table } from "../lib/dom.js";
import { onDrop } from "../lib/drop.js";
import { setDocument } from "../lib/store.js";

export function setUpUpload() {
  if (!isLive()) return;
  byId("open-files").addEventListener("click", openUpload);
  // Files that were refused or left in doubt must not be read with the next ones.
  box().addEventListener("close", () => post("forget", {}).catch(() => {}));
  addEventListener("dragover", () => {
    document.body.classList.add("over");
    openUpload();
  });
  addEventListener(
    "dragleave",
    (event) => !event.relatedTarget && document.body.classList.remove("over"),
  );
  onDrop((files) => {
    document.body.classList.remove("over");
    take(files);
  });
}

/** @returns {HTMLDialogElement} */
function box() {
  return /** @type {HTMLDialogElement} */ (byId("upload"));
}

/** Ask for files. */
export function openUpload() {
  const dialog = box();
  if (dialog.open) return;
  const chooser = el("input", {
    type: "file",
    multiple: true,
    id: "files",
    class: "visually-hidden",
    onchange: (e) => take([...e.target.files]),
  });
  fill(
    dialog,
    el(
      "div",
      { class: "row between" },
      el("h2", {}, "Case and readings"),
      el(
        "button",
        { type: "button", onclick: () => dialog.close(), "aria-label": "Close" },
        "Close",
      ),
    ),
    el(
      "div",
      { class: "drop stack" },
      el("p", {}, "Drop a case file (TOML) and a table of readings here"),
      el(
        "p",
        { class: "small" },
        "CSV, xlsx, xls, ods, MATLAB, TDMS or Parquet; they stay on this machine.",
      ),
      el("label", { class: "button", for: "files" }, "Choose files"),
      chooser,
    ),
    el("div", { id: "upload-found", class: "stack", "aria-live": "polite" }),
  );
  dialog.showModal();
}

/** @param {File[]} files */
async function take(files) {
  if (!files.length) return;
  openUpload();
  const place = byId("upload-found");
  fill(place, el("p", { class: "quiet" }, `Reading ${files.map((f) => f.name).join(", ")} …`));
  // The case first: a table is read with what its drive needs.
  const order = files.sort((a, b) =>
    Number(b.name.endsWith(".toml")) - Number(a.name.endsWith(".toml"))
  );
  try {
    await handOver(async () => {
      /** @type {any} */
      let found = null;
      for (const file of order) found = await upload(file, file !== order.at(-1));
      await told(found);
    });
  } catch (error) {
    fill(
      place,
      el(
        "p",
        { class: "trouble", role: "alert" },
        error instanceof Error ? error.message : String(error),
      ),
    );
  }
}

/** What the server made of the files: ready, something missing, or columns in doubt. @param {any} found */
async function told(found) {
  const place = byId("upload-found");
  if (found.ready) {
    box().close();
    setDocument(await get("document"));
    announce("Files read.");
    return;
  }
  fill(
    place,
    found.message && messages(found.message),
    found.sheets?.length > 1 && sheets(found),
    found.doubt && !found.which_sheet && found.columns?.length > 0 && mapping(found),
  );
}

/** Ask the server to read the table so. @param {unknown} how {columns, sheet} */
async function readSo(how) {
  try {
    await handOver(async () => told(await post("columns", how)));
  } catch (error) {
    byId("upload-found").append(
      el(
        "p",
        { class: "trouble", role: "alert" },
        error instanceof Error ? error.message : String(error),
      ),
    );
  }
}

/** Which sheet of a workbook. @param {any} found */
function sheets(found) {
  return el(
    "label",
    { class: "inline" },
    "Sheet",
    el(
      "select",
      { id: "sheet", onchange: (e) => e.target.value && readSo({ sheet: e.target.value }) },
      !found.sheet && el("option", { value: "" }, "choose ..."),
      found.sheets.map((/** @type {string} */ name) =>
        el("option", { value: name, selected: name === found.sheet }, name)
      ),
    ),
  );
}

/** What has to be told, a line each. @param {string} text */
function messages(text) {
  const lines = text.split("\n").filter((line) => line.trim());
  return lines.length === 1
    ? el("p", {}, lines[0])
    : el("ul", { class: "plain small" }, lines.map((line) => el("li", {}, line)));
}

/** A row a column: what it is taken for, and what else it may be. @param {any} found */
function mapping(found) {
  /** @type {Record<string, string>} */
  const chosen = {};
  for (const c of found.columns) if (c.stated) chosen[c.header] = c.stated;
  const every = found.quantities.flatMap((/** @type {any} */ q) =>
    q.units.length ? q.units.map((/** @type {string} */ u) => `${q.key} [${u}]`) : [q.column]
  );
  return el(
    "div",
    { class: "stack", id: "mapping" },
    el("h3", {}, "What the columns mean"),
    table(
      `Columns of ${found.name}`,
      ["column", "first values", "read as"],
      found.columns.map((/** @type {any} */ c) => [
        [
          el("b", {}, c.header),
          c.doubt && el("div", { class: "small" }, [c.expected, c.hint].filter(Boolean).join("; ")),
        ],
        el("span", { class: "mono small" }, c.sample.join(", ")),
        el(
          "select",
          {
            "aria-label": `Meaning of ${c.header}`,
            "data-header": c.header,
            onchange: (e) => {
              if (e.target.value) chosen[c.header] = e.target.value;
              else delete chosen[c.header];
            },
          },
          el("option", { value: "" }, c.column ?? (c.doubt ? "choose ..." : "not used")),
          [...new Set(["extra", ...c.candidates, ...every])].map((name) =>
            el(
              "option",
              { value: name, selected: name === c.stated },
              name === "extra" ? "not used" : name,
            )
          ),
        ),
      ]),
    ),
    el(
      "button",
      {
        type: "button",
        class: "main",
        id: "confirm-columns",
        onclick: () => readSo({ columns: chosen, sheet: found.sheet }),
      },
      "Use these meanings",
    ),
  );
}
