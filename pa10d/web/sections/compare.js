// Where does a model fail? Measured over model per joint, sentences that jump to the place, plots.
import { sayAddress } from "../base/address.js";
import { el, fill } from "../base/dom.js";
import { get } from "../base/api.js";
import { state, watch } from "../base/store.js";
import { failed, guarded } from "../base/notices.js";
import { fixed } from "../base/units.js";
import { block, section as sectionOf } from "../parts/blocks.js";
import { card, empty, words, Zoomable } from "../parts/figure.js";
import { heading } from "../parts/guide.js";
import { tabsByKeys } from "../parts/tabs.js";
import { replay } from "../parts/replay.js";
import { postSound } from "../parts/forced.js";
import { finished } from "../parts/jobs.js";
import { modelPicker, nameOf, runPicker } from "../parts/picker.js";

const view = { id: null, model: "", runs: [], run: "", joint: 1, chosen: false, raw: false, result: null, place: null };
let parts = null, prepared = "", asked = 0;

export function mount(box) {
  const model = modelPicker("Model", () => prepare()), runs = runPicker("Runs", "judge", () => prepare());
  const start = el("button", { class: "primary", type: "button", id: "compare-start", onclick: guarded("It could not be compared.", () => compare(model.value, runs.ids)) }, "Compare");
  parts = {
    model, runs, box, summary: el("div", {}), since: el("div", {}), sentences: el("div", {}), joints: tabsByKeys(el("div", { class: "joints", role: "tablist", "aria-label": "joints" })),
    time: el("div", {}), arm: replay(), maps: el("div", {}), tail: el("div", {}), work: el("div", { hidden: true }),
    none: empty("Choose a model and the runs to judge it by: runs that it was not fitted to, of other motions. Then press Compare."),
  };
  fill(parts.work, el("div", { class: "compare" }, el("div", {}, el("h2", {}, "Where it fails"), parts.since, parts.sentences), parts.summary),
    parts.joints, el("div", { class: "beside" }, parts.arm.box, parts.time), parts.maps, parts.tail);
  fill(box, heading("compare", "Compare", { Compare: "Press Compare." }), el("div", { class: "panel row pickers" }, model.box, runs.box, start),
    parts.none, parts.work);
  parts.zoom = new Zoomable(430, loadTorque, (time) => parts.arm.point(time));
  watch(["models", "runs"], () => { start.disabled = !model.value || !runs.ids.length; });
  prepare();
}

/** Have the daemon read what is chosen before somebody asks to see it. */
function prepare() {
  const model = parts?.model.value, run = parts?.runs.ids[0], pair = `${model}/${run}`;
  if (!model || !run || pair === prepared || parts.box.hidden) return;
  prepared = pair;
  get("plots/torque", { model, run, joint: view.joint }).catch(() => {}); // asked again on 'Compare', with its error
}

/** The model that the guide spoke of, to be compared now. */
function ofModel(model) {
  parts.model.value = model;
  view.id = null;
  parts.work.hidden = true;
  parts.none.hidden = false;
  sayAddress("compare");
  prepare();
}

/** #/compare/ID/joint opens a comparison that was made before; #/compare/of/MODEL makes ready for one. */
export function show([id, joint]) {
  if (id === "of") return ofModel(joint);
  prepare();
  if (id && id !== view.id) open(id, Number(joint) || null).catch((error) => failed("This comparison cannot be shown.", error));
  else if (!id && !view.id && made()) open(made().id, null).catch((error) => failed("This comparison cannot be shown.", error));
  else if (!id && view.id) sayAddress("compare", view.id, view.joint);
}

/** The newest comparison of the model that is chosen: whoever comes back finds what was there. */
const made = () => parts.none.hidden ? null : state.comparisons.find((one) => one.status === "succeeded"
  && nameOfModel(one.request.model) === parts.model.value);

async function compare(model, runs) {
  asked += 1; // what was being opened by itself gives way
  begin(model, runs);
  drawTime(); // the first plot needs no more than the model and one run
  const job = await postSound("comparisons", { model, runs });
  await open(job.id, null, job);
}

