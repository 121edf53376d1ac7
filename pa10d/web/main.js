// Starts the page: header, sections by the address's hash, and what keeps them up to date.
import { inAddress } from "./base/address.js";
import { el, fill } from "./base/dom.js";
import { keepCondition } from "./base/condition.js";
import { followEvents } from "./base/live.js";
import { change, loadAnalyses, loadEverything, loadInvestigations, loadModels, loadRobot, loadRuns, state } from "./base/store.js";
import { failed } from "./base/notices.js";
import { header, SECTIONS } from "./parts/header.js";
import { askForToken } from "./parts/token.js";
import { jobChanged, tray } from "./parts/jobs.js";

const rooms = Object.fromEntries(Object.keys(SECTIONS).map((name) => [name, () => import(`./sections/${name}.js`)]));
const LOOK_EVERY = 1000; // ms between looks at the arm's state
const content = document.getElementById("content");
const made = new Map();
let turns = 0;

/** A section is fetched when it is first asked for: on a slow link nobody waits for what is not looked at. */
async function route() {
  const turn = turns += 1, { section, rest } = place();
  change({ section });
  document.title = `${SECTIONS[section]} – pa10d`;
  const room = await rooms[section]();
  if (turn !== turns) return; // somebody went on meanwhile
  if (!made.has(section)) {
    const box = el("section", { id: section, "aria-labelledby": `${section}-title` });
    made.set(section, box);
    content.append(box);
    room.mount(box);
  }
  for (const [other, box] of made) box.hidden = other !== section;
  room.show?.(rest);
}

function place() {
  const [name, ...rest] = inAddress();
  return name in rooms ? { section: name, rest } : { section: "robot", rest: [] };
}

/** What the address asks for and is not there is said: another section alone looks like an answer. */
function sayUnknown() {
  const [name] = inAddress();
  if (name && !(name in rooms)) failed("This section cannot be shown.", new Error(`The page has no section '${name}'; this is ${SECTIONS.robot}.`));
}

const go = () => route().catch((error) => failed("This section could not be fetched.", error));

function happened(event) {
  if (event.kind === "job") jobChanged(event.data);
  if (event.kind === "job" && event.data.finished) {
    if (["compare", "diagnose"].includes(event.data.kind)) loadAnalyses().catch(() => {});
    if (["identify", "add", "improve", "improvement", "investigation", "analysis"].includes(event.data.kind)) loadModels().catch(() => {});
  }
  if (event.kind === "investigation" || (event.data?.kind === "preparation" && event.data.finished)) loadInvestigations().catch(() => {});
  if (event.kind === "story") change({ story: event.data });
  if (event.kind === "profile") change({ tuned: event.data.version });
  if (event.kind === "run") loadRuns().catch(() => {});
  if (event.kind === "model") loadModels().catch(() => {});
  if (event.kind === "robot" || event.kind === "lease") loadRobot().catch(() => {});
}

async function lookAtRobot() {
  try {
    if (state.ready) await loadRobot();
  } catch (error) {
    if (error.status === 0) change({ connected: false });
  }
  setTimeout(lookAtRobot, LOOK_EVERY);
}

async function start() {
  keepCondition();
  header(document.getElementById("header"));
  tray(document.getElementById("jobs"));
  rooms[place().section]().catch(() => {}); // on its way while the daemon is asked what there is
  try {
    await loadEverything();
  } catch (error) {
    if (error.status === 401) await askForToken();
    else failed("The page could not be filled.", error);
  }
  followEvents({
    open: () => {
      const lost = !state.connected;
      if (lost || !state.ready) loadEverything().catch((e) => failed("The page could not be filled.", e));
    },
    close: () => change({ connected: false }),
    event: happened,
  });
  addEventListener("hashchange", () => {
    if (document.getElementById(location.hash.slice(1))) return; // a place within the page, as the skip link has it
    sayUnknown();
    go();
  });
  sayUnknown();
  go();
  lookAtRobot();
}

addEventListener("unhandledrejection", (event) => failed("Something went wrong.", event.reason));
fill(content);
start();
