/** What the page's modules share besides the document. */

/** What an element may hold. */
export type Child = string | number | Node | null | undefined | false | Child[];

declare global {
  /** The part of plotly.js that the page uses. */
  // deno-lint-ignore no-explicit-any
  var Plotly: any;
}
