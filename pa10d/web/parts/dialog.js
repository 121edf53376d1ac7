// Questions in the page. They never cover the stop button, as the browser's own dialogues would.
import { el } from "../base/dom.js";

/** Show a form in front of everything but the stop button; `done()` takes it away. */
export function dialog(title, ...content) {
  const before = document.activeElement, behind = ["header", "content", "jobs"].map((id) => document.getElementById(id));
  const heading = el("h2", { id: "dialog-title" }, title);
  const box = el("div", { class: "dialog", role: "dialog", "aria-modal": "true", "aria-labelledby": heading.id }, heading, content);
  const veil = el("div", { class: "veil" }, box);
  for (const one of behind) one.inert = true;
  document.body.append(veil);
  (box.querySelector("input, .primary") ?? box.querySelector("button"))?.focus();
  return {
    box,
    done() {
      veil.remove();
      for (const one of behind) one.inert = false;
      if (before?.isConnected) before.focus();
    },
  };
}

/** True where the question is answered with `label`. Esc is no. */
export function ask(title, text, label, { danger = false } = {}) {
  return new Promise((answered) => {
    const end = (answer) => { open.done(); answered(answer); };
    const yes = el("button", { type: "button", class: danger ? "danger" : "primary", onclick: () => end(true) }, label);
    const no = el("button", { type: "button", onclick: () => end(false) }, "Leave it");
    const open = dialog(title, el("p", {}, text), el("div", { class: "row" }, yes, no));
    no.focus();
    open.box.addEventListener("keydown", (event) => { if (event.key === "Escape") end(false); });
  });
}
