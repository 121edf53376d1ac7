// Which effect is missing? Findings as cards, with what to do about them.
import { sayAddress } from "../base/address.js";
import { el, fill } from "../base/dom.js";
import { get, post } from "../base/api.js";
import { running, whyNot } from "../base/condition.js";
import { current, loadModels, state, watch } from "../base/store.js";
import { failed, guarded, notice } from "../base/notices.js";
import { nextModelName, when } from "../base/units.js";
import { block, section as sectionOf } from "../parts/blocks.js";
import { empty } from "../parts/figure.js";
import { addedOf, heading, SETTLES, versionWith } from "../parts/guide.js";
import { armView } from "../parts/arm.js";
import { postSound } from "../parts/forced.js";
import { finished } from "../parts/jobs.js";
import { fittedTo, judgedBy, modelPicker, runPicker } from "../parts/picker.js";

let parts = null, shown = null;

export function mount(box) {
  const model = modelPicker("Model", () => { parts?.fit.refresh(); parts?.judge.refresh(); });
  const fit = runPicker("Fit to", "fit", undefined, () => fittedTo(model.value)), judge = runPicker("Judge by", "judge", undefined, () => judgedBy(model.value));
  const frozen = el("input", { type: "checkbox", id: "frozen" });
  const start = el("button", { class: "primary", type: "button", id: "diagnose-start", onclick: guarded("The diagnosis could not be started.", async () => {
    const job = await postSound("diagnoses", { model: model.value, fit: fit.ids, validate: judge.ids, frozen: frozen.checked });
    await open(job.id, job);
  }) }, "What is missing?");
  frozen.addEventListener("change", () => { start.textContent = frozen.checked ? "What has changed?" : "What is missing?"; });
  const earlier = el("select", { "aria-label": "earlier diagnoses", onchange: () => { if (earlier.value) location.hash = `#/diagnose/${earlier.value}`; } });
  parts = { model, fit, judge, earlier, body: el("div", { id: "findings" }) };
  fill(box, heading("diagnose", "Diagnose", { Diagnose: "Press 'What is missing?'.", Read: "It is below.", Settle: "The button is below." }),
    el("div", { class: "panel row pickers" }, model.box, fit.box, judge.box,
      el("label", { title: "Nothing is refitted: for an arm that was well described before" }, frozen, " what changed since?"), start, earlier),
    parts.body);
  fill(parts.body, empty("A model that was fitted is asked here which physical effect it lacks. Every effect of the library is tried on every joint and judged on runs that the fit has not seen."));
  watch(["models", "runs"], () => { start.disabled = !model.value || !fit.ids.length; });
  watch(["diagnoses"], () => {
    fill(earlier, el("option", { value: "" }, "earlier ones"), state.diagnoses.map((job) =>
      el("option", { value: job.id }, `${nameOfModel(job.request.model)}, ${when(job.created)}${job.status === "succeeded" ? "" : ` (${job.status})`}`)));
    earlier.hidden = !state.diagnoses.length;
    earlier.value = shown ?? "";
  });
}

/** The model that the guide spoke of, to be diagnosed now. */
function ofModel(model) {
  parts.model.value = model;
  parts.fit.ids = parts.judge.ids = shown = null;
  parts.earlier.value = "";
  fill(parts.body, empty(`Press 'What is missing?' to ask which physical effect ${model} lacks.`));
  sayAddress("diagnose");
}

/** #/diagnose/ID; without an id the newest one, running or done. */
export function show([id, model]) {
  if (id === "of") return ofModel(model);
  const wanted = id ?? shown ?? state.diagnoses.find((job) => ["succeeded", "running"].includes(job.status))?.id;
  if (wanted && wanted !== shown) open(wanted).catch((error) => failed("This diagnosis cannot be shown.", error));
}

