// Any channel of any recording, against time or against another, over each other, with one cursor.
import { el, fill, say } from "../base/dom.js";
import { get } from "../base/api.js";
import { table } from "../base/columns.js";
import { state, watch } from "../base/store.js";
import { failed, guarded } from "../base/notices.js";
import { number, seconds, titled } from "../base/units.js";
import { Chart } from "../parts/chart.js";
import { choices } from "../parts/choices.js";
import { dropZone } from "../parts/drop.js";
import { leftOut } from "../parts/left_out.js";
import { empty } from "../parts/figure.js";
import { heading } from "../parts/guide.js";
import { replay } from "../parts/replay.js";
import { COLOURS } from "../parts/scope.js";

const POINTS = 1400, PAIRS = 4000, HEIGHT = 230, KEY = "explore"; // per channel; px
const DASHES = [undefined, [7, 4], [2, 3], [10, 3, 2, 3]]; // of one recording after the other
const FIRST = ["position", "torque measured"];
const view = { sources: new Set(), models: new Set(), joints: new Set([1]), shown: [...FIRST], against: "time", span: null, spectrum: null };
let parts = null, faults = [], asked = 0;
const known = new Map(); // request of a catalogue -> the catalogue

export function mount(box) {
  const again = () => refresh().catch((error) => failed("It cannot be shown.", error));
  const recordings = choices("Recordings", sources, view.sources, () => { view.span = null; again(); });
  const models = choices("Models", () => state.models.filter((one) => !one.replaced).map((one) => ({ id: one.id, label: one.name, note: one.change })), view.models, again);
  const against = el("select", { "aria-label": "against", onchange: () => { view.against = against.value; again(); } });
  const arm = replay();
  const tools = el("div", { class: "row" },
    ["Whole", "Zoom in", "Zoom out", "Earlier", "Later"].map((label) => el("button", { type: "button", class: "small", onclick: () => step(label) }, label)),
    el("button", { type: "button", class: "small", onclick: guarded("There is no spectrum.", () => spectrum(false)) }, "Spectrum"),
    el("button", { type: "button", class: "small", title: "against cycles per revolution of the joint", onclick: guarded("There is no order spectrum.", () => spectrum(true)) }, "Order spectrum"));
  parts = {
    recordings, models, against, arm, again, reading: el("p", { class: "muted", role: "status" }), joints: el("div", { class: "chips", role: "group", "aria-label": "joints shown" }),
    plots: el("div", {}), spectrum: el("div", {}), out: leftOut(() => view.span, () => [...view.sources].filter((one) => one.startsWith("run:")).map((one) => one.slice(4)), again),
    none: empty("Choose recordings above, or drop one here: every channel of it can be seen, against time or another, several over each other, with what models say of it."),
    work: el("div", { hidden: true }), charts: new Map(),
  };
  fill(parts.work, el("div", { class: "panel" }, tools, parts.reading, parts.out.box), el("div", { class: "beside wide-right" }, arm.box, parts.plots), parts.spectrum);
  fill(box, heading("explore", "Explore"), dropZone("explore-files", (run) => open(`run:${run.id}`)),
    el("div", { class: "panel row pickers" }, recordings.box, models.box, el("label", { class: "picker" }, el("span", {}, "Against"), against), parts.joints),
    parts.none, parts.work);
  watch(["runs", "models"], () => { recordings.refresh(); models.refresh(); });
  get("faults").then((found) => { faults = found.items; recordings.refresh(); }).catch(() => {});
}

const sources = () => [
  ...state.runs.map((run) => ({ id: `run:${run.id}`, label: run.name, note: [run.kind && titled(run.kind), seconds(run.duration)].filter(Boolean).join(", ") })),
  ...faults.map((one) => ({ id: `fault:${one.id}`, label: `fault ${one.id}`, note: one.sentence.slice(0, 60) })),
];

/** #/explore/run:ID/MODEL, #/explore/fault:ID; #/explore/fault is the last one. */
export function show([subject, model]) {
  if (!subject) { if (parts.recordings) parts.again(); return; }
  history.replaceState(null, "", "#/explore");
  if (model) view.models = swapped(view.models, [model]);
  if (subject !== "fault") return open(subject);
  get("faults").then((found) => {
    faults = found.items;
    if (faults.length) open(`fault:${faults[0].id}`);
    else failed("There is nothing to show.", new Error("No fault was kept."));
  }).catch((error) => failed("The faults cannot be listed.", error));
}

function open(source) {
  swapped(view.sources, [source]);
  view.span = null;
  if (source.startsWith("fault:")) Object.assign(view, { shown: ["position", "tracking error", "velocity", "torque commanded"], joints: new Set() });
  parts.recordings.refresh();
  parts.models.refresh();
  parts.again();
}

