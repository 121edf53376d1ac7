// What the daemon is working on: the bar at the bottom, and following one job to its end.
import { el, fill, say } from "../base/dom.js";
import { get, post } from "../base/api.js";
import { MOVES, over, running } from "../base/condition.js";
import { change, state, watch } from "../base/store.js";
import { guarded } from "../base/notices.js";

const WORDS = {
  experiment: "Experiment", series: "Experiments", tracking: "Control laws", check: "Pre-check", identify: "Fit",
  compare: "Comparison", diagnose: "Diagnosis", add: "Adding an effect", improve: "Improvement",
  improvement: "Improvement", preparation: "Plan", investigation: "Investigation", analysis: "Investigation", report: "Report", weighing: "Known weight", gains: "Known weight",
};
const waiting = new Map();

export function jobChanged(job) {
  state.jobs.set(job.id, job);
  change({ jobs: state.jobs });
  if (over(job)) settle(job);
}

/** The whole job once it has succeeded; throws its error otherwise, `wished` where somebody ended
 * it. Survives a lost event. */
export async function finished(job) {
  jobChanged(job);
  if (!over(job)) {
    await new Promise((done) => {
      waiting.set(job.id, done);
      const look = async () => {
        if (!waiting.has(job.id)) return;
        try {
          const now = await get(`jobs/${job.id}`);
          if (over(now)) return jobChanged({ ...now, result: undefined });
        } catch { /* the connection is lost: look again */ }
        setTimeout(look, 3000);
      };
      setTimeout(look, 3000);
    });
  }
  const whole = await get(`jobs/${job.id}`);
  if (whole.status === "succeeded") return whole;
  throw Object.assign(new Error(whole.error ?? "It was cancelled."), { wished: whole.status === "cancelled" });
}

function settle(job) {
  waiting.get(job.id)?.();
  waiting.delete(job.id);
}

/** A bar with message and cancel button, for the job that `pick` gives. */
export function progress(pick) {
  const bar = el("progress", { max: 1, value: 0 });
  const text = el("span", { class: "grow" });
  const cancel = el("button", { type: "button", class: "small" }, "Cancel");
  const box = el("div", { class: "progress", hidden: true }, bar, text, cancel);
  cancel.addEventListener("click", guarded("It could not be cancelled.", async () => {
    const job = pick();
    if (job) jobChanged(await post(`jobs/${job.id}/cancel`));
  }));
  watch(["jobs"], () => {
    const job = pick();
    box.hidden = !job;
    if (!job) return;
    bar.value = job.progress;
    say(text, job.status === "queued" ? `${WORDS[job.kind] ?? job.kind}: waits for its turn`
      : `${WORDS[job.kind] ?? job.kind}: ${job.message || job.status}, ${Math.round(100 * job.progress)} %`);
    say(cancel, MOVES.includes(job.kind) ? "Abort" : "Cancel");
  });
  return box;
}

export function tray(box) {
  const idle = el("span", { class: "muted grow" });
  const bar = progress(() => running().sort((a, b) => moving(b) - moving(a))[0]);
  const more = el("span", { class: "muted" });
  fill(box, idle, bar, more);
  watch(["jobs", "condition"], () => {
    const lost = state.condition.kind === "lost";
    box.classList.toggle("old", lost);
    const now = running();
    idle.hidden = now.length > 0;
    say(more, [now.length > 1 ? `and ${now.length - 1} more` : "", lost ? `(as of ${state.condition.old} s ago)` : ""].filter(Boolean).join(" "));
    const last = [...state.jobs.values()].filter(over).sort((a, b) => (a.finished < b.finished ? -1 : 1)).at(-1);
    say(idle, state.condition.kind === "unknown" ? "What is running is not known yet." : last ? `Last: ${WORDS[last.kind] ?? last.kind} ${howItEnded(last)}${last.error ? `: ${last.error}` : ""}` : "Nothing is running.");
    idle.classList.toggle("bad", last?.status === "failed");
  });
}

/** A pause is a good end of the job, and none of the investigation. */
const howItEnded = (job) => job.message === "stopped" ? "stopped"
  : job.status === "succeeded" && state.investigations.find((one) => one.id === job.request?.investigation)?.status === "paused" ? "paused" : job.status;

const moving = (job) => Number(MOVES.includes(job.kind));