async function open(id, started = null) {
  shown = id;
  parts.earlier.value = id;
  sayAddress("diagnose", id);
  fill(parts.body, el("p", { class: "muted pad" }, "Every effect of the library is being tried on every joint …"));
  const job = started ?? await get(`diagnoses/${id}`);
  if (shown !== id) return; // somebody has asked for another one meanwhile
  parts.model.value = nameOfModel(job.request.model);
  const ids = (runs) => runs.map((run) => state.runs.find((one) => [one.id, one.name].includes(run))?.id ?? run);
  parts.fit.ids = ids(job.request.fit);
  parts.judge.ids = ids(job.request.validate);
  let whole;
  try {
    whole = await finished(job);
  } catch (error) {
    if (shown === id) fill(parts.body, empty(error.message));
    return;
  }
  const sheet = await get(`diagnoses/${id}/sheet`).catch(() => null);
  if (shown !== id) return;
  if (!sheet) {
    fill(parts.body, empty("The plots of this diagnosis were not kept. Press 'What is missing?' to make it again."));
    return;
  }
  const [verdict, ...rest] = sheet.sections;
  fill(parts.body, el("p", { class: "muted", id: "asked" }, `Asked of ${nameOfModel(job.request.model)}, ${when(job.created)}.`), verdict.blocks.map(block), where(whole.result, sheet.findings.map((one) => one.title)),
    sheet.findings.map((finding, k) => card(finding, whole, k)),
    (sheet.unexplained ?? []).map((one, k) => unexplained(one, whole, k)), rest.map((one) => sectionOf(one)));
}

/** The joints that the findings are about, lit on the arm: all of them, or those of one. */
function where({ findings, unexplained }, titles) {
  const places = [...findings.map((one, k) => ({ title: titles[k], joints: one.joints })), ...unexplained.map((one) => ({ title: `Unexplained in joint ${one.joint}`, joints: [one.joint] }))];
  const joints = [...new Set(places.flatMap((one) => one.joints))];
  if (!joints.length) return null;
  const chips = el("div", { class: "chips pad", role: "group", "aria-label": "findings shown on the arm" }), view = armView("Where it is", chips);
  const light = (chosen) => {
    [...chips.children].forEach((chip, k) => chip.setAttribute("aria-pressed", String(k === chosen)));
    const lit = chosen ? places[chosen - 1].joints : joints, { title } = places[chosen - 1] ?? {};
    view.show({ q: state.pose ?? undefined, lit, words: `${title ?? (places.length > 1 ? "All findings" : places[0].title)}: ${lit.length ? `joint ${lit.join(", ")}` : "the whole arm"}.` });
  };
  fill(chips, ["all", ...places.map((one) => one.title)].map((title, k) => el("button", { type: "button", class: "chip", onclick: () => light(k) }, title)));
  chips.hidden = places.length < 2;
  light(0);
  return view.box;
}

const nameOfModel = (model) => state.models.find((one) => one.id === model || one.name === model)?.name ?? model;

/** One finding: what, where, how much, the evidence, doubts, and two buttons. */
function card(section, diagnosis, k) {
  const finding = diagnosis.result.findings[k];
  const [sentence, facts, evidence, ...more] = section.blocks;
  const inner = more.filter((one) => one.block !== "command");
  return el("article", { class: "finding", dataset: { effect: finding.effect } },
    el("header", {}, el("h2", {}, section.title), el("p", { class: "share" }, section.mark), actions(diagnosis, k)),
    block(sentence), block(facts), doubts(finding), block(evidence),
    el("details", {}, el("summary", {}, "Questions and answers, parameters, all joints"), inner.map(block)));
}

/** What no effect explains on a joint: its map, and a button that hides it. */
function unexplained(section, diagnosis, k) {
  const structure = diagnosis.result.unexplained[k];
  const box = el("div", { class: "row" });
  const remove = el("button", { type: "button", class: "smooth", title: "It explains nothing: no physical effect", onclick: guarded("It could not be removed.", () => removeByMap(diagnosis, k)) }, "Remove it by a smooth map");
  const done = el("a", { class: "button" });
  watch(["models", "jobs"], () => {
    const version = withMaps(diagnosis).removed.get(structure);
    done.hidden = !version;
    if (version) {
      done.textContent = `Removed in ${version.name}: see how far the error fell`;
      done.href = `#/models/${version.name}`;
    }
    remove.hidden = Boolean(version) || diagnosis.result.frozen || !structure.depends_on.length;
    remove.disabled = running("add").length > 0;
  }, box);
  fill(box, remove, done);
  return el("article", { class: "finding", dataset: { unexplained: structure.joint } },
    el("header", {}, el("h2", {}, section.title), el("p", { class: "share" }, section.mark), box), section.blocks.map(block));
}

