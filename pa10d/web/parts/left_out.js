// Stretches of a run that no fit and no judgement uses: chosen by zooming, kept with the run.
import { el, fill } from "../base/dom.js";
import { patch } from "../base/api.js";
import { loadRuns, state } from "../base/store.js";
import { guarded, notice } from "../base/notices.js";

const SAME = 1e-3; // s: what was sent comes back rounded

/** span(): what is zoomed to; runs(): ids of those that are seen; then `changed()`. */
export function leftOut(span, runs, changed) {
  const box = el("div", { class: "row" });
  const of = (id) => state.runs.find((run) => run.id === id);
  const keep = async (id, excluded) => {
    await patch(`runs/${id}`, { excluded });
    await loadRuns();
    changed();
  };
  const refresh = () => {
    const seen = runs().map(of).filter(Boolean), stretch = span();
    const within = (run) => [Math.max(0, stretch[0]), Math.min(run.duration, stretch[1])];
    const gone = Boolean(stretch) && seen.every((run) => run.excluded.some(([begin, end]) => begin <= within(run)[0] + SAME && end >= within(run)[1] - SAME));
    const leave = el("button", { type: "button", class: "small", disabled: !stretch || !seen.length || gone, title: !stretch ? "zoom to the stretch first" : gone ? "it is left out already" : "", onclick: guarded("It could not be left out.", async () => {
      for (const run of seen) await keep(run.id, [...run.excluded, within(run)]);
      notice("Left out of every fit and judgement from now on.", { detail: "Models that were fitted before stay as they are." });
    }) }, "Leave this stretch out of fits");
    fill(box, leave, seen.flatMap((run) => run.excluded.map(([begin, end], k) => el("span", { class: "tag" }, `${run.name}: ${begin.toFixed(2)} to ${end.toFixed(2)} s left out `,
      el("button", { type: "button", class: "link", "aria-label": `use again ${begin.toFixed(2)} to ${end.toFixed(2)} s of ${run.name}`, onclick: guarded("It stays left out.", () => keep(run.id, run.excluded.filter((_, i) => i !== k))) }, "use again")))));
  };
  return { box, refresh, stretches: () => (runs().length === 1 ? of(runs()[0])?.excluded ?? [] : []) };
}
