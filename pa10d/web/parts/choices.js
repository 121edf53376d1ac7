// A folded list of things to tick.
import { el, fill, refill } from "../base/dom.js";

/** items() gives [{id, label, note}]; chosen: a Set of ids, changed in place; then `changed()`. */
export function choices(label, items, chosen, changed) {
  const summary = el("summary", {}), list = el("div", { class: "choices" });
  const box = el("details", { class: "picker runs" }, summary, list);
  const sum = () => {
    const names = items().filter((one) => chosen.has(one.id)).map((one) => one.label);
    fill(summary, el("span", {}, label), el("b", {}, names.length ? names.join(", ") : "none"));
  };
  const refresh = () => {
    const all = items();
    sum();
    refill(list, all.length ? all.map(({ id, label: name, note }) => el("label", {}, el("input", {
      type: "checkbox", value: id, checked: chosen.has(id), onchange: (event) => {
        if (event.target.checked) chosen.add(id);
        else chosen.delete(id);
        sum();
        changed();
      } }), ` ${name} `, note ? el("small", {}, note) : null)) : el("p", { class: "muted" }, "There are none yet."));
  };
  box.addEventListener("keydown", (event) => { if (event.key === "Escape" && box.open) { box.open = false; summary.focus(); } });
  document.addEventListener("pointerdown", (event) => { if (!box.contains(event.target)) box.open = false; });
  refresh();
  return { box, refresh };
}
