// The arm: state, commands, axes, live plots.
import { el, fill, say } from "../base/dom.js";
import { client, post, put } from "../base/api.js";
import { doubted, inBrakes, inPlaces, mayCommand, sinking } from "../base/condition.js";
import { current, loadRobot, state, watch } from "../base/store.js";
import { guarded, notice } from "../base/notices.js";
import { fixed } from "../base/units.js";
import { ask } from "../parts/dialog.js";
import { armView, inWords, shapeOnce, unitOfAll } from "../parts/arm.js";
import { lawInWords, lawOf, lawsWith, valueOf } from "../parts/laws.js";
import { heading } from "../parts/guide.js";
import { live } from "../parts/live.js";
import { memories } from "../parts/memories.js";

export function mount(box) {
  const word = el("strong", { class: "state-word" }), meaning = el("p", {}), age = el("p", { class: "warn", hidden: true });
  const notes = el("details", { class: "notes" }, el("summary", {}), el("ul", {}));
  const commands = buttons(), stray = wayBack(), beside = elsewhere(), weak = slipping();
  const last = el("p", { hidden: true }, el("a", { href: "#/explore/fault" }, "Look at the last seconds before the fault"));
  const axes = el("tbody", {}), heads = el("tr", {}, headings(null));
  shapeOnce().then((shape) => fill(heads, headings(shape)), () => {});
  const table = el("div", { class: "panel grow" }, age, el("div", { class: "scroll bare", tabIndex: 0, role: "region", "aria-label": "joints, now" }, el("table", { class: "axes" },
    el("thead", {}, heads), axes)));
  fill(box, heading("robot", "Robot", { Reset: "The button is below." }),
    el("div", { class: "columns" },
      el("div", { class: "panel" }, el("div", { class: "state-head" }, word, meaning), commands.box, stray.box, beside.box, weak.box, last, controllerChoice(), notes), el("div", { class: "grow" }, table, memories())),
    el("div", { class: "beside" }, liveArm(), live()));
  watch(["robot", "condition"], () => {
    const { robot, condition } = state;
    if (!robot) return;
    say(word, condition.word);
    word.className = `state-word state-${condition.kind}`;
    say(meaning, condition.meaning);
    fill(notes.firstChild, `${robot.notes.length} note${robot.notes.length === 1 ? "" : "s"} on this machine and these drives`);
    notes.hidden = !robot.notes.length;
    fill(notes.lastChild, robot.notes.map((note) => el("li", {}, note)));
    commands.refresh();
    stray.refresh();
    beside.refresh();
    weak.refresh();
    last.hidden = condition.kind !== "fault";
    showAxes(axes, robot.axes);
    const lost = condition.kind === "lost";
    table.classList.toggle("old", lost || Boolean(condition.frozen));
    age.hidden = !lost && !condition.frozen;
    say(age, lost ? `These values are ${condition.old} s old.` : condition.frozen ? "These are the last values before the fault: nothing is read now." : "");
  });
}

/** The arm as it stands; words follow slowly, for those who have them read out. */
function liveArm() {
  const view = armView("The arm, now");
  watch(["pose"], () => {
    if (state.pose && view.box.offsetParent) view.show({ q: state.pose });
  });
  watch(["robot", "condition"], () => {
    const known = state.pose ?? (state.robot?.axes.length ? state.robot.axes.map((axis) => axis.position) : null);
    const lost = state.condition.kind === "lost" || state.condition.frozen;
    view.box.classList.toggle("old", Boolean(lost));
    view.show({ q: known ?? undefined, words: !known ? "No drive answers: the arm is drawn with all joints at zero." : lost ? "Not known now: the last pose that was read." : `Joints, ${unitOfAll()}:   ${inWords(known)}` });
  });
  return view.box;
}

function buttons() {
  const command = (label, path, states, what, shown = () => false) => ({ // shown: beside the buttons, so that no notice is needed
    states,
    button: el("button", { type: "button", onclick: guarded(what, async () => {
      const refused = await post(`robot/${path}`).then(() => null, (error) => error);
      await (refused ? loadRobot().catch(() => null) : loadRobot());
      if (refused && !shown(state.robot)) throw refused;
    }) }, label),
  });
  const all = [
    command("Enable", "enable", ["inactive"], "The arm could not be enabled."),
    command("Disable", "disable", ["holding"], "The arm could not be disabled.", sinking),
    command("Reset", "reset", ["fault"], "The fault could not be reset."),
    command("Connect", "connect", ["offline"], "The drives could not be reached."),
  ];
  return {
    box: el("div", { class: "row" }, all.map((one) => one.button)),
    refresh() {
      const nobody = state.condition.silent, allowed = mayCommand(client);
      for (const { button, states } of all) {
        const fits = states.includes(state.robot.state), unsure = doubted(state.robot);
        button.disabled = !allowed || !fits || unsure;
        button.classList.toggle("primary", allowed && fits && state.robot.state === "fault");
        button.title = nobody ? nobody : !allowed ? `${state.robot.lease.holder} commands the arm` : unsure ? "look at the arm first" : fits ? "" : `needs: ${states.join(" or ")}`;
      }
    },
  };
}

