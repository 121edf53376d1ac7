// Live values on a canvas: one quantity of several joints over the last seconds, with targets,
// limits and what happened meanwhile.
import { el, larger, say } from "../base/dom.js";

export const COLOURS = ["#3d8fd6", "#e8842c", "#2fa58a", "#b8479c", "#9a6210", "#7747ff", "#8a97a6", "#d8475c"];
const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const LEFT = 58, RIGHT = 8, TOP = 8, BOTTOM = 20, MOST = 700; // px, points of a line
const TICKS = [1, 2, 5, 10, 15, 20, 30], APART = 10; // s between marks of time; px between their words
const WORDS = 4; // rows of words of what happened
const LIMITS_OF = 2; // joints: with more, nobody could tell whose limit it is

/** Where the pointer is over a canvas, as a share of the time that is shown. */
export function shareOf(event, canvas) {
  const box = canvas.getBoundingClientRect(), letters = larger();
  return Math.min(1, Math.max(0, (event.clientX - box.left - LEFT * letters) / (box.width - (LEFT + RIGHT) * letters)));
}

/** title, unit; `value`, `target`: (row, joint from 0) -> number; `limits`: joint -> [lower, upper]. */
export class Scope {
  constructor({ title, unit, least, value, target, limits }, joints, hidden) {
    Object.assign(this, { title, unit, least, value, target, limits, joints, hidden });
    this.canvas = el("canvas", { role: "img", "aria-label": `${title} of the chosen joints over time; the newest values stand in the table of joints` });
    this.reading = el("span", { class: "reading" });
    this.box = el("figure", { class: "scope" }, el("figcaption", {}, el("span", {}, `${title}, ${unit}`), this.reading), this.canvas);
  }

  shown() {
    return Array.from({ length: this.joints }, (_, j) => j).filter((j) => !this.hidden.has(j));
  }

  /** at: where the pointer is, as a share of the time shown; null: nowhere. */
  draw(trail, at) {
    const { canvas } = this, ratio = devicePixelRatio || 1, letters = larger(), scale = ratio * letters;
    const width = canvas.clientWidth / letters, height = canvas.clientHeight / letters;
    if (!width || !trail.rows.length) return;
    if (canvas.width !== Math.round(width * scale)) canvas.width = Math.round(width * scale);
    if (canvas.height !== Math.round(height * scale)) canvas.height = Math.round(height * scale);
    const pen = canvas.getContext("2d");
    pen.setTransform(scale, 0, 0, scale, 0, 0);
    pen.clearRect(0, 0, width, height);
    const newest = trail.newest, oldest = newest - trail.seconds;
    const rows = trail.seen(), joints = this.shown();
    const [low, high] = this.range(rows, joints);
    const right = width - RIGHT, bottom = height - BOTTOM;
    const x = (time) => LEFT + ((time - oldest) / trail.seconds) * (right - LEFT);
    const y = (value) => bottom - ((value - low) / (high - low)) * (bottom - TOP);
    const area = { x, y, low, high, right, bottom, oldest, newest };
    this.grid(pen, area, trail.seconds);
    pen.save();
    pen.beginPath();
    pen.rect(LEFT, TOP, right - LEFT, bottom - TOP);
    pen.clip();
    const step = Math.max(1, Math.floor(rows.length / MOST));
    for (const j of joints) {
      pen.strokeStyle = COLOURS[j % COLOURS.length];
      if (this.target) this.line(pen, rows, step, area, (row) => this.target(row, j), [4, 4], 1);
      this.line(pen, rows, step, area, (row) => this.value(row, j), [], 1.5);
    }
    if (this.limits && joints.length <= LIMITS_OF) for (const j of joints) this.limit(pen, area, j);
    this.marks(pen, area, trail.marks);
    pen.restore();
    this.point(pen, area, rows, joints, at);
  }

  line(pen, rows, step, { x, y }, value, dashes, width) {
    pen.setLineDash(dashes);
    pen.lineWidth = width;
    pen.beginPath();
    for (let k = (rows.length - 1) % step; k < rows.length; k += step) pen.lineTo(x(rows[k][0]), y(value(rows[k][1])));
    pen.stroke();
    pen.setLineDash([]);
  }

  limit(pen, { y, low, high, right, bottom }, j) {
    pen.strokeStyle = pen.fillStyle = css("--bad");
    pen.textAlign = "right";
    for (const [k, edge] of (this.limits[j] ?? []).entries()) {
      if (edge === null) continue;
      const inside = edge > low && edge < high, place = inside ? y(edge) : k ? TOP + 1 : bottom - 1;
      const text = `limit of ${j + 1}: ${Number(edge.toPrecision(4))}${inside ? "" : k ? " ↑" : " ↓"}`;
      if (inside) {
        pen.setLineDash([8, 4]);
        pen.beginPath();
        pen.moveTo(LEFT, place);
        pen.lineTo(right, place);
        pen.stroke();
        pen.setLineDash([]);
      }
      pen.textBaseline = k ? "top" : "bottom";
      pen.fillText(text, right - 4 - 110 * this.shown().indexOf(j), place + (k ? 2 : -2));
    }
  }

