// Any channel of any recording, against time or against another, over each other, with one cursor.
import { sayAddress } from "../base/address.js";
import { el, fill, say } from "../base/dom.js";
import { get } from "../base/api.js";
import { table } from "../base/columns.js";
import { state, watch } from "../base/store.js";
import { failed, guarded } from "../base/notices.js";
import { number, seconds, titled } from "../base/units.js";
import { Chart, ends } from "../parts/chart.js";
import { choices } from "../parts/choices.js";
import { cursors } from "../parts/cursors.js";
import { dropZone } from "../parts/drop.js";
import { leftOut } from "../parts/left_out.js";
import { empty } from "../parts/figure.js";
import { heading } from "../parts/guide.js";
import { replay } from "../parts/replay.js";
import { COLOURS } from "../parts/scope.js";

const POINTS = 1400, PAIRS = 4000, HEIGHT = 230, KEY = "explore"; // per channel; px
const DASHES = [undefined, [7, 4], [2, 3], [10, 3, 2, 3]]; // of one recording after the other
const FIRST = ["position", "torque measured"];
const plotOf = (group) => ({ group, over: [] }); // over: quantities that are laid over it
const view = { sources: new Set(), models: new Set(), joints: new Set([1]), shown: FIRST.map(plotOf), against: "time", span: null, spectrum: null };
let parts = null, faults = [], asked = 0;
const known = new Map(); // request of a catalogue -> the catalogue

export function mount(box) {
  const again = () => refresh().catch((error) => failed("It cannot be shown.", error));
  const recordings = choices("Recordings", sources, view.sources, () => { view.span = null; again(); });
  const models = choices("Models", () => state.models.filter((one) => !one.replaced).map((one) => ({ id: one.id, label: one.name, note: one.change })), view.models, again);
  const against = el("select", { "aria-label": "against", onchange: () => { view.against = against.value; again(); } }, el("option", { value: "time" }, "time"));
  const arm = replay();
  const tools = el("div", { class: "row" },
    ["Whole", "Zoom in", "Zoom out", "Earlier", "Later"].map((label) => el("button", { type: "button", class: "small", onclick: () => step(label) }, label)),
    el("button", { type: "button", class: "small", onclick: guarded("There is no spectrum.", () => spectrum(false)) }, "Spectrum"),
    el("button", { type: "button", class: "small", title: "against cycles per revolution of the joint", onclick: guarded("There is no order spectrum.", () => spectrum(true)) }, "Order spectrum"));
  parts = {
    recordings, models, against, arm, again, reading: el("p", { class: "muted", role: "status" }), joints: el("div", { class: "chips", role: "group", "aria-label": "joints shown" }),
    plots: el("div", {}), spectrum: el("div", {}), out: leftOut(() => view.span, () => [...view.sources].filter((one) => one.startsWith("run:")).map((one) => one.slice(4)), again),
    none: empty("Choose recordings above, or drop one here: every channel of it can be seen, against time or another, several over each other, with what models say of it."),
    work: el("div", { hidden: true }), charts: new Map(), marks: [null, null],
    cursors: cursors((marks) => { parts.marks = marks; for (const { chart } of parts.charts.values()) chart.mark(overTime() ? marks : []); }, zoom),
  };
  fill(parts.work, el("div", { class: "panel" }, tools, parts.reading, parts.out.box), el("div", { class: "beside wide-right" }, arm.box, parts.plots), parts.cursors.box, parts.spectrum);
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
  sayAddress("explore");
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
  if (source.startsWith("fault:")) Object.assign(view, { shown: ["position", "tracking error", "velocity", "torque commanded"].map(plotOf), joints: new Set() });
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
  const units = new Map(found.flatMap((one) => one.channels.map((channel) => [channel.group, channel.unit]))), groups = [...units.keys()];
  view.shown = view.shown.filter((one) => units.has(one.group));
  if (!view.shown.length) view.shown = [plotOf(groups[0])];
  for (const one of view.shown) one.over = one.over.filter((group) => units.has(group) && group !== one.group && units.get(group) === units.get(one.group));
  axes(found[0], groups);
  jointChips(found[0].joints);
  parts.out.refresh();
  const struck = chosen.map((source) => faults.find((one) => source === `fault:${one.id}`)?.sentence).filter(Boolean).map((sentence) => `At the end: ${sentence.replace(/\.$/, "")}. `);
  say(parts.reading, `${struck.join("")}${found.map((one) => `${one.name}: ${one.samples} samples, ${number(one.rate, 4)} Hz, ${seconds(one.seconds)}`).join("; ")}. ${view.span ? `Seen: ${view.span.map((at) => at.toFixed(2)).join(" to ")} s.` : "Drag over a plot to zoom all of them; double-click for the whole."}`);
  rows(groups, units);
  const drawn = await Promise.all(view.shown.map((one, k) => draw(one, parts.charts.get(k), chosen, found, mine)));
  if (mine !== asked) return;
  parts.cursors.show(drawn.flat().filter(Boolean));
  moveArm(chosen[0], found[0]); // plots first: on a slow link they share it
}

