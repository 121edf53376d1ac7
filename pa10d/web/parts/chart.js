// Quick line plots by uPlot, which comes with the first of them: over time with one cursor and one
// zoom for all, or one quantity over another.
import { el, larger } from "../base/dom.js";

const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const WIDE = 62; // px for the numbers of an axis
const font = (scale = 1) => `${12 * larger() * scale}px system-ui, sans-serif`;

let library = null;
function plots() {
  library ??= (async () => {
    const href = new URL("../vendor/uplot.css", import.meta.url).href;
    document.head.append(el("link", { rel: "stylesheet", href }));
    return (await import("../vendor/uplot.js")).uPlot;
  })();
  library.catch(() => { library = null; });
  return library;
}

/** As many digits as tell neighbours apart: 0.0025 is not 0.003. */
const ticks = (_, places) => places.map((at) => (at === null ? null : String(Number(at.toPrecision(6)))));
const axis = (label, size) => ({
  values: ticks,
  label, labelSize: 20 * larger(), labelFont: font(), font: font(), size: size * larger(), stroke: () => css("--muted"),
  grid: { stroke: () => css("--grid"), width: 1 }, ticks: { stroke: () => css("--line"), width: 1 },
});
const line = ({ label, color, dash }) => ({ label, stroke: color, width: 1.3, dash, spanGaps: true, points: { show: false },
                                            value: (_, value) => (value === null || value === undefined ? "–" : Number(value.toPrecision(5))) });

/** A chart that keeps its place in the page while what it shows changes. */
export class Chart {
  /** zoomed([begin, end] or null), pointed(x), clicked(x, with Shift): told by the hand on the chart. */
  constructor(height, { key = null, zoomed = null, pointed = null, clicked = null } = {}) {
    Object.assign(this, { height, key, zoomed, pointed, clicked, bands: [], marks: [] });
    this.box = el("div", { class: "chart" });
    new ResizeObserver(() => this.plot?.setSize(this.size())).observe(this.box);
    let pressed = null; // of the box, not of the plot: that may be made anew, or move, under the button
    this.box.addEventListener("pointerdown", (event) => { pressed = event.button === 0 ? event.clientX : null; });
    this.box.addEventListener("pointerup", (event) => {
      const over = this.plot?.over, x = event.clientX;
      if (!this.clicked || !this.shape || pressed === null || !over?.contains(event.target) || Math.abs(x - pressed) >= 4) return;
      this.clicked(this.plot.posToVal(x - over.getBoundingClientRect().left, "x"), event.shiftKey);
    });
  }

  size() { return { width: Math.max(200, this.box.clientWidth), height: this.height * larger() }; }

  /** tables: one [x, …columns] per source; series: {label, color, dash} in their order; span: x. */
  async lines({ tables, series, x, y, span, log = false, bands = [] }) {
    const uPlot = await plots();
    const data = tables.length === 1 ? tables[0] : uPlot.join(tables);
    const shape = JSON.stringify([series, x, y, log]);
    this.bands = bands;
    if (this.shape !== shape) this.make(uPlot, { series: [{ label: x }, ...series.map(line)], x, y, log }, data);
    this.shape = shape;
    this.plot.batch(() => {
      this.plot.setData(data, false);
      for (const scale of ["y"]) this.plot.setScale(scale, { min: null, max: null });
      this.plot.setScale("x", span ? { min: span[0], max: span[1] } : within(data[0]));
    });
  }

  /** pairs: [x, y] columns of each line. */
  async against({ pairs, series, x, y }) {
    const uPlot = await plots();
    this.shape = null;
    const paths = (u, k) => {
      uPlot.orient(u, k, (one, xs, ys, sx, sy, toX, toY, left, top, width, height) => {
        const [px, py] = u.data[k], pen = u.ctx;
        pen.save();
        pen.beginPath();
        pen.rect(left, top, width, height);
        pen.clip();
        pen.strokeStyle = series[k - 1].color;
        pen.setLineDash(series[k - 1].dash ?? []);
        pen.lineWidth = 1;
        pen.beginPath();
        for (let i = 0; i < px.length; i += 1) pen.lineTo(toX(px[i], sx, width, left), toY(py[i], sy, height, top));
        pen.stroke();
        pen.restore();
      });
      return null;
    };
    const range = (k) => () => within([].concat(...pairs.map((pair) => ends(pair[k]))), 0.04);
    this.plot?.destroy();
    this.plot = new uPlot({
      ...this.size(), mode: 2, axes: [axis(x, 50), axis(y, WIDE)], legend: { live: false }, cursor: { drag: { x: true, y: true, uni: 20 } },
      scales: { x: { time: false, range: range(0) }, y: { range: range(1) } },
      series: [{}, ...series.map(({ label, color }) => ({ label, stroke: color, paths, facets: [{ scale: "x", auto: true }, { scale: "y", auto: true }] }))],
    }, [null, ...pairs], this.box);
  }

