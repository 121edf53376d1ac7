// The one next step from an empty bench to a lower error, at the head of every section.
import { el, fill } from "../base/dom.js";
import { get } from "../base/api.js";
import { change, current, state, tagged, watch } from "../base/store.js";
import { running } from "../base/condition.js";
import { reportButton } from "./report.js";

/** Marks of a run that was made to settle a doubt. */
export const SETTLES = ["fit", "judge"];

const diagnosed = new Map(); // id of a diagnosis -> its result, or the promise of it

/** The newest diagnosis of this model that is done, with its result; undefined while unknown. */
export function lastDiagnosis(model) {
  const job = state.diagnoses.find((one) =>
    one.status === "succeeded" && [model.name, model.id].includes(one.request.model));
  if (!job) return null;
  const known = diagnosed.get(job.id);
  if (known?.result) return known;
  if (!known) {
    diagnosed.set(job.id, get(`diagnoses/${job.id}`).then((whole) => {
      diagnosed.set(job.id, whole);
      change({ searched: diagnosed.size }); // every heading waits for it
    }, () => diagnosed.delete(job.id)));
  }
  return undefined;
}

/** The version in which a finding was added to this model already. */
export const versionWith = (model, finding) => current().find((other) =>
  other.parent === model.id && other.change.startsWith(`added ${finding.effect}`)
  && finding.joints.every((j) => other.change.includes(`J${j}`)));

/** The model of a diagnosis, and the versions in which its findings were added, in their order. */
export function addedOf(diagnosis) {
  const versions = [state.models.find((one) => [one.id, one.name].includes(diagnosis.request.model))];
  for (const finding of versions[0] ? diagnosis.result.findings : []) {
    const next = versionWith(versions.at(-1), finding);
    if (!next) break;
    versions.push(next);
  }
  return versions;
}

/** The last search that a version came from: {diagnosis, versions}; null: none; undefined: not known yet. */
function searchBehind(model) {
  for (let base = parentOf(model); base; base = parentOf(base)) {
    const diagnosis = lastDiagnosis(base);
    if (diagnosis === undefined) return undefined;
    const versions = diagnosis ? addedOf(diagnosis) : [];
    if (versions.some((one) => one?.id === model.id)) return { diagnosis, versions };
    if (diagnosis) return null;
  }
  return null;
}

const parentOf = (model) => state.models.find((one) => one.id === model.parent);

/** What the newest investigation asks for: to be gone on with, or to be read; nothing once a newer model was made. */
function lastInvestigation(newest) {
  const [last] = state.investigations;
  if (!last) return null;
  const step = { go: "investigate", at: last.id }, said = `The investigation ‘${last.name}’`;
  if (last.status === "waiting") return { ...step, text: `${said} is planned; nothing has moved for it yet. Look at what will be done, then start it.`, label: "Start" };
  if (last.status === "running") return { ...step, text: `${said} is under way.`, label: "Watch" };
  if (["paused", "stopped", "failed"].includes(last.status)) return { ...step, text: `${said} is ${last.status}; what is done stays done. Go on with it.`, label: "Go on" };
  const own = newest?.name.startsWith(`${last.name}-m`);
  return last.status === "done" && (own || newest?.created <= last.created)
    ? { ...step, text: `${said} is done. Read its report${own ? `; its last model is ${newest.name}` : ""}.`, label: "Read" } : null;
}

function nextStep() {
  if (state.condition.next) return state.condition.next;
  const fit = tagged("fit"), judge = tagged("judge"), models = current();
  if (running("identify", "compare", "diagnose", "add", "improve").length) {
    return { text: "Wait: the daemon is computing. The bar at the bottom shows how far it is." };
  }
  if (models.length && changesUnasked()) return { ...NEXT_DAY, text: `It is day 2: something may have happened to the arm. Ask what has changed since ${models[0].name}.` };
  const investigated = lastInvestigation(models[0]);
  if (investigated) return investigated;
  if (!state.runs.length) {
    return canMove()
      ? { go: "investigate", text: "Nothing is recorded yet. Investigate: all of it by one button. Or step by step: Record the starting set, motions to fit a model to and others to judge it by.", label: "Investigate",
          then: { go: "investigate", label: "Investigate", text: "Nothing is recorded yet. Step by step, the starting set comes first; or all of it goes by one button here.", also: STARTING_SET },
          also: { ...STARTING_SET, text: "Nothing is recorded yet. The starting set has motions to fit a model to, and others to judge it by." } }
      : { go: "runs", text: "Nothing is recorded yet. Drop recordings (CSV) into Runs: at least one to fit a model to, one of another motion to judge it by.", label: "Import" };
  }
  if (!fit.length || !judge.length) {
    const what = !fit.length && !judge.length ? "which runs models are fitted to ('fit'), and which others they are judged by ('judge')"
      : fit.length ? "a run that models are judged by ('judge'), of another motion" : "a run that models are fitted to ('fit')";
    return { go: "runs", text: `Mark ${what}.`, label: "Mark" };
  }
  if (judge.every((run) => fit.includes(run)) && state.runs.length > fit.length) {
    return { go: "runs", text: "Models are judged by nothing but runs that they are fitted to, where every error looks smaller than it is. Mark another motion as 'judge'.", label: "Mark" };
  }
  if (!models.length) return { go: "models", text: `Fit the first model: rigid bodies and textbook friction, to ${fit.length} run${fit.length > 1 ? "s" : ""}.`, label: "Fit" };
  const newest = models[0];
  const compared = state.comparisons.some((one) => one.status === "succeeded" && [newest.name, newest.id].includes(one.request.model));
  const found = lastDiagnosis(newest);
  if (found === undefined) return { text: "" };
  if (found) return afterDiagnosis(newest, found);
  if (!compared && !newest.parent) return { go: "compare", at: `of/${newest.name}`, text: `See where ${newest.name} fails on runs that it was not fitted to.`, label: "Compare" };
  const behind = searchBehind(newest);
  if (behind === undefined) return { text: "" };
  const diagnose = { go: "diagnose", at: `of/${newest.name}`, label: "Diagnose" };
  if (!behind) {
    return newest.change.startsWith("added smooth_map") ? seeFall(newest, "has a map where something is missing", diagnose)
      : { ...diagnose, text: `Ask which physical effect is missing in ${newest.name}.` };
  }
  const { diagnosis, versions } = behind, next = diagnosis.result.findings[versions.length - 1];
  if (next) {
    return { go: "diagnose", at: diagnosis.id, label: "Read",
             text: `The same search found more: ${effectIn(next)} is not in ${versions.at(-1).name} yet. Read the finding, and add it before asking anew.` };
  }
  return seeFall(newest, "has what was missing", diagnose);
}

