// A motion before it is made: each joint's position over time, as one small drawing.
import { el, svg } from "../base/dom.js";
import { number, seconds } from "../base/units.js";
import { unitOf, unitOfAll } from "./arm.js";

const WIDTH = 420, HEIGHT = 118, LEFT = 40, RIGHT = 6, TOP = 6, BOTTOM = 18;

/** time (N) s, q (N × n) rad or m, joints: {joint, q_min, q_max, dq_max}; the numbers stand below it. */
export function courses({ kind, time, q, joints }) {
  const low = Math.min(...joints.map((j) => j.q_min)), high = Math.max(...joints.map((j) => j.q_max)), end = time.at(-1), unit = unitOfAll();
  const x = (t) => LEFT + (WIDTH - LEFT - RIGHT) * t / (end || 1);
  const y = (v) => HEIGHT - BOTTOM - (HEIGHT - TOP - BOTTOM) * (v - low) / (high - low || 1);
  const lines = joints.map((joint, j) => svg("polyline", {
    points: time.map((t, k) => `${x(t).toFixed(1)},${y(q[k][j]).toFixed(1)}`).join(" "),
    class: `course course-${j % 7}`, fill: "none", "stroke-width": 1.4 },
  svg("title", {}, `joint ${joint.joint}`)));
  const label = (at, place, text, anchor) => svg("text", { x: at, y: place, "text-anchor": anchor }, text);
  const said = `${kind.replaceAll("_", " ")}: positions of ${joints.length} joints between ${number(low)} and ${number(high)} ${unit} over ${seconds(end)}`;
  return el("div", { class: "courses" },
    svg("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", "aria-label": said },
      svg("path", { class: "frame", d: `M${LEFT} ${TOP}V${HEIGHT - BOTTOM}H${WIDTH - RIGHT}` }), ...lines,
      label(LEFT - 4, TOP + 9, number(high, 2), "end"), label(LEFT - 4, HEIGHT - BOTTOM, number(low, 2), "end"), label(LEFT - 4, (TOP + HEIGHT - BOTTOM) / 2 + 4, unit, "end"),
      label(LEFT, HEIGHT - 4, "0", "start"), label(WIDTH - RIGHT, HEIGHT - 4, `${number(end, 3)} s`, "end")),
    el("p", { class: "key" }, joints.map((joint, j) => el("span", { class: `key-${j % 7}` }, el("i", {}), `joint ${joint.joint}`))),
    el("details", {}, el("summary", {}, "in numbers"), el("table", {},
      el("thead", {}, el("tr", {}, ["joint", "from", "to", "fastest"].map((cell) => el("th", { scope: "col" }, cell)))),
      el("tbody", {}, joints.map((j) => el("tr", {}, [j.joint, `${number(j.q_min)} ${unitOf(j.joint - 1)}`, `${number(j.q_max)} ${unitOf(j.joint - 1)}`, `${number(j.dq_max)} ${unitOf(j.joint - 1)}/s`].map((cell) => el("td", {}, String(cell)))))))));
}
