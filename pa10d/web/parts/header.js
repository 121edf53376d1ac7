// Always in sight: where you are, what the arm does, who commands it, (the stop button stands in the page itself).
import { el, fill, say } from "../base/dom.js";
import { client, remove } from "../base/api.js";
import { loadRobot, state, watch } from "../base/store.js";
import { guarded } from "../base/notices.js";

export const SECTIONS = {
  robot: "Robot", investigate: "Investigate", experiments: "Experiments", tune: "Tune", runs: "Runs", explore: "Explore", compare: "Compare",
  diagnose: "Diagnose", models: "Models",
};

export function header(box) {
  const links = Object.entries(SECTIONS).map(([id, title]) => el("a", { href: `#/${id}` }, title));
  const arm = el("span", { class: "badge", id: "arm-state" }, "…");
  const lease = el("button", { class: "badge quiet", id: "lease", type: "button" });
  fill(box, el("div", { class: "bar" },
    el("a", { class: "brand", href: "#/robot" }, "pa10d", el("small", { id: "profile" })),
    el("nav", { "aria-label": "sections" }, links), el("div", { class: "now" }, arm, lease)));
  // what sticks below it, or is scrolled to, has to know how high it has become
  new ResizeObserver(() => document.documentElement.style.setProperty("--head", `${box.offsetHeight}px`)).observe(box);
  lease.addEventListener("click", guarded("The command could not be given back.", giveBack));
  watch(["section"], () => {
    for (const link of links) {
      if (link.hash === `#/${state.section}`) {
        link.setAttribute("aria-current", "page");
        reveal(link);
      } else link.removeAttribute("aria-current");
    }
  });
  watch(["robot", "condition"], () => showArm(arm, lease));
}

function showArm(arm, lease) {
  const { robot, condition } = state;
  say(arm, condition.word);
  arm.className = `badge state-${condition.kind}`;
  arm.title = condition.meaning;
  if (!robot) return;
  say(document.getElementById("profile"), robot.profile);
  const holder = robot.lease.holder;
  const mine = holder === client;
  lease.hidden = condition.kind === "lost";
  say(lease, !holder ? "free to command" : mine ? "you command" : `${holder} commands`);
  lease.className = `badge quiet ${mine ? "mine" : holder ? "other" : ""}`;
  lease.title = !holder ? "Your first command takes the arm for half a minute"
    : mine ? "Click to let others command" : "You may look, and stop the arm";
}

async function giveBack() {
  if (state.robot?.lease.holder !== client) return;
  await remove("robot/lease");
  await loadRobot();
}

// On a narrow screen the row is longer than it. Not by scrollIntoView: some browsers let Tab go on
// from there, and the first thing that Tab reaches is to be STOP.
function reveal(link) {
  const row = link.closest("nav");
  const [shown, here] = [row.getBoundingClientRect(), link.getBoundingClientRect()];
  row.scrollLeft += Math.min(0, here.left - shown.left) + Math.max(0, here.right - shown.right);
}