/** Joints that read elsewhere than they stood before their drive was set up anew. */
function elsewhere() {
  const said = el("p", {}), button = el("button", { type: "button", onclick: guarded("The arm's place is not confirmed.", async () => {
    const so = await ask("Does the arm stand as it is drawn?", `${inPlaces(state.robot)}. Compare the arm with its picture, joint by joint. If it stands otherwise, home the drive or correct zero_offset: with a wrong zero every limit of that joint is elsewhere.`, "It stands as drawn", { danger: true });
    if (!so) return;
    await post("robot/confirm");
    await loadRobot();
    notice("The arm is taken to stand where it reads.");
  }) }, "I have looked …");
  const box = el("div", { class: "doubt", hidden: true }, said, button);
  return {
    box,
    refresh() {
      box.hidden = !doubted(state.robot);
      say(said, `${inPlaces(state.robot)}. An encoder lost its place, or the arm was moved while its drive was not heard: it is not powered before somebody has looked.`);
      button.disabled = !mayCommand(client);
    },
  };
}

/** Brakes that did not hold the arm as power was to go: it stayed. */
function slipping() {
  const said = el("p", {}), button = el("button", { type: "button", onclick: guarded("The power is still on.", async () => {
    const go = await ask("Take the power away although the arm will sink?", `${inBrakes(state.robot)}. Without power that joint goes down as far as something stops it. Is the arm supported, and nobody below it?`, "Take the power away", { danger: true });
    if (!go) return;
    await post("robot/disable", { anyway: true });
    await loadRobot();
    notice("The power is off.", { detail: "Brakes are on; one of them does not hold." });
  }) }, "Disable anyway …");
  const box = el("div", { class: "doubt", hidden: true }, said, button);
  return {
    box,
    refresh() {
      box.hidden = !sinking(state.robot);
      say(said, `${inBrakes(state.robot)}. Its motor holds it, and power stays. Support the arm, then disable it.`);
      button.disabled = !mayCommand(client);
    },
  };
}

/** Joints outside their position limits: the arm is not enabled there, but for the way back. */
function wayBack() {
  const said = el("p", {}), button = el("button", { type: "button", onclick: guarded("The arm is not back inside.", async () => {
    const where = state.robot.outside.map((one) => one.sentence).join("; ");
    const go = await ask("Bring the arm back inside?", `${where}. It is powered there and moves inside at a tenth of its speed, straight. Is nobody within its reach, and nothing in its way?`, "Move it inside", { danger: true });
    if (!go) return;
    await post("robot/enable", { recover: true });
    await loadRobot();
    notice("The arm is back inside its limits.", { detail: "It is held there." });
  }) }, "Bring it back inside …");
  const box = el("div", { class: "doubt", hidden: true }, said, button);
  return {
    box,
    refresh() {
      const { outside, state: now } = state.robot, far = outside.some((one) => one.too_far);
      box.hidden = !outside.length || !["inactive", "holding"].includes(now);
      say(said, `${outside.map((one) => one.sentence).join("; ")}.${far ? " That is too far to be powered there: move it inside by hand, or correct its zero_offset." : ""}`);
      button.hidden = far;
      button.disabled = !mayCommand(client);
    },
  };
}

function controllerChoice() {
  const select = el("select", { id: "controller" });
  const shown = () => {
    const robot = state.robot;
    if (!robot || document.activeElement === select) return;
    const names = current().map((model) => model.name);
    if (robot.model && !names.includes(robot.model)) names.push(robot.model);
    fill(select, el("option", { value: "pid" }, "PID"), lawsWith(names));
    select.value = valueOf(robot.controller, robot.model);
    select.disabled = !mayCommand(client) || robot.state === "offline";
  };
  select.addEventListener("change", guarded("The controller stays as it was.", async () => {
    const law = lawOf(select.value);
    try {
      await put("robot/controller", law);
      notice("Controller changed.", { detail: `Now it is ${lawInWords(law.controller, law.model)}.` });
    } finally {
      select.blur();
      await loadRobot();
    }
  }));
  watch(["robot", "models", "condition"], shown);
  return el("label", { class: "field", htmlFor: "controller" }, "Controller", select);
}

/** With the units that these joints have: one that slides has metres and newtons. */
function headings(shape) {
  const sliding = shape?.joints.some((one) => one.prismatic), turning = !shape || shape.joints.some((one) => !one.prismatic);
  const unit = (turns, slides) => [turning && turns, sliding && slides].filter(Boolean).join(" or ");
  return ["joint", `position, ${unit("rad", "m")}`, `target, ${unit("rad", "m")}`, `velocity, ${unit("rad/s", "m/s")}`, `torque, ${unit("N·m", "N")}`, "temperature, °C", "drive"]
    .map((head) => el("th", { scope: "col" }, head));
}

function showAxes(body, axes) {
  if (body.children.length !== Math.max(axes.length, 1) || !axes.length) {
    fill(body, axes.length
      ? axes.map(() => el("tr", {}, el("th", { scope: "row" }), Array.from({ length: 6 }, () => el("td", {}))))
      : el("tr", {}, el("td", { colSpan: 7, class: "muted" }, "Nothing is read from the drives.")));
  }
  axes.forEach((axis, k) => {
    const texts = [`${axis.joint} ${axis.name}`, fixed(axis.position, 4), fixed(axis.target, 4), fixed(axis.velocity, 3),
                   fixed(axis.torque, 2), axis.temperature === null ? "–" : fixed(axis.temperature, 1),
                   axis.silent ? `no answer for ${fixed(axis.age / state.robot.rate, 1)} s` : axis.drive_state ?? "no answer"];
    body.children[k].classList.toggle("silent", axis.silent);
    texts.forEach((text, c) => say(body.children[k].children[c], text));
  });
}
