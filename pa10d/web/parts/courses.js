// A motion before it is made: each joint's angle over time, as one small drawing.
import { el, svg } from "../base/dom.js";
import { number, seconds } from "../base/units.js";

const WIDTH = 320, HEIGHT = 90, EDGE = 3;

/** time (N) s, q (N × n) rad, joints: {joint, q_min, q_max, dq_max}; the numbers stand below it. */
export function courses({ kind, time, q, joints }) {
  const low = Math.min(...joints.map((j) => j.q_min)), high = Math.max(...joints.map((j) => j.q_max));
  const x = (t) => EDGE + (WIDTH - 2 * EDGE) * t / (time.at(-1) || 1);
  const y = (v) => HEIGHT - EDGE - (HEIGHT - 2 * EDGE) * (v - low) / (high - low || 1);
  const lines = joints.map((joint, j) => svg("polyline", {
    points: time.map((t, k) => `${x(t).toFixed(1)},${y(q[k][j]).toFixed(1)}`).join(" "),
    class: `course course-${j % 7}`, fill: "none", "stroke-width": 1.4 },
  svg("title", {}, `joint ${joint.joint}`)));
  const said = `${kind.replaceAll("_", " ")}: angles of ${joints.length} joints between ${number(low)} and ${number(high)} rad over ${seconds(time.at(-1))}`;
  return el("div", { class: "courses" },
    svg("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", "aria-label": said }, ...lines),
    el("details", {}, el("summary", {}, "in numbers"), el("table", {},
      el("thead", {}, el("tr", {}, ["joint", "from, rad", "to, rad", "fastest, rad/s"].map((cell) => el("th", { scope: "col" }, cell)))),
      el("tbody", {}, joints.map((j) => el("tr", {}, [j.joint, number(j.q_min), number(j.q_max), number(j.dq_max)].map((cell) => el("td", {}, String(cell)))))))));
}