const swapped = (set, items) => { set.clear(); for (const one of items) set.add(one); return set; };
const queryOf = (source) => source.startsWith("run:") ? { run: source.slice(4), model: [...view.models] } : { fault: source.slice(6) };

async function catalogue(source) {
  const query = queryOf(source), key = JSON.stringify(query);
  if (!known.has(key)) known.set(key, await get("channels", query));
  return known.get(key);
}

async function refresh() {
  const mine = ++asked, chosen = [...view.sources];
  parts.none.hidden = chosen.length > 0;
  parts.work.hidden = !chosen.length;
  parts.joints.hidden = !chosen.length;
  if (!chosen.length) return;
  const found = await Promise.all(chosen.map(catalogue));
  if (mine !== asked) return;
  const groups = [...new Set(found.flatMap((one) => one.channels.map((channel) => channel.group)))];
  view.shown = view.shown.filter((one) => groups.includes(one));
  if (!view.shown.length) view.shown = [groups[0]];
  if (view.against !== "time" && !groups.includes(view.against)) view.against = "time";
  fill(parts.against, ["time", ...groups].map((one) => el("option", { selected: one === view.against }, one)));
  jointChips(found[0].joints);
  parts.out.refresh();
  say(parts.reading, `${found.map((one) => `${one.name}: ${one.samples} samples, ${number(one.rate, 4)} Hz, ${seconds(one.seconds)}`).join("; ")}. ${view.span ? `Seen: ${view.span.map((at) => at.toFixed(2)).join(" to ")} s.` : "Drag over a plot to zoom all of them; double-click for the whole."}`);
  rows(groups);
  await Promise.all(view.shown.map((group, k) => draw(group, parts.charts.get(k), chosen, found, mine)));
  if (mine === asked) moveArm(chosen[0], found[0]); // plots first: on a slow link they share it
}

/** One chart per quantity, each with its own choice. */
function rows(groups) {
  const made = view.shown.map((group, k) => {
    if (!parts.charts.has(k)) {
      const chart = new Chart(HEIGHT, { key: KEY, zoomed: zoom, pointed: (x) => { if (view.against === "time") parts.arm.point(x); } });
      const choice = el("select", { "aria-label": `quantity of plot ${k + 1}`, onchange: () => { view.shown[k] = choice.value; parts.again(); } });
      const away = el("button", { type: "button", class: "small quiet", "aria-label": `remove plot ${k + 1}`, onclick: () => { view.shown.splice(k, 1); parts.again(); } }, "×");
      parts.charts.set(k, { chart, choice, away, said: el("p", { class: "bad" }), box: el("figure", { class: "plot" }) });
      const one = parts.charts.get(k);
      fill(one.box, el("figcaption", {}, choice, away), one.said, chart.box);
    }
    const one = parts.charts.get(k);
    fill(one.choice, groups.map((name) => el("option", { selected: name === group }, name)));
    one.away.hidden = view.shown.length === 1;
    return one.box;
  });
  const more = el("button", { type: "button", class: "small", onclick: () => { view.shown.push(groups.find((one) => !view.shown.includes(one)) ?? groups[0]); parts.again(); } }, "Add a plot");
  const children = [...made, more];
  if (parts.plots.children.length !== children.length || made.some((one, k) => parts.plots.children[k] !== one)) fill(parts.plots, children);
}

const wanted = (found, group) => found.channels.filter((one) => one.group === group && (one.joint === null || !view.joints.size || view.joints.has(one.joint)));
const color = (channel, k) => COLOURS[((channel.joint ?? k + 1) - 1) % COLOURS.length];