const overTime = () => view.against === "time";

/** What plots can be drawn over: time, a quantity of the same joint, one of a certain joint. */
function axes({ joints, channels }, groups) {
  const known = new Map(groups.map((group) => [group, group]));
  for (const one of channels) if (one.joint) known.set(`${one.group}/${one.joint}`, `${one.group} of ${one.joint} ${joints[one.joint - 1]}`);
  if (!known.has(view.against)) view.against = "time";
  const option = ([value, words]) => el("option", { value, selected: value === view.against }, words), all = [...known];
  fill(parts.against, option(["time", "time"]), el("optgroup", { label: "of the same joint" }, all.slice(0, groups.length).map(option)),
    el("optgroup", { label: "of one joint" }, all.slice(groups.length).map(option)));
}

/** The channel of a recording over which another one is drawn. */
function partner(channels, { joint }) {
  const [, group, certain] = /^(.*?)(?:\/(\d+))?$/.exec(view.against);
  return channels.find((x) => x.group === group && (certain ? x.joint === Number(certain) : x.joint === joint || x.joint === null));
}

/** One chart per plot, each with its own choice of quantities. */
function rows(groups, units) {
  const made = view.shown.map((shown, k) => {
    if (!parts.charts.has(k)) {
      const chart = new Chart(HEIGHT, { key: KEY, zoomed: zoom, pointed: (x) => { if (overTime()) parts.arm.point(x); }, clicked: (x, shift) => parts.cursors.set(shift ? 1 : 0, x) });
      chart.mark(parts.marks);
      const choice = el("select", { "aria-label": `quantity of plot ${k + 1}`, onchange: () => { view.shown[k] = plotOf(choice.value); parts.again(); } });
      const more = el("select", { "aria-label": `lay over plot ${k + 1}`, onchange: () => { view.shown[k].over.push(more.value); parts.again(); } });
      const away = el("button", { type: "button", class: "small quiet", "aria-label": `remove plot ${k + 1}`, onclick: () => { view.shown.splice(k, 1); parts.again(); } }, "×");
      parts.charts.set(k, { chart, choice, more, laid: el("span", {}), away, said: el("p", { class: "bad" }), box: el("figure", { class: "plot" }) });
      const one = parts.charts.get(k);
      fill(one.box, el("figcaption", {}, choice, one.laid, more, away), one.said, chart.box);
    }
    const one = parts.charts.get(k), alike = groups.filter((name) => name !== shown.group && !shown.over.includes(name) && units.get(name) === units.get(shown.group));
    fill(one.choice, groups.map((name) => el("option", { selected: name === shown.group }, name)));
    fill(one.more, el("option", { value: "" }, "lay over it …"), alike.map((name) => el("option", {}, name)));
    one.more.hidden = !alike.length;
    fill(one.laid, shown.over.map((name) => el("span", { class: "tag" }, `and ${name} `,
      el("button", { type: "button", class: "link", "aria-label": `${name} away from plot ${k + 1}`, onclick: () => { shown.over = shown.over.filter((other) => other !== name); parts.again(); one.choice.focus(); } }, "×"))));
    one.away.hidden = view.shown.length === 1;
    return one.box;
  });
  const more = el("button", { type: "button", class: "small", onclick: () => { view.shown.push(plotOf(groups.find((one) => !view.shown.some((other) => other.group === one)) ?? groups[0])); parts.again(); } }, "Add a plot");
  const children = [...made, more];
  if (parts.plots.children.length !== children.length || made.some((one, k) => parts.plots.children[k] !== one)) fill(parts.plots, children);
}

const wanted = (found, group) => found.channels.filter((one) => one.group === group && (one.joint === null || !view.joints.size || view.joints.has(one.joint)));
const color = (channel, k, more = 0) => COLOURS[((channel.joint ?? k + 1) - 1 + more) % COLOURS.length];

/** Of a recording: what each line is called and looks like; `place` counts recordings, `laid` quantities
    of all of them. Where there is one joint only, each line has a colour of its own. */
