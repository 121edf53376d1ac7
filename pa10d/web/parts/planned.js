// A motion before anything moves: the arm as it stands, the planned one as a ghost, and what is
// left to every limit.
import { el } from "../base/dom.js";
import { state } from "../base/store.js";
import { fixed } from "../base/units.js";
import { armView, unitOf } from "./arm.js";

const TIGHT = 0.05, CLOSE = 0.05, FULL = 0.95; // rad (m), m, share: worth a second look
const FRAME = 50; // ms

/** found: what a pre-check gave, with `margins` and `preview`. */
export function planned({ margins, preview }) {
  const play = el("button", { type: "button", class: "small" }, "▶ Play the plan");
  const slider = el("input", { type: "range", min: 0, max: preview.seconds, step: "any", value: 0, class: "grow", "aria-label": "time in the planned motion, s" });
  const view = armView("The plan, before anything moves", el("div", { class: "row player" }, play, slider));
  let timer = null;
  const at = (seconds) => {
    const { dt, poses, begins, ends } = preview, last = poses.length - 1;
    const place = Math.min(seconds / dt, last), below = Math.floor(place), share = place - below, above = Math.min(below + 1, last);
    slider.value = seconds;
    slider.setAttribute("aria-valuetext", `${seconds.toFixed(1)} s`);
    const part = seconds < begins ? "on its way to where the recording begins" : seconds > ends ? "after the recording" : `${(seconds - begins).toFixed(1)} s after the recording began`;
    view.show({ q: state.pose ?? poses[0], ghost: poses[below].map((value, j) => value + share * (poses[above][j] - value)), words: `The ghost at ${seconds.toFixed(1)} s, ${part}.` });
  };
  const halt = () => { clearInterval(timer); timer = null; play.textContent = "▶ Play the plan"; };
  play.addEventListener("click", () => {
    if (timer) return halt();
    const from = Number(slider.value) >= preview.seconds - 0.05 ? 0 : Number(slider.value), began = performance.now();
    play.textContent = "❚❚ Pause";
    timer = setInterval(() => {
      const now = from + (performance.now() - began) / 1000;
      at(Math.min(now, preview.seconds));
      if (now >= preview.seconds || !view.box.isConnected) halt();
    }, FRAME);
  });
  slider.addEventListener("input", () => { halt(); at(Number(slider.value)); });
  at(preview.begins);
  const jump = (seconds, text) => el("button", { type: "button", class: "link", title: "Show this moment", onclick: () => { halt(); at(seconds); } }, text);
  return el("div", { class: "beside" }, view.box, el("div", {}, bodies(margins, jump), table(margins, jump)));
}

function bodies({ self, floor }, jump) {
  const gap = (what, one) => el("li", { class: one.margin < CLOSE ? "warning" : "ok" }, el("b", {}, what), " ",
    jump(one.at, `${Math.round(1000 * one.margin)} mm`), ` between ${one.between}, at ${one.at.toFixed(1)} s`);
  return el("ul", { class: "levels" }, floor ? gap("floor", floor) : el("li", {}, "There is no floor under this arm."),
    self ? gap("itself", self) : el("li", {}, "No two bodies of this arm can meet."));
}

const table = ({ joints }, jump) => el("div", { class: "scroll", tabIndex: 0, role: "region", "aria-label": "what is left to the limits" }, el("table", {},
  el("thead", {}, el("tr", {}, ["joint", "to its nearer limit", "speed used", "acceleration used", "torque used"].map((head) => el("th", { scope: "col" }, head)))),
  el("tbody", {}, joints.map((one) => el("tr", {}, el("th", { scope: "row" }, `${one.joint} ${state.robot?.axes[one.joint - 1]?.name ?? ""}`),
    el("td", { class: one.position < TIGHT ? "warn" : "" }, jump(one.at, `${fixed(one.position, 3)} ${unitOf(one.joint - 1)}`)),
    ["velocity", "acceleration", "torque"].map((what) => el("td", { class: one[what] > FULL ? "warn" : "" }, one[what] === null ? "no limit" : `${Math.round(100 * one[what])} %`)))))));
