// All of it by one button: from the arm, or recordings, to a model, what it lacks, and a report.
import { sayAddress } from "../base/address.js";
import { el, fill, renew } from "../base/dom.js";
import { get, post } from "../base/api.js";
import { whyNot } from "../base/condition.js";
import { current, state, watch } from "../base/store.js";
import { failed, guarded, notice } from "../base/notices.js";
import { number, seconds, when } from "../base/units.js";
import { ask } from "../parts/dialog.js";
import { table } from "../parts/blocks.js";
import { courses } from "../parts/courses.js";
import { canMove, changesUnasked, heading } from "../parts/guide.js";
import { finished } from "../parts/jobs.js";
import { runPicker } from "../parts/picker.js";
import { fileLink } from "../parts/report.js";
import { setAside } from "../parts/set_aside.js";
import { storyPanel } from "../parts/story.js";

const MARK = { done: "done", running: "now", waiting: "later", left_out: "left out" };
const WORDS = {
  waiting: "Nothing has moved yet. Look at what will be done, then start it.",
  running: "It is under way.", paused: "It rests. Nothing is lost: it goes on where it is.",
  stopped: "It was stopped. What is done stays done; it goes on from there.",
  failed: "It could not go on. What is done stays done; remove the cause, then go on.", done: "It is done.",
};
const AGAIN = 1500; // ms between looks while it runs
const planned = new Map(); // id -> its motions as they were planned, and how many steps they are of
let parts = null, shown = null, sheet = null, known = [];

export function mount(box) {
  parts = { list: el("div", { class: "versions", role: "tablist", "aria-label": "investigations" }), detail: el("div", { class: "grow" }) };
  fill(box, heading("investigate", "Investigate", { Investigate: "Press 'Show what will be done'.", Start: "The button is below." }), storyPanel(), form(), setAside("investigations"),
    el("div", { class: "columns" }, parts.list, parts.detail));
  watch(["jobs", "ready"], soon);
  watch(["robot", "condition"], () => { if (sheet && state.section === "investigate") draw(sheet.found); }); // whether it may go on
}

/** #/investigate/ID */
export function show([id]) {
  open(id).catch((error) => { if (error.status === 404) failed("This investigation cannot be shown.", error); });
}

async function open(id) {
  if (id) shown = id;
  await refresh();
  if (!id || shown === id) return;
  sayAddress("investigate", ...(shown ? [shown] : []));
  shown = (await get(`investigations/${encodeURIComponent(id)}`)).id; // by its name
  await refresh();
}

let waiting = null;
const soon = () => { waiting ??= setTimeout(() => { waiting = null; if (state.section === "investigate") refresh().catch(() => {}); }, 200); };

async function refresh() {
  known = (await get("investigations", { limit: 500 })).items;
  renew(parts.list, known.map((one) => el("button", {
    type: "button", role: "tab", class: "kind", "aria-selected": String(one.id === shown), dataset: { investigation: one.name },
    onclick: () => { shown = one.id; sayAddress("investigate", one.id); refresh(); },
  }, el("b", {}, one.name), el("small", {}, `${one.status}, ${when(one.created)}`))));
  shown = known.some((one) => one.id === shown) ? shown : known[0]?.id ?? null;
  if (!shown) { sheet = null; return fill(parts.detail); }
  const found = await get(`investigations/${shown}`);
  if (found.id !== shown) return;
  if (planned.get(shown)?.steps !== found.steps.length) {
    planned.set(shown, { steps: found.steps.length, motions: (await get(`investigations/${shown}/motions`)).items });
  }
  draw(found);
  if (found.status === "running") setTimeout(soon, AGAIN);
}