  make(uPlot, { series, x, y, log }, data) {
    this.plot?.destroy();
    const { zoomed, pointed, key } = this;
    this.plot = new uPlot({
      ...this.size(), series, axes: [axis(x, 50), axis(y, WIDE)],
      scales: { x: { time: false }, y: log ? { distr: 3 } : { range: (_, low, high) => (low === high ? around(low) : uPlot.rangeNum(low, high, 0.1, true)) } },
      cursor: {
        sync: key ? { key } : undefined, drag: { x: true, y: false, setScale: !zoomed }, focus: { prox: 24 },
        bind: zoomed ? { dblclick: () => () => { zoomed(null); } } : {},
      },
      focus: { alpha: 0.4 },
      hooks: {
        drawClear: [(u) => this.shade(u)],
        draw: [(u) => this.letter(u)],
        setSelect: [(u) => {
          if (!zoomed || u.select.width < 4) return;
          const span = [u.posToVal(u.select.left, "x"), u.posToVal(u.select.left + u.select.width, "x")];
          u.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
          zoomed(span);
        }],
        setCursor: [(u) => { if (pointed && u.cursor.left >= 0) pointed(u.posToVal(u.cursor.left, "x")); }],
      },
    }, data, this.box);
  }

  /** Cursors that stay: [a, b], null where there is none. */
  mark(marks) {
    this.marks = marks;
    this.plot?.redraw(false, false);
  }

  letter(u) {
    const pen = u.ctx, scale = devicePixelRatio || 1;
    pen.save();
    pen.strokeStyle = pen.fillStyle = css("--text");
    pen.lineWidth = scale;
    pen.font = font(scale);
    this.marks.forEach((at, k) => {
      const x = at === null ? -1 : u.valToPos(at, "x", true);
      if (x < u.bbox.left || x > u.bbox.left + u.bbox.width) return;
      pen.setLineDash(k ? [5 * scale, 3 * scale] : []);
      pen.beginPath();
      pen.moveTo(x, u.bbox.top);
      pen.lineTo(x, u.bbox.top + u.bbox.height);
      pen.stroke();
      pen.fillText("AB"[k], x + 3 * scale, u.bbox.top + 12 * scale * larger());
    });
    pen.restore();
  }

  /** Stretches that are left out, in grey. */
  shade(u) {
    u.ctx.save();
    u.ctx.fillStyle = css("--line");
    u.ctx.globalAlpha = 0.5;
    for (const [begin, end] of this.bands) {
      const left = Math.max(u.valToPos(begin, "x", true), u.bbox.left), right = Math.min(u.valToPos(end, "x", true), u.bbox.left + u.bbox.width);
      if (right > left) u.ctx.fillRect(left, u.bbox.top, right - left, u.bbox.height);
    }
    u.ctx.restore();
  }
}

/** What stands still is drawn in the middle; by itself uPlot shows a joint that rests at zero on 0 to 100. */
const around = (value) => (value === null || value === undefined ? [null, null] : [value - (Math.abs(value) || 1), value + (Math.abs(value) || 1)]);

/** [lowest, highest] of the numbers among them. */
export function ends(values) {
  let low = Infinity, high = -Infinity;
  for (const value of values) if (Number.isFinite(value)) { low = Math.min(low, value); high = Math.max(high, value); }
  return low <= high ? [low, high] : [0, 1];
}

function within(values, margin = 0) {
  const [low, high] = ends(values), room = margin * (high - low || 1);
  return margin ? [low - room, high + room] : { min: low, max: high };
}
