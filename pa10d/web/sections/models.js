// Torque models: fit the first one, see the error fall from version to version, use them.
import { sayAddress } from "../base/address.js";
import { el, fill } from "../base/dom.js";
import { download, get, put, remove } from "../base/api.js";
import { whyNot } from "../base/condition.js";
import { current, loadModels, loadRobot, state, watch } from "../base/store.js";
import { ask } from "../parts/dialog.js";
import { failed, guarded, notice, toKnow } from "../base/notices.js";
import { nextModelName, number, when } from "../base/units.js";
import { table } from "../parts/blocks.js";
import { empty, plot } from "../parts/figure.js";
import { tabsByKeys } from "../parts/tabs.js";
import { heading } from "../parts/guide.js";
import { setAside } from "../parts/set_aside.js";
import { postSound } from "../parts/forced.js";
import { finished } from "../parts/jobs.js";
import { modelPicker, nameOf, runPicker } from "../parts/picker.js";
import { fitOptions } from "../parts/fitoptions.js";
import { reportButton } from "../parts/report.js";

let parts = null, chosen = null, wanted = null, detailed = null, drawn = ""; // detailed: whose details are shown

export function mount(box) {
  parts = { list: tabsByKeys(el("div", { class: "versions", role: "tablist", "aria-label": "models" })), detail: el("div", { class: "grow" }),
            judge: runPicker("Judged by", "judge", () => refreshPlots()) };
  fill(box, heading("models", "Models", { Fit: "Press 'Fit'." }), fitForm(), setAside("models"),
    el("div", { class: "columns" }, parts.list, parts.detail));
  watch(["models", "ready"], refresh);
}

/** #/models/NAME */
export function show([name]) {
  wanted = name ?? wanted;
  refresh();
  if (wanted) lookFor(wanted).catch((error) => failed("This model cannot be shown.", error));
}

/** One that is not in the list: made a moment ago, replaced, or none at all. */
async function lookFor(name) {
  try {
    const found = await get(`models/${encodeURIComponent(name)}`);
    if (found.replaced) throw new Error(`${name} was replaced by another of its name.`);
    if (wanted === name) wanted = found.name;
    await loadModels();
  } catch (error) {
    if (wanted === name) wanted = null;
    sayAddress("models");
    throw error;
  }
}

function refresh() {
  const models = current();
  const found = models.find((one) => [one.name, one.id].includes(wanted)) ?? models.find((one) => one.id === chosen) ?? models[0];
  if (found?.name === wanted) wanted = null;
  fill(parts.list, models.map((model) => el("button", {
    type: "button", role: "tab", class: "kind", "aria-selected": String(model.id === found?.id), dataset: { model: model.name },
    onclick: () => { chosen = model.id; wanted = null; sayAddress("models", model.name); refresh(); },
  }, el("b", {}, model.name), el("small", {}, model.change), el("small", {}, `${model.parent_name ? `from ${model.parent_name}, ` : ""}${when(model.created)}`))));
  if (!found) {
    detailed = null;
    drawn = "";
    fill(parts.detail, state.ready ? empty("There is no model yet. Choose the runs to fit one to above, and press Fit.") : null);
  } else if (detailed !== found.id) {
    chosen = detailed = found.id;
    drawn = "";
    fill(parts.detail, details(found));
    refreshPlots();
  }
}

function fitForm() {
  let how = null;
  const runs = runPicker("Fit to", "fit", () => { how?.refresh(); allow(); });
  const name = el("input", { id: "model-name", maxLength: 100, size: 12, required: true });
  const start = el("button", { class: "primary", id: "fit-start", type: "button", onclick: guarded("The model could not be fitted.", async () => {
    const job = await postSound("models", { runs: runs.ids, name: name.value.trim(), ...how.read() });
    const made = (await finished(job)).result;
    wanted = made.name;
    notice(`${made.name} is fitted.`, { known: made.warnings, action: { href: `#/compare/of/${made.name}`, label: "See where it fails" } });
  }) }, "Fit");
  how = fitOptions(runs);
  function allow() {
    if (!how) return;
    start.disabled = !runs.ids.length;
    start.title = start.disabled ? "choose at least one run" : "";
  }
  watch(["models"], () => { if (document.activeElement !== name) name.value = nextModelName(current().map((model) => model.name)); });
  allow();
  return el("div", { class: "panel row pickers" }, el("h2", {}, "New model"), runs.box,
    el("label", { class: "picker" }, el("span", {}, "Name"), name), start, how.box);
}

