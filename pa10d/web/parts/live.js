// The last minute of the arm, as it goes.
import { el, fill, say } from "../base/dom.js";
import { followTelemetry } from "../base/live.js";
import { change, state, watch } from "../base/store.js";
import { COLOURS, Scope, shareOf } from "./scope.js";
import { Trail } from "./trail.js";

const KEPT = 60, REDRAW = 100, OLD = 2000; // s, ms, ms
const WINDOWS = [[60, "the last minute"], [10, "the last 10 s"]];

/** What is drawn, from the header of the telemetry. */
function quantities({ limits, prismatic }, place) {
  const at = (stem) => (row, j) => row[place[`${stem}${j + 1}`]];
  const sliding = prismatic?.some(Boolean), q = at("q"), wanted = at("q_ref");
  const angle = sliding ? "rad or m" : "rad";
  return [
    { title: "Position (dashed: target)", unit: angle, least: 0.05, value: q, target: wanted, limits: limits?.q },
    { title: "Tracking error: target less position", unit: sliding ? "mrad or mm" : "mrad", least: 0.5, value: (row, j) => 1000 * (wanted(row, j) - q(row, j)) },
    { title: "Velocity", unit: `${angle}/s`, least: 0.05, value: at("dq"), limits: limits?.dq },
    { title: "Torque measured (dashed: commanded)", unit: sliding ? "N·m or N" : "N·m", least: 1, value: at("tau"), target: at("torque"), limits: limits?.tau },
  ];
}

export function live() {
  const hidden = new Set(), scopes = el("div", { class: "scopes" }), age = el("span", { class: "warn" });
  const chips = el("div", { class: "chips", role: "group", "aria-label": "joints shown" });
  const span = el("select", { "aria-label": "time shown", onchange: () => { if (trail) trail.seconds = Number(span.value); } },
    WINDOWS.map(([seconds, label]) => el("option", { value: seconds }, label)));
  const panel = el("div", { class: "panel" }, el("div", { class: "row between" }, el("h2", {}, "Live"), age, span, chips), scopes,
    el("p", { class: "muted" }, "Show one or two joints to see their limits. Point at a plot to read its values. Vertical lines: the arm's state changed; a fault in red."));
  let trail = null, drawn = [], at = null;
  const anew = followTelemetry(KEPT, {
    header(told) {
      trail = new Trail(KEPT, told);
      trail.seconds = Number(span.value);
      drawn = quantities(told, trail.place).map((one) => new Scope(one, told.joints.length, hidden));
      fill(scopes, drawn.map((scope) => scope.box));
      for (const { canvas } of drawn) {
        canvas.onpointermove = (event) => { at = shareOf(event, canvas); };
        canvas.onpointerleave = () => { at = null; };
      }
      chooser(chips, told.joints, hidden);
    },
    packet(columns, start, rows) {
      trail.add(start, rows);
      if (trail.rows.length) change({ pose: trail.pose() });
    },
  });
  let tuned = state.tuned;
  watch(["tuned"], () => { // limits are others
    if (state.tuned !== tuned) anew();
    tuned = state.tuned;
  });
  watch(["robot"], () => { panel.hidden = state.robot?.state === "offline" && !trail?.rows.length; });
  setInterval(() => {
    if (!trail?.rows.length || !scopes.offsetParent || document.hidden) return;
    const silent = performance.now() - trail.heard;
    const old = state.condition.kind === "lost" || (silent > OLD && !state.robot?.simulated); // simulated time may stand still
    panel.classList.toggle("old", old);
    say(age, old ? `No new values for ${Math.round(silent / 1000)} s.` : "");
    for (const scope of drawn) scope.draw(trail, at);
  }, REDRAW);
  return panel;
}

/** A chip per joint; 'all' brings them back, and 'only' is a double click. */
function chooser(box, names, hidden) {
  const joints = names.map((name, j) => {
    const chip = el("button", { type: "button", class: "chip", title: "show or hide; double click: this joint only",
      onclick: () => { if (hidden.has(j)) hidden.delete(j); else hidden.add(j); tell(); },
      ondblclick: () => { names.forEach((_, k) => hidden.add(k)); hidden.delete(j); tell(); } }, el("i", {}), `${j + 1} ${name}`);
    chip.style.setProperty("--chip", COLOURS[j % COLOURS.length]);
    return chip;
  });
  const all = el("button", { type: "button", class: "chip", onclick: () => {
    const none = !hidden.size;
    names.forEach((_, j) => (none ? hidden.add(j) : hidden.delete(j)));
    tell();
  } });
  const tell = () => {
    joints.forEach((chip, j) => chip.setAttribute("aria-pressed", String(!hidden.has(j))));
    say(all, hidden.size ? "all" : "none");
  };
  tell();
  fill(box, all, joints);
}