function form() {
  const minutes = el("input", { id: "minutes", type: "number", min: 1, max: 240, step: 1, value: 15 });
  const question = el("select", { id: "question" });
  const source = el("select", { id: "source" }, el("option", { value: "arm" }, "the arm: it moves"), el("option", { value: "runs" }, "recordings: nothing moves"));
  const fit = runPicker("Fit to", "fit"), judge = runPicker("Judge by", "judge");
  const moved = el("label", { class: "picker" }, el("span", {}, "Minutes of motion, at most"), minutes);
  const given = el("div", { class: "row pickers" }, fit.box, judge.box);
  const plan = el("button", { type: "button", class: "primary", id: "plan", onclick: guarded("It could not be planned.", async () => {
    const runs = source.value === "runs";
    const made = await finished(await post("investigations", {
      ...(runs ? { fit: fit.ids, validate: judge.ids } : { minutes: Number(minutes.value) }), ...(question.value ? { since: question.value } : {}) }));
    shown = made.result.id;
    await refresh();
    parts.detail.querySelector("button.primary")?.focus();
  }) }, "Show what will be done");
  const missing = el("small", { role: "status" });
  const turn = () => {
    moved.hidden = source.value === "runs";
    given.hidden = !moved.hidden;
    plan.disabled = moved.hidden && !fit.ids.length;
    missing.textContent = plan.title = plan.disabled ? "Choose the recordings to fit to." : "";
  };
  given.addEventListener("change", turn);
  let own = false; // somebody has chosen
  source.addEventListener("change", () => { own = true; turn(); });
  watch(["robot", "runs"], () => {
    if (!own && state.robot) source.value = canMove() || !state.runs.length ? "arm" : "runs";
    turn();
  });
  watch(["models"], () => {
    if (document.activeElement === question) return;
    const before = question.value;
    fill(question, el("option", { value: "" }, "what is missing in its model?"), current().map((model) => el("option", { value: model.name }, `what has changed since ${model.name}?`)));
    question.value = [...question.options].some((one) => one.value === before) ? before : "";
  });
  watch(["story", "models"], () => { if (changesUnasked() && current().length) question.value ||= current()[0].name; }); // what the guide says to ask
  return el("div", { class: "panel" }, el("div", { class: "row pickers" }, el("h2", {}, "New investigation"),
    el("label", { class: "picker" }, el("span", {}, "Ask"), question), el("label", { class: "picker" }, el("span", {}, "From"), source), moved, given, plan, missing),
  el("p", { class: "muted below" }, "Record, fit, compare, diagnose, settle what is in doubt, add what was found, judge it on fresh motion, report. The motions and their times are shown before anything moves."));
}

/** Part by part, and only what is new: it comes several times a second, and buttons are to be pressed meanwhile. */
function draw(found) {
  if (sheet?.id !== found.id) {
    sheet = { id: found.id, head: el("div", { class: "row between" }), said: el("div", {}), steps: el("ol", { class: "steps" }), result: el("div", {}) };
    fill(parts.detail, el("div", { class: "panel", id: "investigation" }, sheet.head, sheet.said, sheet.steps, sheet.result));
  }
  sheet.found = found;
  const step = found.steps.find((one) => one.status === "running");
  renew(sheet.head, el("h2", {}, found.name, " ", el("small", {}, found.question === "changed" ? "what has changed?" : "what is missing?")), buttons(found));
  renew(sheet.said, el("p", { role: "status", class: found.status === "failed" ? "bad" : "" }, found.error && found.status === "failed" ? `${found.error} ` : "", WORDS[found.status],
    found.pausing ? " It will rest after this step." : ""),
  found.status === "done" ? null : budget(found));
  const lines = found.steps.map((one) => line(one, one === step, found));
  if (sheet.steps.children.length !== lines.length) fill(sheet.steps, lines);
  else lines.forEach((one, k) => { if (sheet.steps.children[k].outerHTML.replaceAll(' open=""', "") !== one.outerHTML) sheet.steps.children[k].replaceWith(one); });
  renew(sheet.result, result(found));
}

/** What is left of it, in s of the arm's clock. */
function budget({ steps, moves: moving, budget_minutes: minutes, moved_seconds: moved }) {
  if (!moving) return null;
  const left = steps.filter((one) => one.experiment && ["waiting", "running"].includes(one.status)).reduce((sum, one) => sum + one.seconds, 0);
  return el("p", { class: "muted" }, `${seconds(moved)} moved, ${seconds(left)} of motion to come, of at most ${number(minutes)} minutes; computing comes on top.`);
}

