// What lies in the data folder and cannot be read: where, and why. A line that can be closed.
import { el, fill } from "../base/dom.js";
import { state, watch } from "../base/store.js";

/** Below the list of `what`: "runs", "models" or "investigations". */
export function setAside(what) {
  const box = el("details", { class: "aside", hidden: true, dataset: { aside: what } });
  let shown = "";
  const closed = () => sessionStorage.getItem(`pa10d-aside-${what}`) === shown;
  watch(["aside"], () => {
    const found = state.aside[what] ?? [], now = JSON.stringify(found);
    if (now === shown) return;
    shown = now;
    box.hidden = !found.length || closed();
    const close = el("button", { type: "button", class: "quiet small", "aria-label": "Close this until something changes", onclick: (event) => {
      event.preventDefault(); // it stands in the summary, which would open
      sessionStorage.setItem(`pa10d-aside-${what}`, shown);
      box.hidden = true;
    } }, "×");
    const count = found.length === 1 ? `One of the ${what} cannot be read and is set aside` : `${found.length} of the ${what} cannot be read and are set aside`;
    fill(box, el("summary", {}, count, close),
      el("dl", {}, found.map((one) => [el("dt", {}, el("code", {}, one.place), one.name && one.name !== one.id ? ` (${one.name})` : ""), el("dd", {}, one.reason)])),
      el("p", {}, "The places are those in the data folder. Nothing there was touched: mend or take away what lies there, and reload this page."));
  });
  return box;
}
