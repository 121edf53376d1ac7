// Motions that teach something: the starting set, every kind with its form, and what came out.
import { el, fill } from "../base/dom.js";
import { post } from "../base/api.js";
import { whyNot } from "../base/condition.js";
import { current, state, watch } from "../base/store.js";
import { failed, guarded, notice } from "../base/notices.js";
import { seconds, titled } from "../base/units.js";
import { lawOf, lawsWith } from "../parts/laws.js";
import { formOf } from "../parts/form.js";
import { tabsByKeys } from "../parts/tabs.js";
import { heading } from "../parts/guide.js";
import { finished } from "../parts/jobs.js";
import { planned } from "../parts/planned.js";
import { nameOf } from "../parts/picker.js";
import { weighingPanel } from "../parts/weighing.js";

let chosen = "excitation";

export function mount(box) {
  const kinds = tabsByKeys(el("div", { class: "kinds", role: "tablist", "aria-label": "kinds of experiment" }));
  const form = el("div", { class: "panel grow" });
  const outcome = el("div", { id: "outcome", "aria-live": "polite" });
  fill(box, heading("experiments", "Experiments", { Record: "Press 'Record the starting set'." }),
    startingSet(outcome),
    el("h2", {}, "One experiment"), el("div", { class: "columns" }, kinds, form), outcome, weighingPanel());
  watch(["kinds"], () => {
    if (!state.kinds.length) return;
    fill(kinds, state.kinds.map((kind) => el("button", {
      type: "button", role: "tab", class: "kind", "aria-selected": String(kind.kind === chosen), dataset: { kind: kind.kind },
      onclick: (event) => {
        chosen = kind.kind;
        for (const other of kinds.children) other.setAttribute("aria-selected", String(other === event.currentTarget));
        fill(form, editor(kind, outcome));
      },
    }, el("b", {}, titled(kind.kind)), el("small", {}, kind.title))));
    fill(form, editor(state.kinds.find((kind) => kind.kind === chosen), outcome));
  });
}

function startingSet(outcome) {
  const list = el("ol", { class: "set" });
  const start = el("button", { type: "button", class: "primary", onclick: guarded("The experiments could not be started.", async () => {
    const experiments = state.startingSet.map(({ kind, parameters, tags }) => ({ kind, parameters, tags }));
    await follow(await post("experiments/series", { experiments }), outcome);
  }) }, "Record the starting set");
  watch(["kinds"], () => fill(list, state.startingSet.map((one) =>
    el("li", {}, el("b", {}, `${titled(one.kind)}:`), ` ${one.why} `, one.tags.map((tag) => el("span", { class: "tag" }, tag))))));
  watch(["robot", "jobs", "condition"], () => allow(start));
  return el("div", { class: "panel" }, el("div", { class: "row between" }, el("h2", {}, "Starting set"), start),
    el("p", { class: "muted" }, "For an arm of which nothing is known yet. Each motion is checked against limits, torque and collisions before it starts; the arm is powered for it, and left as it was found."), list);
}

/** Buttons that move the arm say why they cannot. */
function allow(button) {
  const why = whyNot();
  button.disabled = Boolean(why);
  button.title = why;
}

function editor(kind, outcome) {
  const form = formOf(kind.parameters);
  const name = el("input", { id: "run-name", maxLength: 100, placeholder: `${kind.kind} (numbered)` });
  const tags = ["fit", "judge"].map((tag) => el("input", { type: "checkbox", value: tag, id: `tag-${tag}` }));
  const controller = el("select", { id: "run-controller" }, el("option", { value: "" }, "as it is"),
    el("option", { value: "pid" }, "PID"), lawsWith(current().map((model) => model.name)));
  const checks = el("div", { class: "checks" });
  const request = () => ({
    kind: kind.kind, parameters: form.read(), tags: tags.filter((tag) => tag.checked).map((tag) => tag.value),
    ...(name.value.trim() ? { name: name.value.trim() } : {}), ...lawOf(controller.value),
  });
  const check = el("button", { type: "button" }, "Check");
  const start = el("button", { class: "primary" }, "Start");
  check.addEventListener("click", guarded("The pre-check could not be made.", async () => {
    if (!box.reportValidity()) return;
    fill(checks, el("p", { class: "muted" }, "Checking …"));
    const job = await finished(await post("experiments/check", request())).catch((error) => {
      fill(checks, el("p", { class: "bad" }, error.message));
    });
    if (job) fill(checks, verdict(job.result));
  }));
  const box = el("form", { onsubmit: (event) => event.preventDefault() },
    el("h2", {}, titled(kind.kind), " ", el("small", {}, kind.title)), el("p", { class: "muted" }, kind.description), form.box,
    el("fieldset", {}, el("legend", {}, "The run"), el("div", { class: "fields" },
      el("div", { class: "field" }, el("label", { htmlFor: "run-name" }, "name"), name, el("small", {}, "under which it is stored")),
      el("div", { class: "field" }, el("label", { htmlFor: "run-controller" }, "controller"), controller, el("small", {}, "that moves the arm")),
      el("div", { class: "field" }, el("span", { class: "label" }, "use it to"), el("div", { class: "row" },
        tags.map((tag) => el("label", { htmlFor: tag.id }, tag, ` ${tag.value}`))), el("small", {}, "fit models to it, or judge them by it")))),
    el("div", { class: "row" }, check, start), checks);
  box.addEventListener("submit", () => guarded("The experiment could not be started.", async () => {
    await follow(await post("experiments", request()), outcome);
  })({ currentTarget: start }));
  watch(["robot", "jobs", "condition"], () => allow(start), box);
  return box;
}

function verdict(found) {
  return [
    el("p", {}, el("b", { class: found.go ? "good" : "bad" }, found.go ? "Go. " : "No go. "), `The motion takes ${seconds(found.seconds)}.`),
    found.adjusted ? el("p", { class: "warn", dataset: { adjusted: found.adjusted.pace } }, found.adjusted.sentence) : null,
    planned(found),
    el("ul", { class: "levels" }, found.checks.map((one) =>
      el("li", { class: one.level }, el("b", {}, one.level), ` ${one.sentence}`))),
    found.plan.notes.map((note) => el("p", { class: "muted" }, note)),
  ];
}

/** Until it is over; what it said stands under the form. */
async function follow(job, outcome) {
  fill(outcome);
  finished(job).then(
    (whole) => {
      const found = whole.result.experiments ?? [whole.result];
      const names = whole.result.runs.map(nameOf);
      notice(`Recorded ${names.join(", ")}.`, { action: { href: "#/runs", label: "Look" } });
      fill(outcome, el("div", { class: "panel" }, el("h2", {}, "What came out"), found.map((one) => [
        el("p", {}, el("b", {}, one.recorded.map((run) => run.name).join(", ")), ` (${titled(one.kind)})`),
        (one.notes ?? []).map((note) => el("p", { class: "warn" }, note)),
        (one.tuned ?? []).map((line) => el("p", { class: "muted" }, line)),
        el("ul", {}, one.recommendation.map((sentence) => el("li", {}, sentence))),
      ])));
    },
    (error) => {
      failed("The experiment did not end well.", error);
      fill(outcome, el("div", { class: "panel" }, el("p", { class: "bad" }, error.message)));
    },
  );
}