function details(model) {
  parts.stairs = el("div", { class: "stairs" });
  parts.versus = el("div", {});
  parts.parameters = el("div", {}, el("p", { class: "muted" }, "Loading …"));
  parts.other = modelPicker("Compare with", () => drawVersus(model));
  if (model.parent_name) parts.other.value = model.parent_name;
  parts.delivered = el("div", {});
  const known = el("div", {});
  get(`models/${model.id}`).then((found) => {
    if (detailed !== model.id) return;
    fill(parts.parameters, parameters(found));
    fill(parts.delivered, delivered(found));
    fill(parts.exports, "Export", exporters(found));
    fill(known, toKnow(found.warnings));
  },
    (error) => fill(parts.parameters, el("p", { class: "bad" }, error.message)));
  const load = el("button", { type: "button", class: "load", onclick: guarded("The controller stays as it was.", async () => {
    await put("robot/controller", { controller: "computed_torque", model: model.name });
    await loadRobot();
    notice("Loaded.", { detail: `The arm is now moved by computed torque with ${model.name}.`, action: { href: "#/robot", label: "Robot" } });
  }) }, "Load into the controller");
  watch(["robot", "jobs", "condition"], () => {
    const loaded = state.robot?.model === model.name;
    load.title = loaded ? "" : whyNot();
    load.disabled = loaded || Boolean(load.title);
    load.textContent = loaded ? "Loaded in the controller" : "Load into the controller";
  }, load);
  parts.exports = el("div", { class: "row" });
  const report = reportButton(() => model.name, () => parts.judge.ids);
  return [
    el("div", { class: "panel" }, el("div", { class: "row between" }, el("h2", {}, model.name, " ", el("small", {}, model.change)),
      el("div", { class: "row" }, load, undo(model), report, parts.exports)),
    el("p", { class: "muted" }, `Rigid bodies, ${grouped(model.effects)}. Fitted to ${model.runs.length} run${model.runs.length === 1 ? "" : "s"}, low-passed at ${number(model.cutoff_hz)} Hz. ${model.feasible
      ? "Every link is a body that can exist."
      : "No possible bodies are known for its links: it predicts torque, but makes no URDF. Diagnose what is missing, or fit to richer motion."}`),
    known, parts.judge.box),
    parts.delivered, parts.stairs, el("details", { class: "block" }, el("summary", {}, el("h2", {}, "Against another model")), parts.other.box, parts.versus),
    el("details", { class: "block", open: true }, el("summary", {}, el("h2", {}, "Parameters ", el("small", {}, "with 95 % intervals"))), parts.parameters),
  ];
}

const exporters = (model) => Object.entries(model.formats).map(([format, ending]) => el("button", {
  type: "button", class: "small", title: `Export ${model.name} as ${format}`,
  onclick: guarded("It could not be exported.", () => download(`models/${model.id}/export`, { format }, `${model.name}.${ending}`)) }, format.toUpperCase().replace("_", " ")));

/** Which samples count in an error, in which band: of one model there is another one, with reversals, in Compare. */
const where = ({ cutoff_hz: band, mask }, of) => el("p", { class: "muted pad" }, mask
  ? `RMS error on ${of}; low-pass ${number(band)} Hz, ${mask}. Compare has the error with reversals beside it.`
  : `RMS error on ${of}; an older version has written it, and not kept which samples count.`);
const judges = () => parts.judge.ids.map(nameOf).join(", ");

