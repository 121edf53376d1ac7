// Known weights set the scale of the torques: what to hang, when to record, and what came of it.
import { el, fill } from "../base/dom.js";
import { get, post } from "../base/api.js";
import { MAY_MOVE, UNPOWERED, whyNot } from "../base/condition.js";
import { state, watch } from "../base/store.js";
import { failed, guarded, notice } from "../base/notices.js";
import { seconds } from "../base/units.js";
import { table } from "./blocks.js";
import { ask } from "./dialog.js";
import { finished } from "./jobs.js";

const percent = (share) => share === null ? "–" : `${(100 * share).toPrecision(2)} %`;
let shown = null, detail = null;

export function weighingPanel() {
  detail = el("div", { id: "weighing", "aria-live": "polite" });
  const box = el("div", {}, el("h2", {}, "Known weight"), el("div", { class: "panel" },
    el("p", { class: "muted" }, "A fit to the arm alone takes the drives' torque constants as they are stated. A weight that is known tells them: the same slow motion is recorded without it and with it, and what differs is the weight, measured in each joint's own newton metres."),
    form(), detail));
  watch(["ready", "jobs", "tuned"], () => { if (state.ready) refresh().catch(() => {}); }, box);
  watch(["robot", "condition"], allow, box);
  return box;
}

function form() {
  const fields = [["mass", "mass", "kg", 3], ["x", "x", "m", 0.05], ["y", "y", "m", 0], ["z", "z", "m", 0.1]].map(([key, label, unit, value]) => ({
    key, label, unit, value: el("input", { id: `weight-${key}`, type: "number", step: "any", value, required: true, min: key === "mass" ? 0.001 : undefined }),
    error: el("input", { id: `weight-${key}-error`, type: "number", step: "any", min: 0, placeholder: key === "mass" ? "0.2 %" : "0.002", "aria-label": `standard error of ${label}, ${unit}` }),
  }));
  const text = () => fields.map(({ value, error }) => value.value + (error.value ? `+-${error.value}` : "")).join(",");
  const add = async (button) => {
    if (!box.reportValidity()) return;
    const going = shown && !shown.applied && button.dataset.to === "this";
    shown = going ? await post(`weighings/${shown.id}/weights`, { weight: text() }) : await post("weighings", { weights: [text()] });
    draw();
  };
  const begin = el("button", { type: "submit", class: "primary", id: "weigh-begin" }, "Plan the motion");
  const more = el("button", { type: "button", id: "weigh-more", dataset: { to: "this" }, hidden: true,
    onclick: guarded("The weight could not be taken.", () => add(more)) }, "Add it to the weights at hand");
  const box = el("form", { class: "weight", onsubmit: (event) => event.preventDefault() }, el("div", { class: "fields" }, fields.map(({ key, label, unit, value, error }) =>
    el("div", { class: "field" }, el("label", { htmlFor: value.id }, `${label}, ${unit}`), value, el("small", {}, "± ", error, key === "mass" ? " kg, as weighed" : " m, as measured")))),
  el("p", { class: "muted" }, "The centre of the weight is given in the last joint's frame. One that hangs off the last axis (x, y) loads the last joint, too."),
  el("div", { class: "row" }, begin, more));
  box.addEventListener("submit", () => guarded("The motion could not be planned.", () => add(begin))({ currentTarget: begin }));
  return box;
}

async function refresh() {
  if (!shown) {
    const { items } = await get("weighings", { limit: 1 });
    shown = items[0] ?? null;
  } else {
    shown = await get(`weighings/${shown.id}`);
  }
  draw();
}

function draw() {
  document.getElementById("weigh-more").hidden = !shown || Boolean(shown.applied);
  if (!shown) return fill(detail);
  const found = shown, { next, motion } = found;
  const chosen = el("select", { id: "weigh-with" }, el("option", { value: 0 }, "nothing"), found.weights.map((one) => el("option", { value: one.number }, one.says)));
  chosen.value = String(next.weight ?? 0);
  const record = el("button", { type: "button", class: next.weight === null ? "" : "primary", id: "weigh-record", dataset: { moves: "yes" },
    onclick: guarded("It could not be recorded.", () => recorded(found, Number(chosen.value))) }, "Record");
  fill(detail, el("h3", {}, found.name, " ", el("small", {}, `${seconds(motion.seconds)} of motion for each recording`)),
    motion.notes.map((note) => el("p", { class: "muted" }, note)),
    el("ol", { class: "steps" }, step("The arm without a weight", found.empty, next.weight === 0),
      found.weights.map((one) => step(one.says, one.runs, next.weight === one.number))),
    found.applied ? null : [el("p", { role: "status" }, el("b", {}, "Next: "), next.says),
      el("div", { class: "row pickers" }, el("label", { class: "picker" }, el("span", {}, "What hangs there"), chosen), record)],
    result(found), applied(found));
  allow();
}

