// How a model is fitted, where the usual way is not wanted: cut-off, terms, samples, stretches, what
// is known of the bodies.
import { el } from "../base/dom.js";
import { get } from "../base/api.js";
import { failed } from "../base/notices.js";
import { choices } from "./choices.js";
import { stretches } from "./stretches.js";

/** {box, read(), refresh()}: read() gives what differs from the usual, as ``POST models`` takes it;
    refresh() is for when others are chosen with `runs`, the picker of those that are fitted to. */
export function fitOptions(runs) {
  const cutoff = el("input", { id: "fit-cutoff", type: "number", min: 0.1, step: "any", placeholder: "from the data", size: 8 });
  const prior = el("input", { id: "fit-prior", type: "number", min: 0.1, max: 1000, step: "any", placeholder: "nothing is known", size: 8 });
  const given = el("textarea", { id: "fit-given", rows: 2, spellcheck: "false", placeholder: "Fc3 = 12 ± 2" });
  const robust = el("input", { type: "checkbox", id: "fit-robust" });
  const faster = el("input", { id: "fit-faster", spellcheck: "false", placeholder: "all samples" });
  const named = new Set(), out = stretches(runs);
  let effects = [];
  const known = () => given.value.split(/[\n;]+/).map((line) => line.trim()).filter(Boolean);
  const terms = choices("Further terms", () => effects, named, () => {});
  const field = (label, says, ...inside) => el("div", { class: "field" }, el("label", { htmlFor: inside[0].id }, label), inside, el("small", {}, says));
  const box = el("details", { class: "grow options" }, el("summary", {}, "Options"), el("div", { class: "fields" },
    field("cut-off", "Hz, of the zero-phase low-pass on both sides", cutoff),
    el("div", { class: "field" }, terms.box, el("small", {}, "on every joint; better asked for by a diagnosis")),
    field("bodies as in the URDF within", "% of what is usual for a link, one standard deviation: decides what the motion leaves open", prior),
    field("parameters you know", "one a line, SI: a name of the table of parameters (Fc3 for coulomb J3: Fc) or a link's own figure (link J7: m), its value ± one standard deviation; +- will do", given),
    el("div", { class: "field" }, el("span", { class: "label" }, "knocks and glitches"), el("span", { class: "row tied" }, robust, el("label", { htmlFor: robust.id }, "let samples far off count less"))),
    field("only faster than", "rad/s, one number or one per joint: where friction is a straight line", faster), out.box));
  box.addEventListener("toggle", () => {
    if (!box.open || effects.length) return;
    get("effects").then(({ items }) => {
      effects = items.filter((one) => one.scope !== "pair" && !["textbook", "chosen"].includes(one.question)).map((one) => ({ id: one.id, label: one.title, note: one.equation }));
      terms.refresh();
    }).catch((error) => failed("The effects cannot be listed.", error));
  });
  return {
    box, refresh: out.refresh,
    read() {
      const speeds = faster.value.split(/[\s,;]+/).filter(Boolean).map((word) => {
        const value = Number(word);
        if (!Number.isFinite(value) || value < 0) throw new Error(`only faster than: '${word}' is no speed.`);
        return value;
      });
      return {
        ...(cutoff.value ? { cutoff: Number(cutoff.value) } : {}), ...(named.size ? { with_effects: [...named] } : {}),
        ...(prior.value ? { prior: Number(prior.value) } : {}), ...(known().length ? { given: known() } : {}), ...(robust.checked ? { robust: true } : {}),
        ...(speeds.length ? { faster_than: speeds } : {}), ...(out.read().length ? { left_out: out.read() } : {}),
      };
    },
  };
}