/** What the search promised and what came of it, for every joint. */
function delivered({ delivery, joints, torque_units: units, name }) {
  if (!delivery) return null;
  const { before, promised, achieved, worse } = delivery;
  return el("details", { class: "block", open: true }, el("summary", {}, el("h2", {}, "Promised and achieved ", el("small", {}, "error on the runs that the search judged by"))),
    table(["joint", "as given", "promised", `achieved by ${name}`, "unit", "the error"], joints.map((joint, j) => [
      `${j + 1} ${joint}`, number(before[j]), number(promised[j]), number(achieved[j]), units[j],
      worse.includes(j + 1) ? el("b", { class: "bad" }, "worse than before") : achieved[j] < 0.95 * before[j] ? el("span", { class: "good" }, "fell") : "as before"])),
    where(delivery, "the runs that the search judged by"),
    worse.length ? el("p", { class: "bad" }, "Where a joint became worse, this version is no gain there: undo it, or ask what is missing in it.") : null);
}

/** The last version of a line can be taken back; nothing else is touched by that. */
function undo(model) {
  const button = el("button", { type: "button", class: "undo", onclick: guarded("It could not be undone.", async () => {
    if (!await ask(`Undo ${model.name}?`, `${model.name} (${model.change}) is removed; ${model.parent_name} and all runs stay as they are.`, "Undo", { danger: true })) return;
    await remove(`models/${model.id}`);
    wanted = model.parent_name;
    await loadModels();
    notice(`${model.name} is gone.`, { detail: `${model.parent_name} is the last version again.` });
  }) }, `Undo: back to ${model.parent_name}`);
  watch(["models"], () => { button.hidden = !model.parent_name || state.models.some((one) => one.parent === model.id); }, button);
  return button;
}

/** "coulomb J1", "coulomb J2" … as "coulomb J1-7". */
function grouped(labels) {
  const joints = new Map();
  for (const label of labels) {
    const [effect, ...where] = label.split(" ");
    joints.set(effect, [...(joints.get(effect) ?? []), where.join(" ").replace("J", "")]);
  }
  return [...joints].map(([effect, where]) => {
    const plain = where.every((one) => /^\d+$/.test(one)) && where.length > 2 && Number(where.at(-1)) - Number(where[0]) === where.length - 1;
    return `${effect.replaceAll("_", " ")}${where[0] ? ` J${plain ? `${where[0]}–${where.at(-1)}` : where.join(", J")}` : ""}`;
  }).join(", ");
}

async function refreshPlots() {
  const runs = parts?.judge?.ids ?? [], model = state.models.find((one) => one.id === chosen);
  if (!model || !parts.stairs) return;
  const key = `${model.id}:${runs}`;
  if (drawn === key) return;
  drawn = key;
  if (!runs.length) {
    fill(parts.stairs, empty("Mark a run as 'judge' (one that the model was not fitted to), and the error of every version appears here.", { href: "#/runs", label: "Runs" }));
    return;
  }
  try {
    const found = await get("plots/staircase", { model: model.id, run: runs });
    if (drawn !== key) return;
    fill(parts.stairs, plot({ title: "Every version on the same runs", figures: found.figure, reading: found, advice: fell(found) }), where(found, judges()), stepsTable(found, model.joints));
    drawVersus(model);
  } catch (error) {
    drawn = "";
    fill(parts.stairs, el("p", { class: "bad pad" }, error.message));
  }
}

/** The joint whose error fell most, in a sentence; of those whose torque is known. */
function fell({ steps, noise_floor: floor, units, hidden }) {
  if (steps.length < 2) return "This is the first version: diagnose it to learn what is missing.";
  const first = steps[0].rms, last = steps.at(-1).rms;
  const asked = [...first.keys()].filter((k) => !hidden.includes(k + 1));
  if (!asked.length) return "No joint's torque is known in these runs: their errors say nothing. Judge by others.";
  const j = asked.reduce((best, k) => (first[k] / last[k] > first[best] / last[best] ? k : best));
  if (first[j] <= last[j]) return "No joint's error fell: go back to the parent.";
  const noise = floor[j] === null ? "" : `; the noise is ${number(floor[j])} ${units[j]}`;
  return `The error of joint ${j + 1} fell from ${number(first[j])} to ${number(last[j])} ${units[j]}${noise}.`;
}

