// Short messages at the edge, never over the stop button; errors stay until they are closed.
import { el } from "./dom.js";

const SHOWN = 6000, MOST = 3; // ms, messages that are seen at once
const region = () => document.getElementById("notices");
let before = null; // who had the keyboard's focus before it came to a message
document.addEventListener("focusin", ({ target }) => { if (!region()?.contains(target)) before = target; });

/** Closing goes on to the next message to close, and after the last one back to where one was. */
function close(boxes) {
  const had = boxes.some((box) => box.contains(document.activeElement)) || region().querySelector(".more")?.contains(document.activeElement);
  for (const box of boxes) box.remove();
  tidy();
  if (had) ([...region().querySelectorAll(".notice:not([hidden]) > button:last-child")].at(-1) ?? (before?.isConnected ? before : document.querySelector("main")))?.focus();
}

/** `known`: sentences that are told behind one line; such a message stays until it is closed. */
export function notice(text, { kind = "info", detail = "", action, known = [] } = {}) {
  const same = [...region().children].find((one) => one.dataset.said === text + detail);
  same?.remove();
  const times = Number(same?.dataset.times ?? 0) + 1;
  const gone = () => close([box]);
  const box = el("div", { class: `notice ${kind}`, role: kind === "error" ? "alert" : "status", dataset: { said: text + detail, times } },
    el("p", {}, el("b", {}, text), detail ? ` ${detail}` : "", times > 1 ? el("small", {}, ` (${times} times)`) : null, toKnow(known)),
    action ? el(action.href ? "a" : "button", { class: "button", type: action.href ? null : "button", href: action.href, onclick: () => { gone(); action.do?.(); } }, action.label) : null,
    el("button", { class: "quiet", type: "button", "aria-label": "Close this message", onclick: gone }, "×"));
  region().append(box);
  tidy();
  if (kind !== "error" && !action?.do && !known.length) setTimeout(gone, SHOWN);
}

/** Sentences that belong to something, behind the number of them. */
export const toKnow = (sentences) => sentences.length
  ? el("details", { class: "to-know" }, el("summary", {}, `${sentences.length} thing${sentences.length > 1 ? "s" : ""} to know of it`), el("ul", {}, sentences.map((one) => el("li", {}, `${one[0].toUpperCase()}${one.slice(1)}.`))))
  : null;

/** The newest few; the others wait behind one line. */
function tidy() {
  region().querySelector(".more")?.remove();
  const all = [...region().querySelectorAll(".notice")];
  all.forEach((one, k) => { one.hidden = k < all.length - MOST; });
  if (all.length > 1) {
    const older = Math.max(0, all.length - MOST);
    region().prepend(el("div", { class: "more row" }, older ? el("span", {}, `${older} older message${older > 1 ? "s" : ""}`) : null,
      el("button", { type: "button", class: "small", onclick: () => close([...region().querySelectorAll(".notice")]) }, "Close all")));
  }
}

/** Tell what went wrong, with its remedy; what somebody wished to end did not go wrong. */
export function failed(what, error) {
  if (error.wished) return notice(error.message);
  const remedy = error.message.includes(error.remedy) ? "" : error.remedy;
  notice(what, { kind: "error", detail: [error.message, remedy].filter(Boolean).join(" — ") });
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
