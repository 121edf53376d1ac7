// What a change did: a small step or sines of one joint, recorded, and several runs beside each other.
import { el, fill } from "../base/dom.js";
import { get, post } from "../base/api.js";
import { whyNot } from "../base/condition.js";
import { current, state, watch } from "../base/store.js";
import { failed, guarded, notice } from "../base/notices.js";
import { number, titled } from "../base/units.js";
import { Chart } from "./chart.js";
import { choices } from "./choices.js";
import { finished } from "./jobs.js";
import { lawInWords, lawOf, lawsWith } from "./laws.js";
import { COLOURS } from "./scope.js";

const KINDS = ["step", "tracking"], MOST = 6, HEIGHT = 260;
const SINES = { amplitude: 0.1, period: 3, cycles: 2 };

/** {box, show(joints, units)}. */
export function tunedResponse() {
  const chosen = new Set();
  let units = [], asked = 0, own = false, ownJoint = false;
  const joint = el("select", { id: "tune-joint" }), motion = el("select", { id: "tune-motion" }, el("option", { value: "step" }, "small step"), el("option", { value: "tracking" }, "sines"));
  const size = el("input", { id: "tune-size", type: "number", step: "any", min: 0.001, max: 0.2, value: 0.05, inputMode: "decimal" });
  const law = el("select", { id: "tune-law" }), start = el("button", { type: "submit", class: "primary" }, "Record");
  const labelled = (input, text, hint) => el("div", { class: "field" }, el("label", { htmlFor: input.id }, text), input, el("small", {}, hint));
  const stepSays = el("span", {}), sinesSay = el("span", {});
  const inUnit = () => {
    const unit = units[joint.value - 1] ?? "rad";
    stepSays.textContent = `${unit}, of the step, 0.2 at most`;
    sinesSay.textContent = `sines: ${SINES.amplitude} ${unit} in ${SINES.period} s, twice`;
  };
  const form = el("form", { onsubmit: (event) => { event.preventDefault(); record(); } }, el("div", { class: "fields" },
    labelled(joint, "joint", "it moves alone"), labelled(motion, "motion", sinesSay), labelled(size, "size", stepSays),
    labelled(law, "moved by", "with a model: its torque goes ahead")), el("div", { class: "row" }, start));
  const runs = choices("Recordings", items, chosen, () => { own = true; draw(); });
  const said = el("p", { class: "muted" }), chart = new Chart(HEIGHT), error = new Chart(HEIGHT), table = el("div", {});
  const plots = el("div", { hidden: true }, el("figure", { class: "plot" }, el("figcaption", {}, "Target and response"), chart.box),
    el("figure", { class: "plot" }, el("figcaption", {}, "Tracking error"), error.box), table);
  const box = el("div", { class: "panel" }, el("h2", {}, "What it does to the motion"),
    el("p", { class: "muted" }, "Record the same motion before and after a change, or with another controller. It is checked as every motion; the arm is powered for it, and left as it was found."),
    form, el("div", { class: "row pickers below" }, runs.box), said, plots);

  function items() {
    return state.runs.filter((run) => KINDS.includes(run.kind) && run.status === "success" && run.channels.includes("commands"))
      .map((run) => ({ id: run.id, label: run.name, note: titled(run.kind) }));
  }

  const record = guarded("The motion could not be started.", async () => {
    const j = Number(joint.value), kind = motion.value;
    const parameters = kind === "step" ? { joints: [j], size: Number(size.value) } : { joints: [j], ...SINES };
    const job = await post("experiments", { kind, parameters, ...lawOf(law.value) });
    finished(job).then((whole) => {
      const { name } = whole.result.recorded[0];
      notice(`Recorded ${name}.`, { detail: "Its figures are below, beside those of the others." });
      for (const id of whole.result.runs) chosen.add(id);
      own = true;
    }).catch((problem) => failed("The motion did not end well.", problem)).finally(refresh);
  });

  function refresh() {
    const all = items(), there = new Set(all.map((one) => one.id));
    if (state.runs.length) for (const id of [...chosen]) if (!there.has(id)) chosen.delete(id);
    if (!own && !chosen.size) for (const one of all.slice(0, 2)) chosen.add(one.id);
    runs.refresh();
    draw();
  }

  /** Oldest first: before, then after. */
  async function draw() {
    const mine = ++asked, ids = items().filter((one) => chosen.has(one.id)).map((one) => one.id).reverse().slice(-MOST);
    plots.hidden = !ids.length;
    said.textContent = ids.length ? "" : "Nothing is recorded yet, or nothing chosen.";
    if (!ids.length || !joint.value) return;
    try {
      const found = (await get("responses", { run: ids, joint: joint.value })).items, unit = units[joint.value - 1] ?? "rad";
      if (mine !== asked) return;
      const { moved } = found.at(-1);
      if (!ownJoint && moved.length && !moved.includes(Number(joint.value))) {
        joint.value = moved[0]; // nobody has asked for a joint: one that there is something to see of
        inUnit();
        return draw();
      }
      const color = (k) => COLOURS[k % COLOURS.length], met = new Set();
      const withTarget = found.map((one) => { const key = `${one.kind} ${one.steps[0]?.size.toFixed(4)} ${one.time.length}`, first = !met.has(key); met.add(key); return first; });
      await chart.lines({ x: "time, s", y: `position, ${unit}`, span: null,
        tables: found.map((one, k) => [one.time, ...(withTarget[k] ? [one.target] : []), one.response]),
        series: found.flatMap((one, k) => [...(withTarget[k] ? [{ label: `target, ${one.name}`, color: color(k), dash: [7, 4] }] : []), { label: one.name, color: color(k) }]) });
      await error.lines({ x: "time, s", y: `target − response, ${unit}`, span: null, series: found.map((one, k) => ({ label: one.name, color: color(k) })),
        tables: found.map((one) => [one.time, one.target.map((value, i) => value - one.response[i])]) });
      if (mine === asked) fill(table, figures(found, unit));
    } catch (problem) {
      if (mine === asked) said.textContent = problem.message;
    }
  }

  watch(["models"], () => {
    const before = law.value;
    fill(law, el("option", { value: "" }, "the controller in use"), el("option", { value: "pid" }, "PID alone"), lawsWith(current().map((model) => model.name)));
    law.value = [...law.options].some((one) => one.value === before) ? before : "";
  });
  watch(["runs"], refresh);
  watch(["robot", "jobs", "condition"], () => {
    const why = whyNot();
    start.disabled = Boolean(why);
    start.title = why;
  });
  motion.addEventListener("change", () => { size.disabled = motion.value !== "step"; });
  joint.addEventListener("change", () => { ownJoint = true; inUnit(); draw(); });
  return {
    box,
    show(names, ofJoints) {
      units = ofJoints;
      const before = joint.value || "1";
      fill(joint, names.map((name, j) => el("option", { value: j + 1 }, `${j + 1} ${name}`)));
      joint.value = before;
      inUnit();
      refresh();
    },
  };
}

