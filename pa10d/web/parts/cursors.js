// Two cursors in time, and what is drawn as a table: values at both, their difference, and the range.
import { el, fill } from "../base/dom.js";
import { table } from "../base/columns.js";
import { failed } from "../base/notices.js";
import { number } from "../base/units.js";

const HEADS = ["line", "at A", "at B", "B − A", "lowest seen", "highest seen", "unit"];

/** moved([a, b]): a cursor was set, s or null each; look([a, b]): both are set and are to be zoomed to. */
export function cursors(moved, look) {
  const at = [null, null];
  let rows = [], asked = 0;
  const body = el("tbody", {});
  const inputs = ["A", "B"].map((name, k) => el("input", { type: "number", min: 0, step: "any", class: "short", "aria-label": `cursor ${name}, s`, onchange: (event) => set(k, event.target.value === "" ? null : event.target.valueAsNumber) }));
  const zoom = el("button", { type: "button", class: "small", onclick: () => look([...at].sort((a, b) => a - b)) }, "Zoom to A–B");
  const box = el("details", { class: "block" }, el("summary", {}, "Cursors, and the same in numbers"),
    el("div", { class: "row pad" }, el("label", {}, "A ", inputs[0], " s"), el("label", {}, "B ", inputs[1], " s"), zoom, el("small", { class: "muted" }, "A: click into a plot over time; B: with Shift.")),
    el("div", { class: "scroll", tabIndex: 0, role: "region", "aria-label": "values that are drawn" },
      el("table", { class: "numbers" }, el("thead", {}, el("tr", {}, HEADS.map((head) => el("th", { scope: "col" }, head)))), body)));
  box.addEventListener("toggle", () => { if (box.open) read(); });

  function set(which, time) {
    at[which] = Number.isFinite(time) ? time : null;
    inputs[which].value = at[which] === null ? "" : Number(at[which].toFixed(4));
    moved([...at]);
    allow();
    if (box.open) read();
    else if (at[which] !== null) box.open = true; // which reads
  }
  const allow = () => { zoom.disabled = at.some((one) => one === null) || at[0] === at[1]; };
  allow();

  const read = () => exact().catch((error) => failed("The values cannot be read.", error));
  /** Of the very samples, not of the pieces that are drawn. */
  async function exact() {
    const mine = ++asked, found = await Promise.all(at.map((time) => (time === null ? null : values(time))));
    if (mine !== asked) return;
    fill(body, rows.map((row, k) => {
      const [a, b] = found.map((one) => one?.[k] ?? null);
      const cells = [a, b, a === null || b === null ? null : b - a, row.low, row.high];
      return el("tr", {}, el("th", { scope: "row" }, row.label), cells.map((cell) => el("td", {}, cell === null ? "–" : number(cell, 5))), el("td", {}, row.unit));
    }));
  }
  async function values(time) {
    const queries = [...new Set(rows.map((row) => JSON.stringify(row.query)))];
    const got = new Map(await Promise.all(queries.map(async (query) => {
      const channel = [...new Set(rows.filter((row) => JSON.stringify(row.query) === query).map((row) => row.channel))];
      return [query, (await table("columns", { ...JSON.parse(query), channel, begin: Math.max(0, time), end: Math.max(0, time) + 1e-6, points: 2, every: true })).columns];
    })));
    return rows.map((row) => {
      const columns = got.get(JSON.stringify(row.query)), last = columns.time.length - 1;
      const k = Math.abs(columns.time[0] - time) <= Math.abs(columns.time[last] - time) ? 0 : last;
      return Math.abs(columns.time[k] - time) > 1 ? null : columns[row.channel][k]; // it has ended, or not begun
    });
  }
  return {
    box, set,
    /** [{label, query, channel, low, high, unit}]: what is drawn now. */
    show(drawn) { rows = drawn; if (box.open) read(); },
  };
}