function doubts(finding) {
  if (!finding.confounded_with.length) return el("p", { class: "good" }, "This data tells it from every other effect of the library.");
  return el("div", { class: "doubt" }, el("b", {}, "This data alone cannot tell it from: "),
    el("ul", {}, finding.confounded_with.map((one) => el("li", {},
      `${one.effect.replaceAll("_", " ")}${one.joints.length ? ` in joint ${one.joints.join(", ")}` : ""}: ${one.why}`))));
}

function actions(diagnosis, k) {
  const finding = diagnosis.result.findings[k];
  const box = el("div", { class: "row" });
  const settle = el("button", { type: "button", class: "settle", onclick: guarded("The experiment could not be started.", () => settleIt(finding)) }, "Run the experiment that settles it");
  const add = el("button", { type: "button", class: "primary add", onclick: guarded("It could not be added.", () => addTo(diagnosis, k)) }, "Add to model");
  const done = el("a", { class: "button" });
  watch(["models", "robot", "jobs", "condition"], () => {
    const version = madeFrom(diagnosis, k + 1);
    done.hidden = !version;
    if (version) {
      done.textContent = `Added as ${version.name}: see how far the error fell`;
      done.href = `#/models/${version.name}`;
    }
    add.hidden = Boolean(version) || diagnosis.result.frozen;
    add.disabled = running("add").length > 0;
    settle.hidden = !finding.next_experiment;
    const why = whyNot();
    settle.disabled = Boolean(why);
    settle.title = why || (finding.next_experiment?.kind ?? "");
  }, box);
  fill(box, add, done, settle);
  return box;
}

/** The version of the model with the first `count` findings in it; the model itself for none. */
const madeFrom = (diagnosis, count) => addedOf(diagnosis)[count];

/** Add it, and the findings before it: each was judged on top of those. */
async function addTo(diagnosis, k) {
  const { fit } = diagnosis.request;
  let made = null;
  for (let step = 0; step <= k; step += 1) {
    if (madeFrom(diagnosis, step + 1)) continue;
    const base = madeFrom(diagnosis, step), finding = diagnosis.result.findings[step];
    const name = nextModelName(current().map((model) => model.name));
    const job = await postSound(`models/${base.id}/effects`, { effect: finding.effect, joints: finding.joints, fit, name });
    made = (await finished(job)).result;
    await loadModels();
  }
  if (!made) return;
  notice(`${made.name}: ${made.change}.`, { known: made.warnings, action: { href: `#/models/${made.name}`, label: "See how far the error fell" } });
}

const mapOf = (structure) => ({ effect: `smooth_map J${structure.joint} over ${structure.depends_on.join(", ")}`, joints: [] });

/** The newest version with all findings and as many of the maps as there are: {model, removed: structure -> version}. */
function withMaps(diagnosis) {
  let model = madeFrom(diagnosis, diagnosis.result.findings.length);
  const removed = new Map();
  for (let next = model; next;) {
    next = null;
    for (const structure of diagnosis.result.unexplained.filter((one) => !removed.has(one))) {
      next = versionWith(model, mapOf(structure));
      if (!next) continue;
      removed.set(structure, model = next);
      break;
    }
  }
  return { model, removed };
}

/** A map on top of the findings, which it was seen beside. */
async function removeByMap(diagnosis, k) {
  const { findings, unexplained: places } = diagnosis.result;
  if (!madeFrom(diagnosis, findings.length)) await addTo(diagnosis, findings.length - 1);
  const { model } = withMaps(diagnosis), { joint, depends_on: over } = places[k];
  const name = nextModelName(current().map((one) => one.name));
  const { fit } = diagnosis.request;
  const made = (await finished(await postSound(`models/${model.id}/effects`, { effect: "smooth_map", joints: [joint], over, fit, name }))).result;
  await loadModels();
  notice(`${made.name}: ${made.change}.`, { known: made.warnings, action: { href: `#/models/${made.name}`, label: "See how far the error fell" } });
}

async function settleIt(finding) {
  const { kind, parameters } = finding.next_experiment;
  const job = await post("experiments", { kind, parameters, tags: SETTLES });
  notice("The arm moves.", { detail: "Its run will be marked 'fit' and 'judge' (it is then split by time): diagnose again when it is done." });
  finished(job).then(() => {
    parts.fit.ids = null;
    parts.judge.ids = null;
    notice("The experiment is recorded.", { detail: "Press 'What is missing?' again: the answer now has this run, too." });
  }, (error) => failed("The experiment did not end well.", error));
}
