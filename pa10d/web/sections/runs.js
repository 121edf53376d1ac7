// Recordings: bring in, look, mark what they are for, take out.
import { sayAddress } from "../base/address.js";
import { el, fill, refill } from "../base/dom.js";
import { download, get, patch, remove } from "../base/api.js";
import { loadRuns, state, watch } from "../base/store.js";
import { failed, guarded, notice } from "../base/notices.js";
import { number, seconds, titled, when } from "../base/units.js";
import { ask } from "../parts/dialog.js";
import { dropZone } from "../parts/drop.js";
import { findingsList } from "../parts/preview.js";
import { card, empty, Zoomable } from "../parts/figure.js";
import { replay } from "../parts/replay.js";
import { setAside } from "../parts/set_aside.js";
import { heading } from "../parts/guide.js";

const MARKS = ["fit", "judge"], RECORDING = "started";
let selected = null, filter = "", shownAs = "";
let showRun = () => {};

export function mount(box) {
  const body = el("tbody", {}), detail = el("div", { id: "run-detail" });
  const search = el("input", { type: "search", placeholder: "filter by name, kind or tag", "aria-label": "filter runs", oninput: () => { filter = search.value.toLowerCase(); refresh(); } });
  const none = el("div", {});
  const table = el("div", { class: "scroll", tabIndex: 0, role: "region", "aria-label": "list of runs" }, el("table", { class: "list" }, el("thead", {}, el("tr", {},
    ["run", "kind", "recorded", "length", "status", "fit", "judge"].map((head) => el("th", { scope: "col" }, head)))), body));
  const refresh = () => {
    const shown = state.runs.filter((run) => [run.name, run.kind, ...run.tags].join(" ").toLowerCase().includes(filter));
    refill(body, shown.map((run) => row(run, run.id === selected, select)));
    fill(none, state.ready && !state.runs.length ? empty("There are no runs yet. Drop a recording above, or let the arm move.", { href: "#/experiments", label: "Experiments" }) : null);
    table.hidden = !state.runs.length;
    search.hidden = state.runs.length < 6;
  };
  const fillDetail = (run) => {
    shownAs = run.status;
    fill(detail, run.status === RECORDING ? beingRecorded(run) : details(run));
  };
  const select = (run) => {
    selected = run.id;
    sayAddress("runs", run.id);
    refresh();
    fillDetail(run);
    detail.scrollIntoView({ block: "start" }); // below a long list nobody would see that it came
  };
  const shownIfThere = (id) => {
    const run = state.runs.find((one) => one.id === id || one.name === id);
    if (run && run.id !== selected) select(run);
    return run;
  };
  showRun = async (id) => {
    if (shownIfThere(id)) return;
    try {
      const { id: found } = await get(`runs/${encodeURIComponent(id)}`); // it may have come since
      await loadRuns();
      shownIfThere(found);
    } catch (error) {
      sayAddress("runs", ...(selected ? [selected] : []));
      failed("This run cannot be shown.", error);
    }
  };
  fill(box, heading("runs", "Runs", { Mark: "Tick the boxes in the list.", Import: "Drop the files below." }), dropZone("files"), search, table, none, setAside("runs"), detail);
  watch(["runs", "ready"], () => {
    refresh();
    const run = state.runs.find((one) => one.id === selected);
    if (selected && !run) { selected = null; fill(detail); }
    else if (run && run.status !== shownAs) fillDetail(run); // it has ended
  });
}

export function show([id]) {
  if (!id) return;
  watchOnce(() => showRun(id));
}

const watchOnce = (f) => {
  let done = false;
  watch(["runs", "ready"], () => { if (!done && state.ready) { done = true; setTimeout(f); } });
};

function row(run, isSelected, select) {
  const marks = MARKS.map((tag) => el("td", { class: "mark" }, el("input", {
    type: "checkbox", checked: run.tags.includes(tag), "aria-label": `${run.name}: ${tag}`, dataset: { tag, run: run.name },
    onclick: (event) => event.stopPropagation(),
    onchange: guarded("The mark could not be changed.", async (event) => {
      const tags = run.tags.filter((one) => one !== tag);
      if (event.target.checked) tags.push(tag);
      await patch(`runs/${run.id}`, { tags });
      await loadRuns();
    }),
  })));
  const other = run.tags.filter((tag) => !MARKS.includes(tag));
  return el("tr", { class: isSelected ? "selected" : "", onclick: () => select(run) },
    el("td", {}, el("button", { type: "button", class: "link", onclick: (event) => { event.stopPropagation(); select(run); } }, run.name),
      other.map((tag) => el("span", { class: "tag" }, tag)), wrong(run)),
    el("td", {}, run.kind ? titled(run.kind) : "–"), el("td", {}, when(run.created)), el("td", {}, run.status === RECORDING ? "…" : seconds(run.duration)),
    el("td", { class: { success: "", [RECORDING]: "warn" }[run.status] ?? "bad", title: run.reason }, run.status === RECORDING ? "being recorded" : run.status), marks);
}

