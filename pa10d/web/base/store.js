// What the page knows, in one place; sections are told when a part of it changes.
import { get } from "./api.js";

export const state = {
  connected: true, robot: null, runs: [], models: [], kinds: [], startingSet: [],
  tuned: 0, // the profile's version that the daemon told of last
  jobs: new Map(), comparisons: [], diagnoses: [], investigations: [], ready: false,
  aside: {}, // what of the data folder cannot be read, by what it was to be
  heard: null, // when the daemon last told of the arm, by performance.now()
  story: null, // of a virtual arm that hides something: which day it is, and what was revealed
  pose: null, // the newest positions, rad (m)
  ticked: 0, // when the loop's clock was last seen to go on
  condition: { kind: "unknown", word: "…", meaning: "", old: 0, next: null }, // see condition.js
};
const SOON = 2500; // ms within which a living daemon tells of its arm
const listeners = new Set();

/** f() now and whenever one of the keys changes; with `owner` only while that element is shown. */
export function watch(keys, f, owner = null) {
  listeners.add({ keys, f, owner, met: false });
  f();
}

export function change(part) {
  Object.assign(state, part);
  const keys = Object.keys(part);
  for (const listener of listeners) {
    listener.met ||= listener.owner?.isConnected ?? false;
    if (listener.met && !listener.owner.isConnected) listeners.delete(listener);
    else if (listener.keys.some((key) => keys.includes(key))) told(listener);
  }
}

/** What goes wrong in one place keeps nobody else from knowing. */
function told({ f }) {
  try {
    f();
  } catch (error) {
    reportError(error);
  }
}

const everything = async (path) => {
  const items = [];
  for (let cursor; ;) {
    const page = await get(path, { limit: 500, cursor });
    items.push(...page.items);
    if (!page.next) return { items, aside: page.set_aside };
    cursor = page.next;
  }
};
/** `of` of the state, and beside it what lies there and cannot be read. */
const keep = (of, { items, aside }) => change({ [of]: items, aside: { ...state.aside, [of]: aside } });

export const loadRobot = async () => {
  const robot = await get("robot", undefined, SOON);
  const heard = performance.now();
  const ticked = robot.time === state.robot?.time ? state.ticked : heard;
  change({ robot, connected: true, heard, ticked });
};
export const loadRuns = async () => keep("runs", await everything("runs"));
export const loadModels = async () => keep("models", await everything("models"));
export const loadAnalyses = async () => change({
  comparisons: (await get("comparisons", { limit: 100 })).items,
  diagnoses: (await get("diagnoses", { limit: 100 })).items,
});
export const loadInvestigations = async () => {
  const { items, set_aside: aside } = await get("investigations", { limit: 50 });
  keep("investigations", { items, aside });
};
export const loadStory = async () => change({ story: await get("story") });
const loadKinds = async () => {
  const found = await get("experiments");
  change({ kinds: found.items, startingSet: found.starting_set });
};
const loadJobs = async () => {
  const found = (await get("jobs", { limit: 50 })).items;
  change({ jobs: new Map(found.reverse().map((job) => [job.id, job])) });
};

/** All of it: at the start, and after the connection was lost. */
export async function loadEverything() {
  await Promise.all([loadRobot(), loadRuns(), loadModels(), loadAnalyses(), loadInvestigations(), loadStory(), loadKinds(), loadJobs()]);
  change({ ready: true });
}

export const tagged = (tag) =>
  state.runs.filter((run) => run.tags.includes(tag) && run.status !== "started").reverse();
export const current = () => state.models.filter((model) => !model.replaced);