const effectIn = (finding) =>
  `${finding.effect.replaceAll("_", " ")}${finding.joints.length ? ` in joint ${finding.joints.join(" and ")}` : ""}`;

const seeFall = (model, has, diagnose) => ({
  go: "models", at: model.name, text: `${model.name} ${has}. See how far the error fell.`, label: "See",
  then: { ...diagnose, text: `Below is how far the error fell. Ask whether anything is left in ${model.name}.` } });

function afterDiagnosis(model, diagnosis) {
  const { findings, verdict } = diagnosis.result;
  const open = findings.slice(addedOf(diagnosis).length - 1);
  const doubt = open.find((one) => one.next_experiment);
  const settling = doubt && state.runs.filter((run) => run.kind === doubt.next_experiment.kind && SETTLES.every((tag) => run.tags.includes(tag)));
  if (doubt && !settling.length && canMove()) {
    return { go: "diagnose", at: diagnosis.id, text: `Something is missing in ${model.name}, but this data cannot tell what: run the experiment that settles it.`, label: "Settle" };
  }
  if (doubt && settling.some((run) => run.created > diagnosis.created)) {
    return { go: "diagnose", at: `of/${model.name}`, text: `The experiment that settles the doubt is recorded: diagnose ${model.name} again.`, label: "Diagnose" };
  }
  if (open.length) {
    return { go: "diagnose", at: diagnosis.id, text: `Something is missing in ${model.name}. Read the finding, then add it to the model.`, label: "Read" };
  }
  if (verdict === "none" && state.story?.hides && state.story.day === 1 && !state.story.hidden) {
    return { ...NEXT_DAY, text: `Nothing significant is missing in ${model.name}. Something may happen to this arm over night: let one pass, and ask what has changed.` };
  }
  if (verdict === "none") {
    return { go: "models", at: model.name, text: `Nothing significant is missing in ${model.name}. Load it into the controller, or export it.`, label: "Models" };
  }
  return { go: "diagnose", at: diagnosis.id, text: `What is left in ${model.name} is like no known effect: the map shows where it is.`, label: "Map" };
}

const NEXT_DAY = { go: "investigate", label: "Investigate" };

/** A virtual arm's night has passed, and nobody has asked what it brought. */
export const changesUnasked = () => state.story?.hides && state.story.day === 2 && !state.story.hidden
  && !state.investigations.some((one) => one.question === "changed") && !state.diagnoses.some((one) => one.request.frozen);

/** Is there an arm to record from, powered or not? */
export const canMove = () => state.robot && (state.robot.state !== "offline" || state.robot.axes.length > 0);

const STARTING_SET = { go: "experiments", label: "Record" };

/** Where the step is to look at something, and one is there already, the step after it. */
const forSection = (step, section) => (step.go === section && step.then ? step.then : step.also?.go === section ? { ...step, ...step.also } : step);

/** Head of a section: its title, and the next step. `here` says what to press, in this section. */
export function heading(section, title, here = {}) {
  const words = el("span", {}), link = el("a", { class: "button small" });
  const line = el("p", { role: "status", class: "guide", dataset: { guide: section } }, el("b", {}, "Next step "), words, link);
  let other = null;
  const refresh = () => {
    if (!state.ready) return;
    const step = forSection(nextStep(), section);
    line.style.visibility = step.text ? "visible" : "hidden";
    line.dataset.go = step.go ?? "";
    fill(words, step.text, step.go === section && here[step.label] ? ` ${here[step.label]}` : "");
    link.hidden = !step.go || step.go === section;
    link.textContent = step.label ?? "";
    link.href = `#/${[step.go ?? section, step.at].filter(Boolean).join("/")}`;
    other?.remove();
    other = step.also && step.also.go !== section ? el("a", { class: "button small", href: `#/${step.also.go}` }, step.also.label) : null;
    if (other) line.append(other);
  };
  watch(["runs", "models", "comparisons", "diagnoses", "jobs", "condition", "searched", "investigations", "story", "ready"], refresh);
  const report = reportButton(() => current()[0].name, () => tagged("judge").map((run) => run.id));
  watch(["models"], () => {
    report.hidden = !current().length || section === "models"; // there it is of the model that is shown
    report.textContent = `Report on ${current()[0]?.name}`;
  });
  return el("div", { class: "heading" }, el("h1", { id: `${section}-title` }, title), line, report);
}
