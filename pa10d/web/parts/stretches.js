// Stretches of runs that one fit does not use: those that the runs leave out anyway, and others.
import { el, fill } from "../base/dom.js";
import { failed } from "../base/notices.js";
import { state } from "../base/store.js";

/** {box, read(), refresh()}, the last for when others are chosen; `runs`: the picker of the runs that are fitted to. */
export function stretches(runs) {
  let own = []; // {run, begin, end}
  const time = (id, label) => el("input", { id, type: "number", min: 0, step: "any", size: 6, class: "short", "aria-label": label, placeholder: label.split(",")[0] });
  const which = el("select", { id: "fit-stretch", "aria-label": "run of which something is left out" });
  const begin = time("fit-begin", "from, s"), end = time("fit-end", "to, s"), said = el("ul", { class: "plain", "aria-label": "left out of this fit" });
  const chosen = () => state.runs.filter((run) => runs.ids.includes(run.id));
  const refresh = () => {
    own = own.filter((one) => chosen().some((run) => run.id === one.run));
    const before = which.value;
    fill(which, chosen().map((run) => el("option", { value: run.id }, run.name)));
    if (chosen().some((run) => run.id === before)) which.value = before;
    const name = (id) => chosen().find((run) => run.id === id).name;
    const words = (run, from, to) => `${run}: ${from.toFixed(2)} to ${to.toFixed(2)} s`;
    fill(said, chosen().flatMap((run) => run.excluded.map(([from, to]) => el("li", {}, words(run.name, from, to), " ", el("small", {}, "of every fit")))),
      own.map((one) => el("li", {}, words(name(one.run), one.begin, one.end), " ",
        el("button", { type: "button", class: "link", "aria-label": `use ${words(name(one.run), one.begin, one.end)} after all`, onclick: () => { own = own.filter((other) => other !== one); refresh(); which.focus(); } }, "use it"))));
  };
  const add = el("button", { type: "button", class: "small", onclick: () => {
    const run = chosen().find((one) => one.id === which.value), from = begin.valueAsNumber, to = end.valueAsNumber;
    if (!run || !(from >= 0 && from < to && to <= run.duration)) {
      return failed("That is no stretch.", new Error(run ? `expected two times from 0 to ${run.duration.toFixed(2)} s, the first one smaller` : "choose a run to fit to first"));
    }
    own.push({ run: run.id, begin: from, end: to });
    begin.value = end.value = "";
    refresh();
  } }, "Leave it out");
  refresh();
  return {
    box: el("div", { class: "field rare" }, el("label", { htmlFor: which.id }, "leave out of this fit"), el("span", { class: "row" }, which, begin, end, add), said,
      el("small", {}, "s since the run's first sample; for all fits: zoom to it in Explore")),
    refresh, read: () => own,
  };
}
