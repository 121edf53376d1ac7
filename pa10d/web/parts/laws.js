// Control laws as a choice: PID, or one of those that need a model.
import { el } from "../base/dom.js";

const WORDS = { computed_torque: "computed torque", feed_forward: "feed-forward" };

/** Every law with each of these models, as options of a select. */
export const lawsWith = (models) => models.flatMap((model) =>
  Object.keys(WORDS).map((law) => el("option", { value: valueOf(law, model) }, lawInWords(law, model))));

/** The value that stands for a law in such a select. */
export const valueOf = (law, model) => law === "pid" ? "pid" : `${law}:${model}`;

/** What the chosen value asks for, as a request has it; nothing where nothing is chosen. */
export function lawOf(value) {
  const [law, ...rest] = value.split(":");
  return !law ? {} : law === "pid" ? { controller: law } : { controller: law, model: rest.join(":") };
}

export const lawInWords = (law, model) => law === "pid" ? "PID" : `${WORDS[law]} with ${model}`;