function begin(model, runs) {
  Object.assign(view, { id: null, model, runs, run: runs[0], chosen: false, result: null, place: null });
  parts.work.hidden = false;
  parts.none.hidden = true;
  fill(parts.sentences, el("p", { class: "muted" }, "Looking for where the error piles up …"));
  fill(parts.since);
  fill(parts.summary);
  fill(parts.maps);
  fill(parts.tail);
  tabs();
  frame();
}

async function open(id, joint, started = null) {
  const mine = started ? asked : asked += 1;
  const job = started ?? await get(`comparisons/${id}`);
  if (mine !== asked) return; // somebody has asked for another one meanwhile
  if (!started) {
    begin(job.request.model, job.request.runs);
    if (joint) Object.assign(view, { joint, chosen: true });
    tabs();
    drawTime();
  }
  view.id = id;
  parts.model.value = nameOfModel(view.model);
  parts.runs.ids = job.request.runs.map((run) => state.runs.find((one) => [one.id, one.name].includes(run))?.id ?? run);
  sayAddress("compare", id, view.joint);
  let whole;
  try {
    whole = await finished(job);
  } catch (error) {
    fill(parts.sentences, el("p", { class: error.wished ? "muted" : "bad" }, error.message));
    return;
  }
  if (view.id !== id) return;
  Object.assign(view, { result: whole.result, created: whole.created });
  if (view.chosen || parts.zoom.span) tabs(); // somebody is looking at something: it stays
  else choose(worst());
  sentences();
  const sheet = await get(`comparisons/${id}/sheet`).catch(() => null);
  if (!sheet || view.id !== id) return;
  const [glance, ...rest] = sheet.sections;
  fill(parts.summary, glance.blocks.map(block));
  fill(parts.tail, rest.map((one) => sectionOf(one)));
  drawMaps();
}

const nameOfModel = (model) => state.models.find((one) => one.id === model || one.name === model)?.name ?? model;
const idOfModel = (model) => state.models.find((one) => one.id === model || one.name === model)?.id ?? model;
/** Error over noise; NaN where the noise is not known from these runs. */
const ratios = () => view.result.pooled.rms.map((rms, j) => rms / (view.result.pooled.noise_floor[j] ?? NaN));
const known = () => ratios().some(Number.isFinite);
/** What joints are ranked by: the noise, or where that is known of none the range of the torque. */
const standing = () => known() ? ratios() : view.result.pooled.nrmse;
const worst = () => standing().reduce((best, size, j, all) => (size > (all[best] || 0) ? j : best), 0) + 1;
const standingOf = (size) => !Number.isFinite(size) ? "noise not known" : known() ? `${fixed(size, 1)} × noise` : `${fixed(100 * size, 1)} % of its range`;

function choose(joint) {
  const changed = joint !== view.joint;
  view.joint = joint;
  view.place = null;
  tabs();
  if (view.id) sayAddress("compare", view.id, joint);
  if (!changed) return;
  drawTime(parts.zoom.span); // the same seconds of another joint
  drawMaps();
}

function tabs() {
  const names = view.result?.joint_names ?? state.models.find((one) => one.name === nameOfModel(view.model))?.joints ?? [];
  const sizes = view.result ? standing() : [];
  fill(parts.joints, names.map((name, j) => el("button", {
    type: "button", role: "tab", "aria-selected": String(j + 1 === view.joint), onclick: () => { view.chosen = true; choose(j + 1); }, dataset: { joint: j + 1 },
    class: sizes.length && known() && sizes[j] > 1.5 ? "high" : "",
  }, `${j + 1} ${name}`, el("small", {}, sizes.length ? standingOf(sizes[j]) : "…"))));
}

function frame() {
  const run = el("select", { "aria-label": "run", onchange: () => { view.run = run.value; drawTime(); } },
    view.runs.map((one) => el("option", { value: one }, nameOf(one))));
  const raw = el("input", { type: "checkbox", checked: view.raw, onchange: () => { view.raw = raw.checked; drawTime(parts.zoom.span); } });
  parts.reading = el("div", {});
  fill(parts.time, card("Measured, modelled, and what is between them",
    el("span", { class: "row" }, el("a", { class: "button small", href: `#/explore/run:${view.run}/${idOfModel(view.model)}` }, "Explore"), el("label", {}, raw, " every sample, unfiltered"), run),
    el("div", {}, parts.zoom.box, parts.reading), null));
}

