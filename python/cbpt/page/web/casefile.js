/** The case file with the effects of a model: what it had, and a table for each effect it has not. */

/** @import { Model, PageDocument } from "./types.d.ts" */

/**
 * @param {PageDocument} whole
 * @param {Model & { case_text?: string }} model
 */
export function caseWith(whole, model) {
  if (model.case_text) return model.case_text;
  let text = whole.case.text.endsWith("\n") ? whole.case.text : `${whole.case.text}\n`;
  for (const effect of model.effects) {
    if (new RegExp(`^\\s*id\\s*=\\s*"${effect}"`, "m").test(text)) continue;
    const own = whole.own.draft?.id === effect ? whole.own.draft : null;
    text += `\n[[effect]]\nid = ${JSON.stringify(effect)}\n`;
    if (own) {
      text += `port = ${JSON.stringify(own.port)}\nexpression = ${
        JSON.stringify(own.expression)
      }\n`;
    }
    for (const p of /** @type {any[]} */ (model.parameters)) {
      if (p.effect === effect && !own) {
        text += `${p.name_SI ?? p.name} = ${Number(p.value_SI ?? p.value)}\n`;
      }
    }
  }
  return text;
}
