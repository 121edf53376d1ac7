// What may be said of the arm, by header, guide, cards and plots alike. Connection, fault and what
// the arm does come first, then what waits for it; old values are called old.
import { client } from "./api.js";
import { change, state, watch } from "./store.js";

const OLD = 3000, LOOK = 500; // ms
/** Kinds of jobs that move the arm. */
export const MOVES = ["experiment", "series", "tracking", "improvement", "investigation", "weighing"];
const EMERGENCY = "If the arm moves, press the hardware emergency stop.";
const MEANS = {
  offline: "No drive answers.",
  inactive: "Unpowered, brakes on. Angles are read. An experiment powers the arm by itself.",
  enabling: "The drives are being powered and the brakes released.",
  holding: "Powered; the controller holds the arm where it is.",
  running: "The arm is moving.",
  stopping: "The arm is coming to rest.",
  disabling: "The brakes are being put on and the drives switched off.",
  fault: "A fault has stopped the arm.",
};
const MOVING = ["enabling", "running", "stopping", "disabling"];

export const over = (job) => ["succeeded", "failed", "cancelled"].includes(job.status);
export const running = (...kinds) =>
  [...state.jobs.values()].filter((job) => !over(job) && (!kinds.length || kinds.includes(job.kind)));
/** The job that moves the arm, or will. */
export const moves = () => running(...MOVES).sort((a, b) => (a.status === "running" ? -1 : 0) - (b.status === "running" ? -1 : 0))[0];

/** kind, word, meaning, and `next` where it comes before the story; `old`: s since anything was
 * heard; `silent`: who it is that does not answer; `frozen`: nothing is read any more, the values
 * are those from before the fault. */
function judged() {
  const { robot, heard } = state;
  const since = heard === null ? Infinity : performance.now() - heard;
  if (!robot) return { kind: "unknown", word: "…", meaning: "", old: 0, next: null };
  if (!state.connected || since > OLD) return lost(Math.round(since / 1000));
  const quiet = 1000 * robot.quiet + since;
  if (1000 * robot.quiet >= OLD && robot.state !== "offline") return hanging(Math.round(quiet / 1000));
  const job = moves();
  const found = { kind: robot.state, word: robot.state, meaning: MEANS[robot.state] ?? `The arm is ${robot.state}.`, old: 0, next: null,
                  frozen: robot.state === "fault" && (performance.now() - state.ticked > OLD || (robot.axes.length > 0 && robot.axes.every((axis) => axis.silent))) };
  if (robot.state === "fault") {
    const cause = closed(robot.fault?.sentence ?? MEANS.fault), holder = robot.lease.holder;
    const way = mayCommand(client) ? "Remove its cause, then press Reset."
      : `Remove its cause; ${holder} commands the arm and may reset it, you as soon as the command is given back.`;
    return { ...found, meaning: `${cause} ${way}`,
             next: { go: "robot", text: `A fault has stopped the arm: ${closed(inShort(cause))} ${way}`, label: mayCommand(client) ? "Reset" : "Look" } };
  }
  if (robot.offline_passes) {
    const text = `The arm is not there yet: ${robot.offline_reason ?? "it is being connected"}. That takes some seconds, after an installation or an update a minute or two.`;
    return { ...found, meaning: text, next: { text } };
  }
  if (robot.state === "offline") {
    found.meaning = `No drive answers: ${closed(robot.offline_reason ?? "it is not known why")} You can work with recordings all the same: import them in Runs.`;
  }
  if (doubted(robot)) {
    return { ...found, meaning: "Unpowered, brakes on. Angles are read, but not all of them are believed.",
             next: { go: "robot", text: `The arm is not powered before somebody has looked at it: ${inPlaces(robot)}.`, label: "Look" } };
  }
  if (sinking(robot)) {
    return { ...found, meaning: "Powered; the controller holds the arm, which its brakes alone would not.",
             next: { go: "robot", text: `${capital(inBrakes(robot))}. Its motor holds it, and power stays. Support the arm, then disable it.`, label: "Look" } };
  }
  if (MOVING.includes(robot.state)) return { ...found, next: { go: "robot", text: `${found.meaning} Watch it${job ? ", or abort below" : ""}.`, label: "Watch" } };
  if (job?.status === "queued") return { ...found, next: { text: "An experiment waits for its turn; the arm stands still until then. You can abort it below." } };
  if (job?.kind === "investigation") return { ...found, next: { text: `An investigation is under way (${job.message || "it begins"}); the arm stands still, and may move. You can abort it below.` } };
  if (job) return { ...found, next: { text: `An experiment is being prepared (${job.message || "it begins"}); the arm stands still, and will move. You can abort it below.` } };
  return found;
}