const worst = (values) => (values.some((one) => one === null) ? null : Math.max(...values));
const mean = (values) => (values.some((one) => one === null) ? null : values.reduce((sum, one) => sum + one, 0) / values.length);

function movedBy(control) {
  if (!control) return "not said";
  if (control.law !== "pid") return lawInWords(control.law, control.model);
  return control.ahead ? "PID, what was measured ahead" : "PID alone";
}

/** One row a run; errors against the first of them. */
function figures(found, unit) {
  const rms = (one) => (one.steps.length ? Math.sqrt(mean(one.steps.map((step) => step.rms ** 2))) : one.rms);
  const most = (one) => (one.steps.length ? Math.max(...one.steps.map((step) => step.worst)) : one.worst);
  const against = (value, first, k) => (k && first > 0 ? ` (${value > first ? "+" : ""}${number(100 * (value / first - 1), 2)} %)` : "");
  const never = (value) => (value === null ? "never" : number(value, 3));
  const heads = ["recording", "moved by", "kp", "ki", "kd", "mean rise, s", "target's rise, s", "most overshoot", "longest settling, s", `RMS error, ${unit}`, `largest error, ${unit}`];
  return el("div", { class: "scroll bare", tabIndex: 0, role: "region", "aria-label": "figures of the responses" }, el("table", { class: "answers" },
    el("thead", {}, el("tr", {}, heads.map((head) => el("th", { scope: "col" }, head)))),
    el("tbody", {}, found.map((one, k) => {
      const steps = one.steps, of = (f, key) => (steps.length ? never(f(steps.map((step) => step[key]))) : "–");
      const cells = [movedBy(one.control), ...["kp", "ki", "kd"].map((key) => number(one.control?.[key], 4)), of(mean, "rise"), of(mean, "target_rise"),
        steps.length ? `${number(100 * worst(steps.map((step) => step.overshoot)), 2)} %` : "–", of(worst, "settling"),
        number(rms(one), 3) + against(rms(one), rms(found[0]), k), number(most(one), 3) + against(most(one), most(found[0]), k)];
      return el("tr", {}, el("th", { scope: "row" }, one.name), cells.map((text) => el("td", {}, text)));
    }))));
}
