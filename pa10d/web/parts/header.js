// Always in sight: where you are, what the arm does, who commands it, and the stop button.
import { el, fill, say } from "../base/dom.js";
import { client, post, remove } from "../base/api.js";
import { loadRobot, state, watch } from "../base/store.js";
import { failed, guarded, notice } from "../base/notices.js";

export const SECTIONS = {
  robot: "Robot", experiments: "Experiments", runs: "Runs", compare: "Compare",
  diagnose: "Diagnose", models: "Models",
};

export function header(box) {
  const links = Object.entries(SECTIONS).map(([id, title]) => el("a", { href: `#/${id}` }, title));
  const arm = el("span", { class: "badge", id: "arm-state" }, "…");
  const lease = el("button", { class: "badge quiet", id: "lease", type: "button" });
  const stopButton = el("button", {
    id: "stop", type: "button", title: "Bring the arm to rest (key: Esc twice, or S)", onclick: stop,
  }, "Stop");
  fill(box,
    el("a", { class: "brand", href: "#/robot" }, "pa10d", el("small", { id: "profile" })),
    el("nav", { "aria-label": "sections" }, links), el("div", { class: "now" }, arm, lease), stopButton);
  lease.addEventListener("click", guarded("The command could not be given back.", giveBack));
  addEventListener("keydown", stopByKey);
  watch(["section"], () => {
    for (const link of links) {
      if (link.hash === `#/${state.section}`) link.setAttribute("aria-current", "page");
      else link.removeAttribute("aria-current");
    }
  });
  watch(["robot", "connected"], () => showArm(arm, lease));
}

function showArm(arm, lease) {
  const { robot, connected } = state;
  const shown = !connected ? "no connection" : robot?.state ?? "…";
  say(arm, shown);
  arm.className = `badge state-${connected ? shown : "lost"}`;
  arm.title = !connected ? "The daemon does not answer; trying again" : robot?.fault?.sentence ?? robot?.offline_reason ?? "";
  if (!robot) return;
  say(document.getElementById("profile"), robot.profile);
  const holder = robot.lease.holder;
  const mine = holder === client;
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

let lastEscape = 0;
function stopByKey(event) {
  const typing = /^(INPUT|TEXTAREA|SELECT)$/.test(event.target.tagName);
  if (event.key === "Escape") {
    if (event.timeStamp - lastEscape < 600) stop();
    lastEscape = event.timeStamp;
  }
  if ((event.key === "s" || event.key === "S") && !typing && !event.ctrlKey && !event.metaKey) stop();
}

async function stop() {
  document.getElementById("stop").classList.add("pressed");
  setTimeout(() => document.getElementById("stop").classList.remove("pressed"), 400);
  try {
    const robot = await post("robot/stop");
    notice("Stop was sent.", { detail: `The arm is ${robot.state}.` });
    await loadRobot();
  } catch (error) {
    failed("STOP DID NOT REACH THE DAEMON. Use the emergency stop.", error);
  }
}
