// The newest rows of telemetry, and what happened among them; time on the loop's clock.
export class Trail {
  constructor(kept, { rate, columns, states, joints }) {
    Object.assign(this, { kept, states, columns, joints, seconds: kept, rows: [], marks: [], heard: 0 });
    this.most = Math.ceil(kept * rate * 1.2);
    this.place = Object.fromEntries(columns.map((name, k) => [name, k]));
  }

  get newest() { return this.rows.at(-1)?.[0] ?? 0; }

  /** The rows of the seconds that are shown. */
  seen() {
    const oldest = this.newest - this.seconds;
    const first = this.rows.findIndex(([time]) => time >= oldest);
    return this.rows.slice(Math.max(0, first));
  }

  /** The newest positions. */
  pose() {
    const row = this.rows.at(-1)[1], first = this.place.q1;
    return Array.from({ length: this.joints.length }, (_, j) => row[first + j]);
  }

  add(start, values) {
    const width = this.columns.length;
    this.heard = performance.now();
    if (this.rows.length && start < this.newest) Object.assign(this, { rows: [], marks: [], last: null }); // the loop's clock began anew
    for (let at = 0; at + width <= values.length; at += width) {
      const row = values.subarray(at, at + width), time = start + values[at];
      this.notice(time, row);
      this.rows.push([time, row]);
    }
    if (this.rows.length > 2 * this.most) this.rows = this.rows.slice(-this.most);
    this.marks = this.marks.filter((mark) => mark.time >= this.newest - this.kept);
  }

  notice(time, row) {
    const state = row[this.place.state], before = this.last;
    this.last = state;
    if (before === null || before === undefined || state === before) return;
    const word = this.states[state] ?? "";
    this.marks.push({ time, word, bad: word === "fault" });
  }
}