  /** What happened: thin lines, faults in red, each with a word in the lowest row where it lies on no
      other; where no row has room the line stands alone. The newest and the faults choose first. */
  marks(pen, { x, oldest, right, bottom }, marks) {
    const rows = Array.from({ length: WORDS }, () => []);
    pen.textBaseline = "bottom";
    for (const { time, word, bad } of [...marks].reverse().sort((a, b) => Boolean(b.bad) - Boolean(a.bad))) {
      if (time < oldest) continue;
      pen.strokeStyle = pen.fillStyle = css(bad ? "--bad" : "--muted");
      pen.lineWidth = bad ? 2 : 1;
      pen.beginPath();
      pen.moveTo(x(time), TOP);
      pen.lineTo(x(time), bottom);
      pen.stroke();
      const width = pen.measureText(word).width + APART, left = x(time) + width > right; // no room on the other side
      const from = x(time) - (left ? width : 0), row = rows.findIndex((taken) => taken.every(([a, b]) => from + width <= a || from >= b));
      if (row < 0) continue;
      rows[row].push([from, from + width]);
      pen.textAlign = left ? "right" : "left";
      pen.fillText(word, x(time) + (left ? -3 : 3), bottom - 3 - 13 * row);
    }
  }

  point(pen, { x, right, bottom, oldest, newest }, rows, joints, at) {
    if (at === null) return say(this.reading, "");
    const time = oldest + at * (newest - oldest);
    const row = rows.findLast(([t]) => t <= time)?.[1];
    pen.strokeStyle = css("--text");
    pen.lineWidth = 1;
    pen.beginPath();
    pen.moveTo(Math.min(x(time), right), TOP);
    pen.lineTo(Math.min(x(time), right), bottom);
    pen.stroke();
    say(this.reading, row ? `${(time - newest).toFixed(1)} s:  ${joints.map((j) => `${j + 1}: ${Number(this.value(row, j).toPrecision(4))}`).join("   ")}` : "");
  }

  range(rows, joints) {
    let low = Infinity, high = -Infinity;
    const step = Math.max(1, Math.floor(rows.length / MOST));
    for (let k = (rows.length - 1) % step; k < rows.length; k += step) {
      for (const j of joints) {
        for (const value of [this.value(rows[k][1], j), this.target?.(rows[k][1], j)]) {
          if (!Number.isFinite(value)) continue;
          low = Math.min(low, value);
          high = Math.max(high, value);
        }
      }
    }
    if (!(low <= high)) [low, high] = [-this.least, this.least];
    const middle = (low + high) / 2, half = Math.max((high - low) / 2, this.least) * 1.1;
    // hold the last range unless it is left or far too wide: a scale that breathes cannot be read
    const [l, h] = this.last ?? [0, 0];
    if (!this.last || low < l || high > h || 2 * half < 0.4 * (h - l)) this.last = [middle - 1.15 * half, middle + 1.15 * half];
    return this.last;
  }

  grid(pen, { low, high, right, bottom, x, y, newest }, seconds) {
    pen.font = `12px ${css("--font")}`;
    pen.fillStyle = css("--muted");
    pen.strokeStyle = css("--grid");
    pen.lineWidth = 1;
    const rough = (high - low) / 5, power = 10 ** Math.floor(Math.log10(rough));
    const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= rough);
    const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    for (let k = Math.ceil(low / step); k * step <= high; k += 1) {
      pen.strokeStyle = css(k === 0 ? "--line" : "--grid");
      pen.beginPath();
      pen.moveTo(LEFT, y(k * step));
      pen.lineTo(right, y(k * step));
      pen.stroke();
      pen.fillText((k * step).toFixed(digits), LEFT - 5, y(k * step));
    }
    pen.strokeStyle = css("--grid");
    pen.textBaseline = "alphabetic";
    const room = 1.5 * pen.measureText(`−${seconds} s`).width + APART;
    const every = TICKS.find((one) => (one / seconds) * (right - LEFT) >= room) ?? seconds;
    for (let k = 0; k * every <= seconds; k += 1) {
      const place = x(newest - k * every);
      pen.beginPath();
      pen.moveTo(place, TOP);
      pen.lineTo(place, bottom);
      pen.stroke();
      pen.textAlign = k === 0 ? "right" : k * every === seconds ? "left" : "center"; // the outermost stay inside
      pen.fillText(k ? `−${k * every} s` : "now", place, bottom + 15);
    }
    pen.strokeRect(LEFT, TOP, right - LEFT, bottom - TOP);
  }
}
