// Short messages at the edge; errors stay until they are closed.
import { el } from "./dom.js";

const SHOWN = 6000; // ms

export function notice(text, { kind = "info", detail = "", action } = {}) {
  const box = el("div", { class: `notice ${kind}`, role: kind === "error" ? "alert" : "status" },
    el("p", {}, el("b", {}, text), detail ? ` ${detail}` : ""),
    action ? el("a", { class: "button", href: action.href, onclick: () => box.remove() }, action.label) : null,
    el("button", { class: "quiet", "aria-label": "close", onclick: () => box.remove() }, "×"));
  document.getElementById("notices").append(box);
  if (kind !== "error") setTimeout(() => box.remove(), SHOWN);
}

/** Tell what went wrong, with its remedy. */
export function failed(what, error) {
  notice(what, { kind: "error", detail: [error.message, error.remedy].filter(Boolean).join(" — ") });
}

/** A click handler that shows its errors and cannot be started twice. */
export function guarded(what, work) {
  return async (event) => {
    const button = event?.currentTarget;
    if (button?.dataset.busy) return;
    if (button) button.dataset.busy = "yes";
    try {
      await work(event);
    } catch (error) {
      failed(what, error);
    } finally {
      if (button) delete button.dataset.busy;
    }
  };
}
