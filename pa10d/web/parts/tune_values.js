// What of the profile is tuned, as tables; edits are kept until their difference was seen and written.
import { el, fill, say } from "../base/dom.js";
import { patch, post } from "../base/api.js";
import { whyNot } from "../base/condition.js";
import { state, watch } from "../base/store.js";
import { guarded, notice } from "../base/notices.js";
import { number, titled } from "../base/units.js";
import { tabsByKeys } from "./tabs.js";
import { boxesEditor } from "./tune_boxes.js";

const GROUPS = { gains: "Gains", limits: "Limits", safety: "Bounds", environment: "Surroundings" };
const ABOUT = {
  gains: "Of the joint servo (PID). Those that the profile does not state follow from the bandwidth, or from what the first motion has measured.",
  limits: "What no motion and no controller may exceed. Raised beyond the URDF or the drives, they are to be confirmed.",
  safety: "What the torque exit watches: how far a joint may be from its path, and how quickly torque may rise.",
  environment: "What stands around the arm, in the frame of its base. Plans keep 3 cm from it.",
};
const SOURCES = { profile: "stated in the profile", measured: "as measured", rule: "from the rule", URDF: "the URDF's", nobody: "stated nowhere" };
const DIGITS = 7;

/** {box, show(tuning, versions)}; changed(): after something was written. */
export function tunedValues(changed) {
  const edits = new Map(); // key -> value, null for none, or {joint: value}
  let tuning = null, group = "gains";
  const where = el("p", { class: "muted" }), table = el("div", {}), about = el("p", { class: "muted" });
  const tabs = tabsByKeys(el("div", { class: "row tabs", role: "tablist", "aria-label": "what is tuned" }));
  const outcome = el("div", { "aria-live": "polite" }), history = el("details", { class: "notes" }, el("summary", {}, "Versions"), el("ol", {}));
  const compare = el("button", { type: "button", class: "primary", onclick: guarded("There is no difference to show.", async () => {
    try {
      difference(await post("profile/check", { changes: Object.fromEntries(edits) }), false);
    } catch (error) {
      if (!error.status) throw error;
      fill(outcome, el("p", { class: "bad", role: "alert" }, inTheirWords(error.message)));
    }
  }) }, "Show the difference");
  const discard = el("button", { type: "button", onclick: () => { edits.clear(); fill(outcome); draw(); } }, "Discard");
  const back = el("button", { type: "button", onclick: guarded("It cannot be undone.", async () => difference(await post("profile/undo/check"), true)) }, "Undo the last change");
  const box = el("div", { class: "panel" }, el("h2", {}, "Values in force"), where, tabs, about, table, el("div", { class: "row below" }, compare, discard, back), outcome, history);

  fill(tabs, Object.entries(GROUPS).map(([id, label]) => el("button", {
    type: "button", role: "tab", class: "small", "aria-selected": String(id === group), dataset: { group: id }, onclick: () => {
      group = id;
      for (const tab of tabs.children) tab.setAttribute("aria-selected", String(tab.dataset.group === id));
      draw();
    } }, label)));

  /** What is wrong with a value, by the names of the table: a file's line and its keys are not on this page. */
  const inTheirWords = (message) => tuning.values.reduce((text, one) => text.replaceAll(new RegExp(`\\b${one.key.replaceAll(".", "\\.")}(?:\\.(\\d+))?(?=:)`, "g"),
    (_, joint) => titled(one.title) + (joint ? ` of joint ${joint}` : "")), message.replaceAll(/^\S*\.ya?ml(:\d+)?: /gm, ""));

  const keep = (key, value) => {
    if (value === undefined) edits.delete(key);
    else edits.set(key, value);
    fill(outcome); // the difference that was shown is another one now
    refresh();
  };
  const refresh = () => {
    compare.disabled = !edits.size || Boolean(tuning?.refusal);
    discard.disabled = !edits.size;
    back.disabled = !tuning || tuning.version === 1;
    for (const tab of tabs.children) {
      const count = tuning ? tuning.values.filter((one) => one.group === tab.dataset.group && edits.has(one.key)).length : 0;
      say(tab, GROUPS[tab.dataset.group] + (count ? ` (${count} changed)` : ""));
    }
  };

  function draw() {
    refresh();
    if (!tuning) return;
    say(about, ABOUT[group]);
    const values = tuning.values.filter((one) => one.group === group);
    if (group === "environment") return fill(table, surroundings(values));
    const single = values.filter((one) => !one.per_joint), columns = values.filter((one) => one.per_joint);
    fill(table, single.map(field), el("div", { class: "scroll bare", tabIndex: 0, role: "region", "aria-label": GROUPS[group] }, el("table", { class: "tuning" },
      el("thead", {}, el("tr", {}, el("th", { scope: "col" }, "joint"), columns.map(head))),
      el("tbody", {}, tuning.joints.map((name, j) => el("tr", {}, el("th", { scope: "row" }, `${j + 1} ${name}`), columns.map((one) => cell(one, j))))))));
  }

  const head = (one) => el("th", { scope: "col" }, `${one.title}, ${[...new Set(one.units)].join(" or ")}`, el("small", {}, source(one)), unset(one));
  const source = (one) => edits.get(one.key) === null ? one.none : SOURCES[one.source];

  /** Back to what holds where the profile says nothing, and not back. */
  function unset(one) {
    if (one.source !== "profile" || one.group === "environment") return null;
    const away = edits.get(one.key) === null;
    return el("button", { type: "button", class: "link", "aria-pressed": String(away), title: `Then: ${one.none}`, "aria-label": `${away ? "keep" : "unset"} ${one.title}`,
                          onclick: () => { keep(one.key, away ? undefined : null); draw(); } }, away ? "keep" : "unset");
  }

  function input(one, { label, value, changedTo, off, bound }) {
    const made = el("input", { type: "number", step: "any", inputMode: "decimal", "aria-label": label, disabled: off, value: value === null ? "" : number(value, DIGITS),
                               placeholder: "none", title: bound ?? "" });
    made.addEventListener("input", () => { // at once: what is pressed next may be the button
      const now = made.value.trim() === "" ? null : Number(made.value);
      changedTo(now === null || now === Number(number(value, DIGITS)) ? undefined : now);
      made.classList.toggle("changed", edits.has(one.key));
    });
    return made;
  }

  function field(one) {
    const away = edits.get(one.key) === null, edited = edits.get(one.key);
    const made = input(one, { label: `${one.title}, ${one.units[0]}`, value: one.in_force, off: away, changedTo: (now) => keep(one.key, now) });
    if (typeof edited === "number") { made.value = edited; made.classList.add("changed"); }
    return el("div", { class: "row below" }, el("b", {}, `${titled(one.title)}, ${one.units[0]}`), made, el("small", {}, source(one)), unset(one));
  }

  function cell(one, j) {
    const off = edits.get(one.key) === null, of = `${one.title} of joint ${j + 1} ${tuning.joints[j]}, ${one.units[j]}`;
    const bound = one.bounds.map(({ says, most }) => `${says} ${[most[j]].flat().map((x) => number(x, DIGITS)).join(" to ")}`).join(", ");
    const mine = edits.get(one.key)?.[j + 1], put = (value) => {
      const rest = { ...edits.get(one.key) };
      if (value === undefined) delete rest[j + 1];
      else rest[j + 1] = value;
      keep(one.key, Object.keys(rest).length ? rest : undefined);
    };
    const mark = (made, value, was) => { if (value !== undefined && value !== was) { made.value = value; made.classList.add("changed"); } return made; };
    if (!Array.isArray(one.in_force[j])) return el("td", {}, mark(input(one, { label: of, value: one.in_force[j], off, bound, changedTo: put }), mine, one.in_force[j]));
    const pair = one.in_force[j], ends = ["lower", "upper"];
    return el("td", {}, ends.map((word, k) => mark(input(one, { label: `${word} ${of}`, value: pair[k], off, bound, changedTo: (now) => {
      const next = [...(edits.get(one.key)?.[j + 1] ?? pair)];
      next[k] = now ?? pair[k];
      put(next.every((x, e) => x === pair[e]) ? undefined : next);
    } }), mine?.[k], pair[k])));
  }

  function surroundings(values) {
    const [floor, boxes] = ["environment.floor", "environment.boxes"].map((key) => values.find((one) => one.key === key));
    const at = edits.has(floor.key) ? edits.get(floor.key) : floor.in_force, none = at === "none";
    const height = el("input", { id: "tune-floor", type: "number", step: "any", inputMode: "decimal", value: none ? "" : at, disabled: none });
    const absent = el("input", { id: "tune-no-floor", type: "checkbox", checked: none });
    const put = () => { const now = absent.checked ? "none" : Number(height.value || 0); keep(floor.key, now === floor.in_force ? undefined : now); };
    height.addEventListener("input", put);
    absent.addEventListener("change", () => { put(); draw(); document.getElementById(absent.id)?.focus(); });
    return [el("div", { class: "row below" }, el("label", { htmlFor: height.id }, el("b", {}, "Floor, m")), height, el("label", { htmlFor: absent.id }, absent, " no floor"),
      el("small", {}, "height along the base's z axis")),
      boxesEditor(edits.get(boxes.key) ?? boxes.in_force, (now) => keep(boxes.key, JSON.stringify(now) === JSON.stringify(boxes.in_force) ? undefined : now))];
  }

  function difference(found, undoing) {
    const asked = found.diff.filter((one) => one.asked), follows = found.diff.filter((one) => !one.asked);
    const read = el("input", { type: "checkbox", id: "tune-read", onchange: () => allow() }), why = el("p", { class: "warn", role: "status" });
    const go = el("button", { type: "button", class: "primary", onclick: guarded(undoing ? "It was not undone." : "Nothing was written.", async () => {
      const confirmed = read.checked;
      const made = undoing ? await post("profile/undo", { confirmed }) : await patch("profile", { changes: Object.fromEntries(edits), confirmed });
      edits.clear();
      fill(outcome);
      notice(`Version ${made.version} of the profile holds.`, { detail: made.restart ? "Control starts anew with it, which takes some seconds." : "The next pre-check counts with it." });
      await changed();
    }) }, undoing ? `Undo: back to version ${found.version}` : `Write version ${found.version}`);
    const allow = () => {
      const cause = whyNot(found.restart ? ["inactive", "offline"] : null);
      say(why, cause ? `Not now: ${cause}.` : "");
      why.hidden = !cause;
      go.disabled = Boolean(cause) || (found.confirm.length > 0 && !read.checked);
    };
    const shown = el("div", { class: "checks" }, el("h2", {}, undoing ? "What undo changes" : "What changes"), rows(asked, "what changes"),
      follows.length ? el("details", {}, el("summary", {}, `${follows.length} more values follow from that`), rows(follows, "what follows")) : null,
      found.confirm.length ? el("div", { class: "doubt" }, el("p", {}, el("b", {}, "That lets the arm do more:")), el("ul", {}, found.confirm.map((one) => el("li", {}, one))),
        el("label", { htmlFor: read.id }, read, " I have read this, and want it")) : null,
      el("p", { class: "muted" }, found.effect.map((one) => `${one[0].toUpperCase()}${one.slice(1)}. `)), el("p", { class: "muted" }, `File: ${found.file}`), el("div", { class: "row" }, go), why);
    fill(outcome, shown);
    watch(["robot", "jobs", "condition"], allow, shown);
    go.focus();
  }

  const rows = (items, label) => el("ul", { class: "differences", "aria-label": label }, items.map((one) => el("li", {}, one.sentence)));

  watch(["robot"], refresh);
  return {
    box,
    show(found, versions) {
      if (tuning && tuning.version !== found.version) fill(outcome); // written elsewhere: the difference is another one
      tuning = found;
      say(where, `${found.file}, version ${found.version}. ${found.refusal ?? ""}`);
      fill(history.lastChild, versions.map((one) => el("li", { value: one.version }, `${one.when}${one.undone ? " (undone)" : ""}: ${one.changes.join("; ")}`)));
      history.hidden = !versions.length;
      draw();
    },
  };
}
