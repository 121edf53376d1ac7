// Choose a model, and runs: those marked 'fit' or 'judge' are chosen until somebody chooses others.
import { el, fill, refill } from "../base/dom.js";
import { current, state, tagged, watch } from "../base/store.js";
import { seconds, titled } from "../base/units.js";

export function modelPicker(label, onChange = () => {}) {
  const select = el("select", { onchange: () => { select.dataset.chosen = "yes"; onChange(); } });
  let wanted = null, newest = null;
  watch(["models"], () => {
    const names = current().map((model) => model.name);
    if (newest !== names[0]) delete select.dataset.chosen; // a model was made: the next question is about it
    newest = names[0];
    const keep = wanted ?? (names.includes(select.value) && select.dataset.chosen ? select.value : names[0]);
    fill(select, names.map((name) => el("option", { value: name }, name)));
    if (!names.length) fill(select, el("option", { value: "" }, "no model yet"));
    if (keep && names.includes(keep)) {
      select.value = keep;
      if (keep === wanted) wanted = null;
    }
    onChange();
  }, select);
  return {
    box: el("label", { class: "picker" }, el("span", {}, label), select),
    get value() { return select.value; },
    set value(name) {
      select.dataset.chosen = "yes";
      wanted = current().some((model) => model.name === name) ? null : name;
      if (!wanted) select.value = name;
    },
  };
}

/** Several runs; `tag` says which are chosen at first. Where none is tagged so: those that `otherwise`
    names. */
export function runPicker(label, tag, onChange = () => {}, otherwise = () => []) {
  const list = el("div", { class: "choices" });
  const summary = el("summary", {});
  let own = null; // ids chosen by hand
  const named = () => otherwise().map(runOf).filter((run) => run && run.status !== "started");
  const chosen = () => {
    if (own) return own;
    const marked = tagged(tag);
    return (marked.length ? marked : named()).map((run) => run.id);
  };
  const refresh = () => {
    const ids = chosen();
    const runs = state.runs.filter((run) => run.status !== "started");
    const names = runs.filter((run) => ids.includes(run.id)).reverse().map((run) => run.name);
    fill(summary, el("span", {}, label), el("b", {}, names.length ? names.join(", ") : "none yet"));
    refill(list, runs.map((run) => el("label", {},
      el("input", { type: "checkbox", value: run.id, checked: ids.includes(run.id), onchange: (event) => {
        const now = new Set(chosen());
        if (event.target.checked) now.add(run.id);
        else now.delete(run.id);
        own = [...now];
        refresh();
      } }), `${run.name} `, el("small", {}, [run.kind && titled(run.kind), seconds(run.duration)].filter(Boolean).join(", ")))));
    onChange();
  };
  watch(["runs", "models", "comparisons"], refresh);
  const box = el("details", { class: "picker runs" }, summary, list);
  box.addEventListener("keydown", (event) => { if (event.key === "Escape" && box.open) { box.open = false; summary.focus(); } });
  document.addEventListener("pointerdown", (event) => { if (!box.contains(event.target)) box.open = false; });
  return {
    box,
    get ids() { return chosen().filter((id) => state.runs.some((run) => run.id === id)); },
    set ids(value) { own = value; refresh(); },
    refresh,
  };
}

/** What a model was fitted to, and what it was compared with last that it had not seen. */
export const fittedTo = (name) => current().find((model) => model.name === name)?.runs ?? [];
export const judgedBy = (name) => {
  const seen = new Set(fittedTo(name).map((run) => runOf(run)?.id));
  const model = current().find((one) => one.name === name);
  const last = state.comparisons.find((one) => one.status === "succeeded" && [name, model?.id].includes(one.request.model));
  return (last?.request.runs ?? []).filter((run) => !seen.has(runOf(run)?.id));
};

const runOf = (run) => state.runs.find((one) => one.id === run || one.name === run);
export const nameOf = (run) => runOf(run)?.name ?? run;
