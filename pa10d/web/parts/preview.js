// A file before it is imported: its columns as they were understood, corrected by hand, and what to
// know of it before anything is fitted to it.
import { el, fill, svg } from "../base/dom.js";
import { post, remove } from "../base/api.js";
import { failed, guarded } from "../base/notices.js";
import { number, seconds } from "../base/units.js";

const SOON = 350; // ms after the last key
const WIDTH = 120, HEIGHT = 30, EDGE = 2;
const FIELDS = [["q", "position"], ["tau", "torque"], ["dq", "velocity"], ["i", "motor current"], ["temp", "temperature"]];
const SI = { time: "s", q: "rad", dq: "rad/s", tau: "N·m", i: "A", temp: "°C" };
const UNITS = {
  time: ["ms", "us", "ns", "min"], q: ["deg", "rev", "mrad", "-1", "-deg", "mm"], dq: ["deg/s", "rpm", "rev/s", "-1"],
  tau: ["mNm", "Nmm", "kNm", "-1", "i16"], i: ["mA", "-1", "i16"], temp: [],
};
const kindOf = (field) => field.replace(/\d+$/, "");
let count = 0;

/** Ask what becomes of a file that was sent. Resolves with {rules, part, force, alike, every, seen} or null: leave it.
    others: how many more files wait. */
export function decide(box, seen, others = 0) {
  return new Promise((answered) => {
    const view = new View(seen, others, (answer) => { fill(box); answered(answer); });
    fill(box, view.box);
    view.heading.focus();
    view.ask();
  });
}

/** What helps, in words of this page: what an import can put right is a button there. */
const adviceOf = ({ advice, mends }, mend) => !advice || (mends?.length && mend) ? ""
  : ` → ${mends?.length ? "import the file anew: there a button mends it" : inPage(advice)}`;

/** What the command line's --map would be told, the table of columns is told here. */
const inPage = (advice) => advice.replaceAll(/(in )?--map /g, "").replaceAll(/'?([^'\s[\]]+)\[([^\]]+)\]=\w+'?/g,
  (_, column, unit) => `unit ${unit} for ${column.replace("{n}", "…")}`);

/** What the checks said, each with a button where something mends it. */
export const findingsList = (findings, mend = null) => findings.length
  ? el("ul", { class: "levels" }, findings.map((one) => el("li", { class: one.severity }, el("b", {}, one.severity), ` ${one.sentence}${adviceOf(one, mend)} `,
    mend && one.mends?.length ? el("button", { type: "button", class: "small", "aria-label": `Mend it: ${one.sentence}`, onclick: () => mend(one.mends) }, "Mend it") : null)))
  : null;

class View {
  constructor(seen, others, end) {
    this.seen = seen;
    this.turn = 0;
    this.part = seen.part;
    const id = `preview-${++count}`;
    this.heading = el("h2", { id, tabIndex: -1 }, `Before ${seen.file} is imported`);
    this.extent = el("p", { class: "muted" });
    this.problem = el("p", { class: "bad", role: "alert" });
    this.findings = el("div", {});
    this.status = el("p", { class: "muted", "aria-live": "polite" });
    this.line = el("code", {});
    this.columns = el("tbody", {});
    this.further = el("p", { class: "muted" });
    this.list();
    const button = (label, kind, answer) => el("button", { type: "button", class: kind, onclick: guarded("It was not imported.", async () => {
      if (answer === null) await remove(`recordings/${seen.id}`).catch(() => {}); // gone already, or soon
      end(answer && { ...answer, rules: this.seen.rules, part: this.seen.part, seen: this.seen });
    }) }, label);
    this.go = button("Import", "primary", { force: false });
    this.every = seen.parts?.kind === "episode" ? button(`Import all ${Object.keys(seen.parts.options).length} episodes`, "", { force: false, every: true }) : null;
    this.forced = button("Import it all the same", "danger", { force: true });
    this.alike = others ? button(others > 1 ? `Import this and the ${others} others alike` : "Import this and the other one alike", "", { force: false, alike: true }) : null;
    this.box = el("section", { class: "panel preview", "aria-labelledby": id }, this.heading, this.which(), this.extent, this.problem, this.findings, this.status,
      el("div", { class: "scroll", tabIndex: 0, role: "region", "aria-label": `columns of ${seen.file}` }, el("table", {},
        el("thead", {}, el("tr", {}, ["column", "read as", "unit", "course", "from … to", "first values in the file"].map((head) => el("th", { scope: "col" }, head)))),
        this.columns)), this.further,
      el("details", {}, el("summary", {}, "The same on the command line"), el("p", {}, this.line)),
      el("div", { class: "row" }, this.go, this.every, this.alike, this.forced, button("Leave it", "", null)));
    this.tell();
  }

  /** Of a file that holds several recordings: which one. */
  which() {
    const { parts } = this.seen;
    if (!parts) return null;
    const pick = () => this.another(parts.kind === "episode" ? { episode: Number(box.value) } : { topic: box.value });
    const box = el("select", { id: `part-${++count}`, onchange: pick }, parts.taken ? null : el("option", { value: "", selected: true, disabled: true }, "choose …"),
      Object.entries(parts.options).map(([value, words]) => el("option", { value, selected: value === parts.taken }, words)));
    return el("div", { class: "field" }, el("label", { htmlFor: box.id }, parts.kind), box, el("small", {}, `${this.seen.file} holds ${Object.keys(parts.options).length} to choose from`));
  }

  /** Another recording may have other columns: they are guessed anew. */
  another(part) {
    this.part = part;
    clearTimeout(this.timer);
    this.ask(null, true);
  }

