// What a plot shows, as a table: for who hears the page, and for who wants the figure itself.
import { el, fill } from "../base/dom.js";

const FEW = 12; // points of a line that are all told; of more, where it begins, ends, and how far it goes
const HEADS = ["line", "points", "first", "last", "least", "greatest"];

/** Folded, beside a plot: filled when it is opened, and again whenever the plot is drawn. */
export function inNumbers(canvas, title) {
  const body = el("div", {});
  const box = el("details", { class: "words" }, el("summary", {}, "The same in numbers"), body);
  const show = () => { if (box.open) fill(body, tables(canvas, title)); };
  box.addEventListener("toggle", async () => {
    if (box.open && !canvas._fullData) {
      fill(body, el("p", { class: "muted" }, "It is being drawn …"));
      await canvas.drawNow?.()?.catch(() => {});
    }
    show();
  });
  canvas.drawn = show;
  return box;
}

function tables(canvas, title) {
  const traces = (canvas._fullData ?? []).filter((one) => one.visible === true && (one.z ?? one.y)?.length);
  if (!traces.length) return el("p", { class: "muted" }, "Nothing is drawn yet.");
  const places = traces.map((one) => titleOf(canvas, one)), several = new Set(places).size > 1;
  const axes = [several ? ["along", null] : ["along", canvas._fullLayout?.xaxis], ["up", canvas._fullLayout?.yaxis]]
    .map(([way, axis]) => [way, axis?.title?.text]).filter(([, text]) => text && !text.startsWith("Click")).map(([way, text]) => `${way}: ${text}`);
  return [
    axes.length ? el("p", { class: "muted" }, `${axes.join("; ")}.`) : null,
    el("div", { class: "scroll", tabIndex: 0, role: "region", "aria-label": `${title} in numbers` },
      el("table", { class: "numbers" }, el("thead", {}, el("tr", {}, [...(several ? ["against"] : []), ...HEADS].map((head) => el("th", { scope: "col" }, head)))),
        el("tbody", {}, traces.map((one, k) => row(one, traces.length > 1 ? `line ${k + 1}` : title, several ? el("td", {}, places[k]) : null))))),
  ];
}

/** What a line is drawn over, in the words of its axis. */
const titleOf = (canvas, { xaxis = "x" }) => (canvas.layout?.[xaxis.replace("x", "xaxis")]?.title?.text ?? "").replaceAll("<br>", " ");

function row(trace, unnamed, place) {
  const name = trace.meta ?? (trace.name && !/^trace \d+$/.test(trace.name) ? trace.name : unnamed);
  const points = trace.z ? cells(trace) : along(trace);
  const head = el("th", { scope: "row" }, name), count = el("td", {}, String(points.length));
  if (!points.length) return el("tr", {}, place, head, count, el("td", { colSpan: 4 }, "no number"));
  if (points.length <= FEW) return el("tr", {}, place, head, count, el("td", { colSpan: 4, class: "all" }, points.map(told).join("; ")));
  const sizes = points.map(([, value]) => value);
  const least = points[sizes.indexOf(sizes.reduce((a, b) => Math.min(a, b)))];
  const most = points[sizes.indexOf(sizes.reduce((a, b) => Math.max(a, b)))];
  return el("tr", {}, place, head, count, [points[0], points.at(-1), least, most].map((one) => el("td", {}, told(one))));
}

/** [where, value] of a line or bars; a bar that lies has its value along x. */
function along({ x, y, x0 = 0, dx = 1, orientation }) {
  const lying = orientation === "h", values = lying ? x : y, places = lying ? y : x;
  return Array.from(values ?? [], (value, i) => [places ? places[i] : x0 + i * dx, value]).filter(([place, value]) => Number.isFinite(value) && !Number.isNaN(place));
}

const cells = ({ x, y, z }) => Array.from(z, (values, i) => Array.from(values, (value, j) => [`${short(x?.[j] ?? j)}, ${short(y?.[i] ?? i)}`, value]))
  .flat().filter(([, value]) => Number.isFinite(value));

const told = ([place, value]) => `${short(value)} at ${short(place)}`;
const short = (value) => typeof value === "number" ? String(Number(value.toPrecision(4))) : String(value);
