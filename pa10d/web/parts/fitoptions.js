// How a model is fitted, where the usual way is not wanted: cut-off, terms, samples.
import { el } from "../base/dom.js";

const TERMS = [
  ["torque_offset", "a constant offset of each torque sensor"],
  ["stribeck", "Stribeck friction in every joint"],
  ["coulomb_asymmetry", "Coulomb friction that differs by direction"],
];

/** {box, read()}: read() gives what differs from the usual, as ``POST models`` takes it. */
export function fitOptions() {
  const cutoff = el("input", { id: "fit-cutoff", type: "number", min: 0.1, step: "any", placeholder: "from the data", size: 8 });
  const terms = TERMS.map(([id, says]) => ({ id, says, input: el("input", { type: "checkbox", id: `fit-${id}` }) }));
  const robust = el("input", { type: "checkbox", id: "fit-robust" });
  const faster = el("input", { id: "fit-faster", spellcheck: "false", placeholder: "all samples" });
  const check = (input, says) => el("label", { htmlFor: input.id }, input, ` ${says}`);
  return {
    box: el("details", { class: "grow options" }, el("summary", {}, "Options"), el("div", { class: "fields" },
      el("div", { class: "field" }, el("label", { htmlFor: cutoff.id }, "cut-off"), cutoff, el("small", {}, "Hz, of the zero-phase low-pass on both sides")),
      el("div", { class: "field" }, el("span", { class: "label" }, "further terms"), terms.map((one) => check(one.input, one.says)), el("small", {}, "better asked for by a diagnosis")),
      el("div", { class: "field" }, el("span", { class: "label" }, "knocks and glitches"), check(robust, "let samples far off count less")),
      el("div", { class: "field" }, el("label", { htmlFor: faster.id }, "only faster than"), faster, el("small", {}, "rad/s, one number or one per joint: where friction is a straight line")))),
    read() {
      const named = terms.filter((one) => one.input.checked).map((one) => one.id);
      const speeds = faster.value.split(/[\s,;]+/).filter(Boolean).map((word) => {
        const value = Number(word);
        if (!Number.isFinite(value) || value < 0) throw new Error(`only faster than: '${word}' is no speed.`);
        return value;
      });
      return {
        ...(cutoff.value ? { cutoff: Number(cutoff.value) } : {}), ...(named.length ? { with_effects: named } : {}),
        ...(robust.checked ? { robust: true } : {}), ...(speeds.length ? { faster_than: speeds } : {}),
      };
    },
  };
}