const loadTorque = (span) => get("plots/torque", {
  model: view.model, run: view.run, joint: view.joint, raw: view.raw, ...span,
  ...(view.place ? { variable: view.place.variable, low: view.place.range[0], high: view.place.range[1] } : {}),
});

async function drawTime(span = null) {
  moveArm();
  const found = await parts.zoom.show(span);
  if (found && !parts.reading.firstChild) fill(parts.reading, words(found));
  return found;
}

/** The arm goes through the run that is looked at; the joint that is looked at is lit. */
function moveArm() {
  parts.arm.light([view.joint]);
  if (view.run === view.played) return;
  view.played = view.run;
  const joints = state.runs.find((one) => [one.id, one.name].includes(view.run))?.joints.length ?? 0;
  parts.arm.open({ run: view.run }, nameOf(view.run), joints).catch(() => { view.played = null; });
}

async function drawMaps() {
  if (!view.id || !view.result) return;
  const { id, joint } = view;
  const sheet = await get(`comparisons/${id}/sheet`, { joint });
  if (view.id !== id || view.joint !== joint) return;
  const plots = sheet.sections[0].blocks.filter((one) => one.block === "plot");
  fill(parts.maps, plots.map(block));
}

/** Versions that came after this comparison: noise is seen through the best of all. */
function since() {
  const first = (model) => { const parent = state.models.find((one) => one.id === model?.parent); return parent ? first(parent) : model?.id; };
  const mine = first(state.models.find((one) => [one.id, one.name].includes(view.model)));
  const later = state.models.filter((one) => one.created > view.created && mine && first(one) === mine).map((one) => one.name);
  fill(parts.since, later.length ? el("p", { class: "note" }, `${later.join(", ")} came after this comparison, and the noise may be seen more clearly through ${later.length > 1 ? "them" : "it"}. `,
    el("button", { type: "button", class: "small", onclick: guarded("It could not be compared.", () => compare(view.model, view.runs)) }, "Compare again")) : []);
}

function sentences() {
  since();
  const where = view.result.where, spread = view.result.pooled.spread ?? [];
  if (!where.length && !spread.length) {
    fill(parts.sentences, el("p", {}, "No region and no dependence stands out: what is left looks like noise."));
    return;
  }
  fill(parts.sentences, el("ol", { class: "ranked" }, where.map((place) => el("li", {},
    el("button", { type: "button", class: "link sentence", title: "Show the place", onclick: guarded("It cannot be shown.", () => jump(place)) }, place.sentence))), spread.map((text) => el("li", {}, text))));
}

/** Show where it is: the panel of the quantity, and the stretch of time in red. */
async function jump(place) {
  choose(place.joint);
  const region = place.kind === "region" && place.variable !== "constant";
  view.place = region ? place : null;
  const found = await drawTime();
  if (found?.jump) await drawTime(found.jump);
  await drawMaps();
  const canvas = parts.maps.querySelector(".canvas");
  await canvas?.drawNow?.();
  if (region && place.variable !== "time") highlight(canvas, place);
  (region ? parts.joints : parts.maps).scrollIntoView({ behavior: "smooth", block: "start" });
}

function highlight(canvas, place) {
  const panels = canvas.layout.meta?.panels ?? {};
  const axis = panels[place.variable] ?? panels[place.variable.replaceAll("|", "")];
  if (!axis) return;
  const y = axis.replace("xaxis", "y"), x = axis.replace("xaxis", "x");
  const frameOf = { type: "rect", xref: `${x} domain`, yref: `${y} domain`, x0: 0, x1: 1, y0: 0, y1: 1, line: { color: "#d8475c", width: 2 } };
  Plotly.relayout(canvas, { shapes: [...canvas.layout.shapes, frameOf] });
}
