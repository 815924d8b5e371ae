/** The case file of a model: what was read, with effects and refitted numbers of the model in it. */

/** @import { Model, PageDocument } from "../types.d.ts" */

/** None where a case file cannot hold the model. @param {PageDocument} whole @param {Model} model */
export function caseWith(whole, model) {
  return model.key === "stated" ? whole.case.text : model.case_text ?? null;
}