/** What keeps a fit from using it. */
function wrong(run) {
  const errors = (run.findings ?? []).filter((one) => one.severity === "error");
  if (!errors.length) return null;
  const codes = [...new Set(errors.map((one) => one.code))].map((code) => {
    const joints = errors.filter((one) => one.code === code && one.joint).map((one) => one.joint);
    return `${code.replaceAll("_", " ")}${joints.length ? ` (joint${joints.length > 1 ? "s" : ""} ${joints.join(", ")})` : ""}`;
  });
  return el("span", { class: "tag bad", title: errors.map((one) => one.sentence).join("; ") }, `not for a fit: ${codes.join(", ")}`);
}

/** What to know before fitting: what was kept when it came in, and the whole on demand. */
function known(run) {
  const box = el("div", {});
  const look = el("button", { type: "button", class: "small", onclick: guarded("It could not be checked.", async () => {
    say("Looking at units, signs, delay and motion …");
    try {
      const { items } = await get(`runs/${run.id}/check`);
      show(items);
    } finally { say(""); }
  }) }, "Check it now");
  const status = el("span", { class: "muted", role: "status" });
  const say = (text) => { status.textContent = text; };
  const show = (findings) => {
    const others = run.warnings.filter((text) => !findings.some((one) => text.includes(one.sentence))).map((sentence) => ({ severity: "warning", sentence, advice: "" }));
    fill(box, findingsList([...findings, ...others]) ?? el("p", { class: "muted" }, run.findings ? "Nothing stood against a fit when it came in." : "Not looked at yet."));
  };
  show(run.findings ?? []);
  return el("div", { class: "known" }, el("div", { class: "row" }, el("h2", {}, "Before fitting"), look, status), box);
}

/** Nothing of it can be shown, taken out or deleted before it has ended; a name stays. */
function beingRecorded(run) {
  return el("div", { class: "panel" }, el("h2", {}, run.name),
    el("p", {}, "It is being recorded. Once it has ended, it is shown here. ", el("a", { class: "button small", href: "#/robot" }, "Watch the arm")));
}

function details(run) {
  const arm = replay("The arm in this run");
  let start = 0;
  const plot = new Zoomable(400, async (span) => {
    const found = await get("plots/run", { run: run.id, ...span });
    if (!span.begin) start = found.figure.data[0].x0;
    return found;
  }, (time) => arm.point(time - start));
  arm.open({ run: run.id }, run.name, run.joints.length).catch((error) => { if (selected === run.id) failed("The arm cannot follow this run.", error); });
  plot.show();
  const name = el("input", { value: run.name, "aria-label": "name of the run" });
  const rename = el("button", { type: "button", class: "small", onclick: guarded("It keeps its name.", async () => {
    await patch(`runs/${run.id}`, { name: name.value.trim() });
    await loadRuns();
    notice("Renamed.");
  }) }, "Rename");
  const tags = el("input", { value: run.tags.filter((tag) => !MARKS.includes(tag)).join(", "), placeholder: "tags, with commas", "aria-label": "tags of the run" });
  const retag = el("button", { type: "button", class: "small", onclick: guarded("The tags could not be changed.", async () => {
    const own = tags.value.split(",").map((tag) => tag.trim()).filter(Boolean);
    const marks = state.runs.find((one) => one.id === run.id).tags.filter((tag) => MARKS.includes(tag)); // as they are by now
    await patch(`runs/${run.id}`, { tags: [...marks, ...own] });
    await loadRuns();
    notice("Tagged.");
  }) }, "Tag");
  const exports = ["csv", "mcap", "parquet", "mat"].map((format) => el("button", {
    type: "button", class: "small", onclick: guarded("It could not be exported.", () => download(`runs/${run.id}/export`, { format }, `${run.name}.${format}`)),
  }, format.toUpperCase()));
  const gone = el("button", { type: "button", class: "small danger", onclick: guarded("It could not be deleted.", async () => {
    if (!await ask(`Delete ${run.name}?`, "The run and its measurements are removed for good.", "Delete for good", { danger: true })) return;
    await remove(`runs/${run.id}`);
    await loadRuns();
  }) }, "Delete");
  return el("div", { class: "panel" }, el("div", { class: "row" }, name, rename, tags, retag, el("span", { class: "grow" }), el("a", { class: "button small", href: `#/explore/run:${run.id}` }, "Explore"), "Export", exports, gone),
    el("p", { class: "muted" }, `${run.samples} samples, ${number(run.rate, 4)} Hz, from ${run.source || run.profile}. ${run.reason ?? ""}`),
    known(run),
    el("div", { class: "beside" }, arm.box, card("Positions and measured torques", null, plot.box, null)),
    el("p", { class: "muted" }, "Drag to zoom: the whole detail is loaded. Double-click to return. Click a joint in the legend to hide it. Point at the plot: the arm stands as it did then."));
}
