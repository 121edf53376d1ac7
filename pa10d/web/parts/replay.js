// A recording as the arm went through it: to be played, and to follow the cursor of any plot.
import { el } from "../base/dom.js";
import { table } from "../base/columns.js";
import { armView, inWords, unitOfAll } from "./arm.js";

const POSES = 2400, FRAME = 50; // of a run that are fetched; ms

/** {box, open(query, name, joints), point(seconds), light(joints)}; query: {run} or {fault}. */
export function replay(label = "The arm at the cursor") {
  const play = el("button", { type: "button", class: "small", "aria-label": "play the recording", disabled: true }, "▶ Play");
  const slider = el("input", { type: "range", min: 0, max: 1, step: "any", value: 0, class: "grow", "aria-label": "time in the recording, s" });
  const view = armView(label, el("div", { class: "row player" }, play, slider));
  let track = null, timer = null, asked = 0, pointed = 0;
  const point = (seconds) => {
    if (!track) return;
    const { time, columns } = track, last = time.length - 1;
    const at = Math.min(Math.max((seconds - time[0]) / (time[last] - time[0] || 1), 0), 1) * last;
    const below = Math.floor(at), share = at - below, above = Math.min(below + 1, last);
    const q = columns.map((column) => column[below] + share * (column[above] - column[below]));
    slider.value = seconds;
    slider.setAttribute("aria-valuetext", `${seconds.toFixed(2)} s`);
    view.show({ q, words: `At ${seconds.toFixed(2)} s, ${unitOfAll()}:   ${inWords(q)}` });
  };
  const halt = () => { clearInterval(timer); timer = null; play.textContent = "▶ Play"; };
  play.addEventListener("click", () => {
    if (timer) return halt();
    if (!track) return;
    const end = track.time.at(-1), from = Number(slider.value) >= end - 0.05 ? 0 : Number(slider.value), began = performance.now();
    play.textContent = "❚❚ Pause";
    timer = setInterval(() => {
      const now = from + (performance.now() - began) / 1000;
      point(Math.min(now, end));
      if (now >= end || !view.box.isConnected) halt();
    }, FRAME);
  });
  slider.addEventListener("input", () => { halt(); point(Number(slider.value)); });
  return {
    box: view.box,
    point(seconds) {
      pointed = seconds;
      if (!timer) point(seconds);
    },
    light: (lit) => view.show({ lit }),
    async open(query, name, joints) {
      const mine = ++asked;
      halt();
      play.disabled = true; // until there is something to play
      const channel = Array.from({ length: joints }, (_, j) => `q${j + 1}`);
      const found = await table("columns", { ...query, channel, points: POSES, every: true });
      if (mine !== asked) return;
      const { time, ...rest } = found.columns;
      track = { time, columns: channel.map((one) => rest[one]) };
      slider.max = time.at(-1);
      play.disabled = false;
      view.show({ name: `${label}: ${name}` });
      point(Math.min(Math.max(pointed, time[0]), time.at(-1))); // where the cursor went as it came
    },
  };
}
