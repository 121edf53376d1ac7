// Live values on a canvas: all joints of one quantity over the last seconds.
import { el } from "../base/dom.js";

export const COLOURS = ["#3d8fd6", "#e8842c", "#2fa58a", "#c46ab0", "#b5862a", "#7d72dd", "#8a97a6", "#d8475c"];
const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

/** Rows of telemetry, the newest ones; time on the loop's clock. */
export class Trail {
  constructor(seconds, rate) {
    this.seconds = seconds;
    this.most = Math.ceil(seconds * rate * 1.2);
    this.rows = [];
  }

  add(columns, start, values) {
    this.columns = columns;
    const width = columns.length;
    for (let at = 0; at + width <= values.length; at += width) {
      this.rows.push([start + values[at], values.subarray(at, at + width)]);
    }
    const newest = this.rows.at(-1)?.[0] ?? 0;
    if (this.rows.length && this.rows[0][0] > newest) this.rows = []; // the loop's clock began anew
    if (this.rows.length > 2 * this.most) this.rows = this.rows.slice(-this.most);
  }
}

export class Scope {
  constructor(title, unit, stem, joints, hidden) {
    Object.assign(this, { unit, stem, joints, hidden });
    this.canvas = el("canvas", { role: "img", "aria-label": `${title} of all joints over time` });
    this.box = el("figure", { class: "scope" }, el("figcaption", {}, `${title}, ${unit}`), this.canvas);
  }

  draw(trail) {
    const { canvas } = this, scale = devicePixelRatio || 1;
    const width = canvas.clientWidth, height = canvas.clientHeight;
    if (!width || !trail.columns) return;
    if (canvas.width !== Math.round(width * scale)) canvas.width = Math.round(width * scale);
    if (canvas.height !== Math.round(height * scale)) canvas.height = Math.round(height * scale);
    const pen = canvas.getContext("2d");
    pen.setTransform(scale, 0, 0, scale, 0, 0);
    pen.clearRect(0, 0, width, height);
    const newest = trail.rows.at(-1)?.[0] ?? 0, oldest = newest - trail.seconds;
    const rows = trail.rows.filter(([time]) => time >= oldest);
    const places = Array.from({ length: this.joints }, (_, j) => trail.columns.indexOf(`${this.stem}${j + 1}`));
    const [low, high] = this.range(rows, places);
    const left = 46, right = width - 6, top = 6, bottom = height - 18;
    const x = (time) => left + ((time - oldest) / trail.seconds) * (right - left);
    const y = (value) => bottom - ((value - low) / (high - low)) * (bottom - top);
    this.grid(pen, { low, high, left, right, top, bottom, y, seconds: trail.seconds });
    const step = Math.max(1, Math.floor(rows.length / 900));
    places.forEach((place, j) => {
      if (this.hidden.has(j)) return;
      pen.strokeStyle = COLOURS[j % COLOURS.length];
      pen.lineWidth = 1.4;
      pen.beginPath();
      for (let k = 0; k < rows.length; k += step) pen.lineTo(x(rows[k][0]), y(rows[k][1][place]));
      pen.stroke();
    });
  }

  range(rows, places) {
    let low = Infinity, high = -Infinity;
    for (const [, row] of rows) {
      for (const [j, place] of places.entries()) {
        if (this.hidden.has(j) || !Number.isFinite(row[place])) continue;
        low = Math.min(low, row[place]);
        high = Math.max(high, row[place]);
      }
    }
    if (!(low <= high)) [low, high] = [-1, 1];
    const least = this.stem === "tau" ? 1 : 0.05;
    const middle = (low + high) / 2, half = Math.max((high - low) / 2, least) * 1.1;
    // hold the last range unless it is left or far too wide: a scale that breathes cannot be read
    const [l, h] = this.last ?? [0, 0];
    if (!this.last || low < l || high > h || 2 * half < 0.4 * (h - l)) this.last = [middle - 1.15 * half, middle + 1.15 * half];
    return this.last;
  }

  grid(pen, { low, high, left, right, top, bottom, y, seconds }) {
    pen.font = `11px ${css("--font")}`;
    pen.fillStyle = css("--muted");
    pen.strokeStyle = css("--grid");
    pen.lineWidth = 1;
    const rough = (high - low) / 4, power = 10 ** Math.floor(Math.log10(rough));
    const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= rough);
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    for (let v = Math.ceil(low / step) * step; v <= high; v += step) {
      pen.beginPath();
      pen.moveTo(left, y(v));
      pen.lineTo(right, y(v));
      pen.stroke();
      pen.fillText(String(Number(v.toPrecision(3))), left - 5, y(v));
    }
    pen.textBaseline = "alphabetic";
    pen.fillText("now", right, bottom + 14);
    pen.textAlign = "left";
    pen.fillText(`−${seconds} s`, left, bottom + 14);
    pen.strokeRect(left, top, right - left, bottom - top);
  }
}