/** Joints that read elsewhere than they stood, one after the other. */
export const inPlaces = (robot) => robot.misplaced.map((one) => one.sentence).join("; ");
/** Is the arm at rest, and not to be powered before somebody has looked? */
export const doubted = (robot) => robot.state === "inactive" && robot.misplaced.length > 0;

/** Brakes that did not hold the arm as power was to go, one after the other. */
export const inBrakes = (robot) => robot.unheld.map((one) => one.sentence).join("; ");
/** Is the arm held by its motors because its brakes would let it sink? */
export const sinking = (robot) => robot.state === "holding" && robot.unheld.length > 0;
const capital = (text) => `${text[0].toUpperCase()}${text.slice(1)}`;

const lost = (seconds) => {
  const age = Number.isFinite(seconds) ? `${seconds} s` : "a while";
  return { kind: "lost", word: "no connection", old: seconds, silent: "the daemon does not answer",
           meaning: `The daemon does not answer. What is shown here is ${age} old; what the arm does now is not known. ${EMERGENCY}`,
           next: { text: `The daemon does not answer, so nothing here is known to be true now. See that it still runs on the arm's machine; this page comes back by itself. ${EMERGENCY}` } };
};
/** The daemon answers, but nobody holds the arm: the control process hangs or is stopped. */
const hanging = (seconds) => {
  const meaning = `The control process does not answer. What is shown here is ${seconds} s old; what the arm does now is not known. ${EMERGENCY}`;
  return { kind: "lost", word: "no answer", old: seconds, silent: "the control process does not answer", meaning,
           next: { text: `${meaning} The daemon waits for it, and starts it anew if it stays silent.` } };
};
/** The first of several lines, and how many more there are. */
const inShort = (text) => {
  const [first, ...more] = text.split("\n");
  return more.length ? `${first} (and ${more.length} more)` : first;
};
const closed = (sentence) => (/[.!?]$/.test(sentence) ? sentence : `${sentence}.`);

/** Keep `state.condition` true, also while nobody tells anything. */
export function keepCondition() {
  let last = "";
  const look = () => {
    const now = judged(), text = JSON.stringify(now);
    if (text === last) return;
    last = text;
    change({ condition: now });
  };
  watch(["robot", "connected", "jobs", "heard"], look);
  setInterval(look, LOOK);
}

/** States from which an experiment may begin, and those without power. */
export const MAY_MOVE = ["inactive", "holding"], UNPOWERED = ["inactive", "offline", "fault"];
/** Why the arm is not ours to command now; "" where it is, in one of these states (null: in any). */
export const whyNot = (states = MAY_MOVE) => {
  const { robot, condition } = state;
  if (!robot || condition.silent) return condition.silent ?? "nothing is known of the arm yet";
  if (!mayCommand(client)) return `${robot.lease.holder} commands the arm`;
  if (moves()) return "an experiment is under way";
  if (states === MAY_MOVE && doubted(robot)) return "a joint reads elsewhere than it stood: look at the arm first (Robot)";
  if (!states || states.includes(robot.state)) return "";
  return { fault: "the arm is in fault: reset it first", holding: "the arm is powered: disable it first" }[robot.state] ?? `the arm is ${robot.state}`;
};

export const mayCommand = (me) => {
  const holder = state.robot?.lease.holder;
  return state.condition.kind !== "lost" && (!holder || holder === me);
};