const styles = (channels, found, { several, place, laid, quantity }) => channels.map((one, k) => ({
  label: [one.joint ? `${one.joint} ${found.joints[one.joint - 1]}` : one.id, quantity, several && found.name].filter(Boolean).join(", "),
  color: color(one, k, channels.length === 1 ? laid + place : 0), dash: DASHES[(place + laid) % DASHES.length] }));

/** Draws a plot -> its lines as rows of the table. */
async function draw({ group, over }, { chart, said }, chosen, found, mine) {
  say(said, "");
  chart.box.dataset.waiting = mine;
  const pairs = !overTime(), several = chosen.length > 1, quantities = [group, ...over];
  try {
    const got = await Promise.all(chosen.map(async (source, place) => {
      const lines = quantities.flatMap((name, laid) => {
        const channels = wanted(found[place], name);
        return styles(channels, found[place], { several, place, laid: laid * chosen.length, quantity: over.length ? name : "" }).map((style, k) => ({ style, channel: channels[k], x: pairs ? partner(found[place].channels, channels[k]) : null }));
      });
      const channel = [...new Set(lines.flatMap((one) => [one.channel, one.x]).filter(Boolean).map((one) => one.id))];
      if (!channel.length) return null;
      const span = view.span ? { begin: view.span[0], end: view.span[1] } : {}, query = queryOf(source);
      const { columns } = await table("columns", { ...query, channel, ...span, points: pairs ? PAIRS : POINTS, every: pairs });
      return { query, columns, lines };
    }));
    if (mine !== asked) return [];
    const there = got.filter(Boolean);
    if (!there.length) { say(said, "None of the chosen recordings and joints has this."); return []; }
    const y = there[0].lines[0].channel.unit;
    if (!pairs) {
      await chart.lines({ tables: there.map((one) => [one.columns.time, ...one.lines.map(({ channel }) => one.columns[channel.id])]), series: there.flatMap((one) => one.lines.map(({ style }) => style)), x: "time, s", y, span: view.span, bands: parts.out.stretches() });
      chart.mark(parts.marks);
    } else {
      const lines = there.flatMap((one) => one.lines.filter(({ x }) => x).map(({ x, channel, style }) => ({ pair: [x, channel].map((c) => Array.from(one.columns[c.id])), style, unit: x.unit })));
      chart.mark([]);
      await chart.against({ pairs: lines.map(({ pair }) => pair), series: lines.map(({ style }) => style), x: [parts.against.selectedOptions[0].text, lines[0]?.unit].filter(Boolean).join(", "), y });
    }
    return there.flatMap((one) => one.lines.map(({ style, channel }) => {
      const [low, high] = ends(one.columns[channel.id]);
      return { label: `${over.length ? "" : `${group}: `}${style.label}`, query: one.query, channel: channel.id, low, high, unit: channel.unit };
    }));
  } catch (error) {
    if (mine === asked) say(said, error.message);
    return [];
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
  const { group } = view.shown.at(-1), chosen = [...view.sources];
  const found = await Promise.all(chosen.map(catalogue)), span = view.span ? { begin: view.span[0], end: view.span[1] } : {};
  const axis = orders ? "order" : "frequency", several = chosen.length > 1;
  const got = await Promise.all(chosen.map(async (source, s) => {
    const channels = wanted(found[s], group);
    const { columns } = await table("spectrum", { ...queryOf(source), channel: channels.map((one) => one.id), ...span, orders });
    return { columns, channels, series: styles(channels, found[s], { several, place: s, laid: 0, quantity: "" }) };
  }));
  const chart = new Chart(300), title = `${orders ? "Order spectrum" : "Spectrum"} of ${group}${view.span ? `, ${view.span.map((at) => at.toFixed(2)).join(" to ")} s` : ""}`;
  fill(parts.spectrum, el("figure", { class: "plot" }, el("figcaption", {}, title), chart.box, el("p", { class: "muted" }, orders
    ? "Amplitude of a sine at each order, in cycles per revolution of the joint. A line here stays where it is when the speed changes: gear, bearing, motor."
    : "Amplitude of a sine at each frequency. Drag to zoom, double-click for the whole.")));
  await chart.lines({ tables: got.map((one) => [one.columns[axis], ...one.channels.map((channel) => one.columns[channel.id])]), series: got.flatMap((one) => one.series),
                      x: orders ? "order, cycles per revolution" : "frequency, Hz", y: `amplitude, ${got[0].channels[0].unit}`, span: null });
  chart.box.scrollIntoView({ block: "nearest" });
}
