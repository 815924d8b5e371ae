/** The case file of a model: what was read, with the effects of the model in it. */

/** @import { Model, PageDocument } from "./types.d.ts" */

/** @param {PageDocument} whole @param {Model} model */
export function caseWith(whole, model) {
  return model.case_text ?? whole.case.text;
}