async function draw(group, { chart, said }, chosen, found, mine) {
  say(said, "");
  chart.box.dataset.waiting = mine;
  const pairs = view.against !== "time", several = chosen.length > 1;
  try {
    const got = await Promise.all(chosen.map(async (source, s) => {
      const channels = wanted(found[s], group), over = pairs ? channels.map((one) => found[s].channels.find((x) => x.group === view.against && (x.joint === one.joint || x.joint === null))) : [];
      const channel = [...new Set([...channels, ...over].filter(Boolean).map((one) => one.id))];
      if (!channel.length) return null;
      const span = view.span ? { begin: view.span[0], end: view.span[1] } : {};
      const { columns } = await table("columns", { ...queryOf(source), channel, ...span, points: pairs ? PAIRS : POINTS, every: pairs });
      const series = channels.map((one, k) => ({ label: `${one.joint ? `${one.joint} ${found[s].joints[one.joint - 1]}` : one.id}${several ? `, ${found[s].name}` : ""}`, color: color(one, k), dash: DASHES[s % DASHES.length] }));
      return { columns, series, channels, over };
    }));
    if (mine !== asked) return;
    const there = got.filter(Boolean);
    if (!there.length) return say(said, "None of the chosen recordings and joints has this.");
    const series = there.flatMap((one) => one.series), y = there[0].channels[0].unit;
    if (!pairs) {
      await chart.lines({ tables: there.map((one) => [one.columns.time, ...one.channels.map((channel) => one.columns[channel.id])]), series, x: "time, s", y, span: view.span, bands: parts.out.stretches() });
    } else {
      const lines = there.flatMap((one) => one.channels.map((channel, k) => one.over[k] && [Array.from(one.columns[one.over[k].id]), Array.from(one.columns[channel.id])]));
      const x = there[0].over.find(Boolean);
      await chart.against({ pairs: lines.filter(Boolean), series: series.filter((_, k) => lines[k]), x: `${view.against}${x?.unit ? `, ${x.unit}` : ""}`, y });
    }
  } catch (error) {
    if (mine === asked) say(said, error.message);
  } finally {
    if (mine === asked) delete chart.box.dataset.waiting;
  }
}

function moveArm(source, found) {
  parts.arm.light([...view.joints]);
  if (parts.played === source) return;
  parts.played = source;
  parts.arm.open(queryOf(source), found.name, found.joints.length).catch(() => { parts.played = null; });
}

function zoom(span) {
  view.span = span;
  parts.again();
}

function step(label) {
  const whole = Math.max(...[...view.sources].map((source) => known.get(JSON.stringify(queryOf(source)))?.seconds ?? 1));
  const [begin, end] = view.span ?? [0, whole], length = end - begin, middle = (begin + end) / 2;
  const next = { Whole: null, "Zoom in": [middle - length / 4, middle + length / 4], "Zoom out": [middle - length, middle + length],
                 Earlier: [begin - length / 2, end - length / 2], Later: [begin + length / 2, end + length / 2] }[label];
  zoom(next && next[1] - next[0] < whole ? next : null);
}

function jointChips(names) {
  const chips = names.map((name, j) => {
    const chip = el("button", { type: "button", class: "chip", "aria-pressed": String(!view.joints.size || view.joints.has(j + 1)), onclick: () => {
      if (!view.joints.size) names.forEach((_, k) => view.joints.add(k + 1));
      if (view.joints.has(j + 1)) view.joints.delete(j + 1);
      else view.joints.add(j + 1);
      parts.again();
    } }, el("i", {}), `${j + 1} ${name}`);
    chip.style.setProperty("--chip", COLOURS[j % COLOURS.length]);
    return chip;
  });
  const all = el("button", { type: "button", class: "chip", onclick: () => { view.joints = new Set(names.map((_, j) => j + 1)); parts.again(); } }, "all");
  fill(parts.joints, all, chips);
}

/** Of the last plot's quantity, in the stretch that is seen. */
async function spectrum(orders) {
  const group = view.shown.at(-1), chosen = [...view.sources];
  const found = await Promise.all(chosen.map(catalogue)), span = view.span ? { begin: view.span[0], end: view.span[1] } : {};
  const axis = orders ? "order" : "frequency", several = chosen.length > 1;
  const got = await Promise.all(chosen.map(async (source, s) => {
    const channels = wanted(found[s], group);
    const { columns } = await table("spectrum", { ...queryOf(source), channel: channels.map((one) => one.id), ...span, orders });
    return { columns, channels, series: channels.map((one, k) => ({ label: `${one.joint ?? one.id}${several ? `, ${found[s].name}` : ""}`, color: color(one, k), dash: DASHES[s % DASHES.length] })) };
  }));
  const chart = new Chart(300), title = `${orders ? "Order spectrum" : "Spectrum"} of ${group}${view.span ? `, ${view.span.map((at) => at.toFixed(2)).join(" to ")} s` : ""}`;
  fill(parts.spectrum, el("figure", { class: "plot" }, el("figcaption", {}, title), chart.box, el("p", { class: "muted" }, orders
    ? "Amplitude of a sine at each order, in cycles per revolution of the joint. A line here stays where it is when the speed changes: gear, bearing, motor."
    : "Amplitude of a sine at each frequency. Drag to zoom, double-click for the whole.")));
  await chart.lines({ tables: got.map((one) => [one.columns[axis], ...one.channels.map((channel) => one.columns[channel.id])]), series: got.flatMap((one) => one.series),
                      x: orders ? "order, cycles per revolution" : "frequency, Hz", y: `amplitude, ${got[0].channels[0].unit}`, span: null });
  chart.box.scrollIntoView({ block: "nearest" });
}