  /** The table, for the columns that there are. */
  list() {
    this.rows = new Map(this.seen.columns.map((column) => [column.name, this.row(column)]));
    fill(this.columns, [...this.rows.values()].map((row) => row.box));
    this.further.textContent = this.seen.left_out ? `${this.seen.left_out} more columns are kept as further channels.` : "";
  }

  row(column) {
    const option = (value, text) => el("option", { value, selected: value === column.field }, text);
    const field = el("select", { "aria-label": `${column.name}: read as`, onchange: () => { this.suggest(row); this.later(0); } },
      option("", "further channel"), option("time", "time"),
      FIELDS.map(([prefix, words]) => el("optgroup", { label: words }, this.seen.joints.map((joint, j) => option(`${prefix}${j + 1}`, `${prefix}${j + 1} · ${joint}`)))));
    const units = el("datalist", { id: `units-${++count}` });
    const unit = el("input", { value: column.unit, size: 8, spellcheck: "false", "aria-label": `${column.name}: unit`, list: units.id, oninput: () => this.later(SOON) });
    const course = el("td", {}), range = el("td", {});
    const row = { field, unit, units, course, range, box: el("tr", {}, el("th", { scope: "row" }, column.name), el("td", {}, field), el("td", {}, unit, units), course, range,
      el("td", { class: "first" }, column.first.map((value) => number(value, 6)).join("   "))) };
    this.suggest(row);
    this.draw(row, column);
    return row;
  }

  /** Units that the field may come in. */
  suggest({ field, unit, units }) {
    const kind = kindOf(field.value);
    fill(units, (UNITS[kind] ?? []).map((one) => el("option", { value: one })));
    unit.placeholder = SI[kind] ?? "";
    unit.disabled = !field.value;
  }

  draw({ field, course, range }, column) {
    fill(course, curve(column));
    const unit = SI[kindOf(field.value)];
    range.textContent = `${number(column.low, 4)} … ${number(column.high, 4)}${unit ? ` ${unit}` : ""}`;
  }

  choices() {
    return [...this.rows].filter(([, { field }]) => field.value).map(([column, { field, unit }]) => ({ column, field: field.value, unit: unit.value.trim() }));
  }

  mend(choices) {
    for (const { column, field, unit } of choices) {
      const row = this.rows.get(column);
      if (row) Object.assign(row.field, { value: field }), Object.assign(row.unit, { value: unit });
    }
    this.heading.focus();
    this.later(0);
  }

  later(ms) {
    this.turn += 1;
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.ask(this.choices()), ms);
  }

  /** The quick answer first, then what needs a fit. */
  async ask(columns = null, anew = false) {
    const turn = ++this.turn;
    this.busy(true);
    try {
      for (const thorough of columns || anew ? [false, true] : [true]) {
        const chosen = anew && !thorough ? null : columns ?? this.choices();
        const seen = await post(`recordings/${this.seen.id}/preview`, { columns: chosen, thorough, part: this.part });
        if (turn !== this.turn || !this.box.isConnected) return;
        this.seen = { ...seen, thorough: thorough || Boolean(seen.problem) };
        if (anew && !thorough) this.list();
        this.tell();
        if (seen.problem) break;
      }
    } catch (error) {
      if (turn === this.turn && this.box.isConnected) failed("It cannot be looked at.", error);
    }
    if (turn === this.turn) this.busy(false);
  }

  busy(on) {
    this.status.textContent = on ? "Looking at units, signs, delay and motion …" : "";
    this.box.setAttribute("aria-busy", String(on));
  }

  tell() {
    const { seen } = this;
    this.extent.textContent = !seen.samples ? "" : `${seen.samples} samples${seen.duration ? `, ${seconds(seen.duration)} at ${number(seen.rate, 4)} Hz` : ""}. ${seen.remarks.join(". ")}`;
    this.problem.textContent = seen.problem;
    this.problem.hidden = !seen.problem;
    const told = seen.findings.filter((one) => one.code !== "rate");
    fill(this.findings, findingsList(told, (choices) => this.mend(choices)), seen.thorough && !seen.problem && !told.some((one) => one.severity !== "info") ? el("p", {}, "Nothing stands against a fit.") : null);
    const wrong = seen.findings.some((one) => one.severity === "error");
    this.go.disabled = Boolean(seen.problem) || wrong;
    if (this.alike) this.alike.disabled = this.go.disabled;
    if (this.every) this.every.disabled = Boolean(seen.problem); // what is wrong with one is not with all
    this.forced.hidden = Boolean(seen.problem) || !wrong;
    this.line.textContent = `pa10d run import ${seen.file}${seen.line ? ` ${seen.line}` : ""}`;
    for (const column of seen.columns) {
      const row = this.rows.get(column.name);
      if (!row) continue;
      if (!seen.problem) {
        row.field.value = column.field;
        if (document.activeElement !== row.unit) row.unit.value = column.unit;
        this.suggest(row);
      }
      this.draw(row, column);
    }
  }
}

/** A column over time, as one small line. */
function curve({ name, curve: values, low, high }) {
  const x = (k) => EDGE + (WIDTH - 2 * EDGE) * k / Math.max(values.length - 1, 1);
  const y = (v) => HEIGHT - EDGE - (HEIGHT - 2 * EDGE) * (v - low) / (high - low || 1);
  const points = values.map((v, k) => (v === null ? null : `${x(k).toFixed(1)},${y(v).toFixed(1)}`)).filter(Boolean).join(" ");
  return svg("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, width: WIDTH, height: HEIGHT, role: "img", "aria-label": `course of ${name}` },
    svg("polyline", { points, class: "course", fill: "none", "stroke-width": 1.2 }));
}