function line(step, now, found) {
  const motion = planned.get(found.id).motions.find((one) => one.purpose === step.purpose && one.kind === step.experiment?.kind && JSON.stringify(one.parameters) === JSON.stringify(step.experiment.parameters));
  const running = now && [...state.jobs.values()].find((one) => one.request?.investigation === found.id && one.status === "running");
  const next = step.status === "waiting" && found.steps.find((one) => ["waiting", "running"].includes(one.status)) === step;
  const time = step.status === "done" ? (step.moved ? seconds(step.moved) : "") : step.seconds ? `about ${seconds(step.seconds)}` : "";
  return el("li", { class: step.status, dataset: { step: step.id } },
    el("div", { class: "row" }, el("span", { class: "mark" }, next ? "next" : MARK[step.status]), el("b", {}, step.title), el("small", {}, time)),
    running ? el("small", {}, running.message.replace(`${step.title}: `, "")) : null,
    step.why && step.status === "waiting" ? el("small", {}, step.why) : null,
    step.said ? el("p", {}, step.said) : null,
    step.notes.length ? el("details", {}, el("summary", {}, step.notes.length === 1 ? "The note" : `The ${step.notes.length} notes`), el("ul", {}, step.notes.map((one) => el("li", {}, one)))) : null,
    step.tuned.map((line) => el("p", { class: "muted" }, line)),
    motion && step.status === "waiting" && (next || found.status === "waiting") ? courses(motion) : null);
}

function buttons(found) {
  const mine = () => [...state.jobs.values()].find((one) => one.request?.investigation === found.id && ["queued", "running"].includes(one.status));
  if (found.status === "running") {
    return el("div", { class: "row" },
      el("button", { type: "button", disabled: found.pausing, onclick: guarded("It could not be paused.", async () => { await post(`investigations/${found.id}/pause`); await refresh(); }) }, "Pause after this step"),
      el("button", { type: "button", class: "danger", onclick: guarded("It could not be stopped.", async () => { if (mine()) await post(`jobs/${mine().id}/cancel`); await refresh(); }) }, "Stop"));
  }
  if (found.status === "done") return fileLink(`investigations/${found.id}/report`, `${found.name}.html`, "Open the report", { class: "button primary", target: "_blank" });
  const start = el("button", { type: "button", class: "primary", onclick: guarded("It could not be started.", () => begin(found)) }, found.status === "waiting" ? "Start" : "Go on");
  const why = found.moves ? whyNot() : "";
  start.disabled = Boolean(why);
  start.title = why;
  return el("div", { class: "row" }, why ? el("small", {}, why) : null, start);
}

async function begin(found) {
  if (found.status === "waiting" && found.moves) {
    const total = found.steps.filter((one) => one.status === "waiting").reduce((sum, one) => sum + (one.seconds ?? 0), 0);
    if (!await ask("Start the investigation?", `The arm will move for about ${seconds(total)}, in several motions. Keep clear of it. STOP, pause and stop work at any time.`, "Start")) return;
  }
  const job = await post(`investigations/${found.id}/start`);
  finished(job).then(
    (whole) => { if (whole.result.status === "done") notice(`The investigation ‘${found.name}’ is done.`, { action: { href: `#/investigate/${found.id}`, label: "Look" } }); soon(); },
    (error) => { if (!error.wished) notice(`${found.name} did not come to its end.`, { kind: "error", detail: error.message }); soon(); });
  await refresh();
}

function result(found) {
  if (!found.verdict) return null;
  const search = found.steps.filter((one) => one.kind === "diagnose" && one.status === "done").at(-1);
  const judged = found.judged;
  return el("div", { class: "result" }, el("p", { class: `verdict ${found.verdict}` }, search.said),
    judged ? [el("p", {}, `RMS error on runs that ${judged.seen} (${[judged.run_names?.join(", "), `low-pass ${number(judged.cutoff_hz)} Hz, ${judged.mask}`].filter(Boolean).join("; ")}), with ${judged.models.join(" and ")}:`),
      judgedTable(judged), (judged.left ?? []).map((one) => el("p", {}, one))] : null,
    found.doubts.map((doubt) => el("p", {}, doubt.says, " ", doubt.problem ?? "",
      links(found, doubt))));
}

function judgedTable({ models, before, after, noise_floor: floor, units }) {
  const added = models.length > 1;
  return table(["joint", ...(added ? ["before", "after"] : ["error"]), "noise floor", "unit"],
    before.map((first, j) => [String(j + 1), number(first), ...(added ? [number(after[j])] : []), floorOf(floor[j]), units?.[j] ?? "N·m"]));
}

const floorOf = (value) => (value === null ? "not known" : number(value));

function links(found, doubt) {
  const number = found.findings.findIndex((one) => one.effect === doubt.effect && String(one.joints) === String(doubt.joints)) + 1;
  const to = (ending, says) => fileLink(`investigations/${found.id}/doubts/${number}.${ending}`, `${doubt.effect}.${ending}`, says, { class: "button small", download: "" });
  return [doubt.plan ? to("yaml", "Plan") : null, " ", doubt.motion ? to("csv", "Motion") : null];
}