const stepsTable = (found, joints) => el("details", { class: "block" }, el("summary", {}, "Every error, in its unit"),
  table(["joint", ...found.steps.map((step) => step.model), "noise floor", "unit"], joints.map((name, j) =>
    [`${j + 1} ${name}`, ...found.steps.map((step) => number(step.rms[j])), number(found.noise_floor[j]), found.units[j]])));

async function drawVersus(model) {
  const runs = parts?.judge?.ids ?? [], other = parts?.other?.value;
  if (!runs.length || !other || other === model.name || model.id !== chosen) return;
  try {
    const found = await get("plots/versus", { one: other, other: model.id, run: runs });
    fill(parts.versus, plot({ title: `${other} and ${model.name}`, figures: found.figure, reading: found }), where(found, judges()));
  } catch (error) {
    fill(parts.versus, el("p", { class: "bad" }, error.message));
  }
}

const PARAMETERS = [ // head, value to sort by, how it is shown
  ["parameter", (one) => one.name, (one) => one.name],
  ["value", (one) => one.value, (one) => (one.determined ? number(one.value, 4) : "not determined")],
  ["± standard error", (one) => one.std_error ?? Infinity, (one) => (one.determined ? number(one.std_error, 2) : "–")],
  ["error, % of value", (one) => relative(one), (one) => (one.determined && Number.isFinite(relative(one)) ? number(relative(one), 2) : "–")],
  ["95 % interval", (one) => one.value, (one) => (one.determined && one.std_error > 0 ? `${number(one.value - 1.96 * one.std_error)} … ${number(one.value + 1.96 * one.std_error)}` : "–")],
  ["URDF", (one) => one.urdf ?? -Infinity, (one) => (one.urdf === null ? "–" : number(one.urdf, 4))],
  ["unit", (one) => one.unit, (one) => (one.unit === "1" ? "" : one.unit)],
  ["what to know", (one) => one.flags.join(), (one) => one.flags.join(", ")],
];
const relative = (one) => 100 * (one.std_error ?? Infinity) / Math.abs(one.value);

/** Sorted by the head that is pressed; pressed again, the other way round. */
function parameters(model) {
  const body = el("tbody", {});
  let by = null, way = 1;
  const heads = PARAMETERS.map(([name], column) => el("th", { scope: "col" }, el("button", { type: "button", class: "link", onclick: () => {
    way = by === column ? -way : 1;
    by = column;
    refresh();
  } }, name)));
  const made = el("input", { type: "checkbox", onchange: () => refresh() });
  const refresh = () => {
    heads.forEach((head, column) => (by === column ? head.setAttribute("aria-sort", way > 0 ? "ascending" : "descending") : head.removeAttribute("aria-sort")));
    const rows = [...model.parameters];
    if (by !== null) rows.sort((a, b) => { const [x, y] = [a, b].map(PARAMETERS[by][1]); return way * (x < y ? -1 : x > y ? 1 : 0); });
    fill(body, rows.map((one) => el("tr", { title: one.meaning, class: one.doubtful ? "doubtful" : "" }, PARAMETERS.map(([, , show], column) => el("td", {}, show(one),
      column === 0 && made.checked && one.meaning !== one.name ? el("small", {}, one.meaning) : null)))));
  };
  refresh();
  return [el("p", { class: "muted" }, "A motion shows sums of what links are made of, not each link: a mass here is the mass that is felt, with all that moves alike, and can be negative. ",
    el("label", {}, made, " show what each is made of")),
  el("div", { class: "scroll", tabIndex: 0, role: "region", "aria-label": "parameters" }, el("table", { class: "parameters" }, el("thead", {}, el("tr", {}, heads)), body)),
    el("p", { class: "muted" }, "Weak: the standard error is above 30 % of the value. Not determined: this motion leaves it open. Press a head to sort by it.")];
}