const step = (title, runs, next) => el("li", { class: runs.length ? "done" : next ? "running" : "waiting" }, el("div", { class: "row" },
  el("span", { class: "mark" }, runs.length ? "done" : next ? "next" : "later"), el("b", {}, title), el("small", {}, runs.length ? `${runs.length} recorded` : "")));

function result(found) {
  if (!found.joints.length) return null;
  const gains = table(["joint", "measured / true torque", "of it noise", "weight", "friction leaves"], found.joints.map((one) => one.gain === null
    ? [`${one.joint} ${one.name}`, `not determined: ${one.why}`, "", "", ""]
    : [`${one.joint} ${one.name}`, `${one.gain.toFixed(4)} ± ${one.std_error.toFixed(4)}${one.disagree ? " (recordings disagree)" : ""}`, one.of_noise.toFixed(4), one.of_weight.toFixed(4),
      one.between ? `${one.between[0].toFixed(3)} … ${one.between[1].toFixed(3)}` : ""]));
  const bring = found.prospects.length ? [el("h3", {}, "What the other weights at hand would bring"), table(["weight", ...found.joints.map((one) => `joint ${one.joint}`)],
    found.prospects.map((one) => [`${one.mass} kg${one.next ? " (next)" : ""}${one.too_much ? `, too heavy for joint ${one.too_much}` : ""}`, ...one.std_error.map(percent)]))] : null;
  return [found.joints.some((one) => one.gain !== null) ? [el("h3", {}, "Torque gains"), gains] : null, bring, el("p", {}, found.advice)];
}

function applied(found) {
  if (found.applied) {
    const gains = Object.entries(found.applied.gains).map(([joint, gain]) => `joint ${joint}: ${gain}`).join(", ");
    return [el("p", { class: "verdict none" }, `The profile has these torque gains now (${gains}). Recordings from before keep their scale: record and fit anew.`),
      el("button", { type: "button", id: "weigh-undo", dataset: { rests: "yes" }, onclick: guarded("It could not be undone.", async () => {
        shown = await post(`weighings/${found.id}/undo`);
        draw();
        notice("The profile is what it was before.");
      }) }, "Undo")];
  }
  if (!found.joints.some((one) => one.gain !== null)) return null;
  return el("button", { type: "button", id: "weigh-apply", dataset: { rests: "yes" }, onclick: guarded("The gains could not be written.", async () => {
    if (!await ask("Write the gains into the profile?", "It becomes a new version of the profile, and control starts anew with it. Undo brings the old one back.", "Write")) return;
    shown = await post(`weighings/${found.id}/apply`);
    draw();
  }) }, "Write the gains into the profile");
}

async function recorded(found, weight) {
  const what = weight ? `the weight: ${found.weights[weight - 1].says}` : "no weight";
  const sure = state.robot?.simulated ? `The virtual arm ${weight ? "hangs it" : "takes off what hangs there"} by itself.`
    : weight ? "See that it is so, and that it is fastened." : "See that nothing hangs there.";
  if (!await ask("Record now?", `The arm moves for about ${seconds(found.motion.seconds)}, slowly, with ${what}. ${sure} Keep clear of the arm.`, "Record")) return;
  const job = await post(`weighings/${found.id}/record`, { weight });
  finished(job).then((whole) => { shown = whole.result; draw(); }, (error) => failed("It was not recorded.", error));
}

/** Buttons that move the arm, or need it at rest, say why they cannot. */
function allow() {
  for (const button of detail.querySelectorAll("button[data-moves], button[data-rests]")) {
    const why = whyNot(button.dataset.moves ? MAY_MOVE : UNPOWERED);
    button.disabled = Boolean(why);
    button.title = why;
  }
}
