// The arm: state, commands, axes, live plots.
import { el, fill, say } from "../base/dom.js";
import { client, post, put } from "../base/api.js";
import { followTelemetry } from "../base/live.js";
import { current, loadRobot, mayCommand, state, watch } from "../base/store.js";
import { guarded, notice } from "../base/notices.js";
import { fixed } from "../base/units.js";
import { heading } from "../parts/guide.js";
import { COLOURS, Scope, Trail } from "../parts/scope.js";

const SECONDS = 20, HISTORY = 30, REDRAW = 80; // s, s, ms
const MEANS = {
  offline: "No drive answers.",
  inactive: "Unpowered, brakes on. Angles are read. An experiment powers the arm by itself.",
  holding: "Powered; the controller holds the arm where it is.",
  running: "The arm is moving.",
  stopping: "The arm is coming to rest.",
  fault: "A fault has stopped the arm. Remove its cause, then reset.",
};

export function mount(box) {
  const word = el("strong", { class: "state-word" }), meaning = el("p", {});
  const notes = el("details", { class: "notes" }, el("summary", {}), el("ul", {}));
  const commands = buttons();
  const axes = el("tbody", {});
  const hidden = new Set();
  const scopes = el("div", { class: "scopes" }), chips = el("div", { class: "chips", role: "group", "aria-label": "joints shown" });
  const panel = el("div", { class: "panel" }, el("div", { class: "row between" }, el("h2", {}, "Live"), chips), scopes);
  fill(box, heading("robot", "Robot"),
    el("div", { class: "columns" },
      el("div", { class: "panel" }, el("div", { class: "state-head" }, word, meaning), commands.box, controllerChoice(), notes),
      el("div", { class: "panel grow" }, el("div", { class: "scroll bare" }, el("table", { class: "axes" },
        el("thead", {}, el("tr", {}, ["joint", "position rad", "target rad", "velocity rad/s", "torque N·m", "°C", "drive"]
          .map((head) => el("th", { scope: "col" }, head)))), axes)))),
    panel);
  watch(["robot", "connected"], () => {
    const robot = state.robot;
    if (!robot) return;
    say(word, state.connected ? robot.state : "no connection");
    word.className = `state-word state-${robot.state}`;
    say(meaning, robot.fault?.sentence ?? (robot.state === "offline" ? offlineWords(robot) : MEANS[robot.state]));
    fill(notes.firstChild, `${robot.notes.length} note${robot.notes.length === 1 ? "" : "s"} on this machine and these drives`);
    notes.hidden = !robot.notes.length;
    fill(notes.lastChild, robot.notes.map((note) => el("li", {}, note)));
    commands.refresh();
    showAxes(axes, robot.axes);
  });
  live(panel, scopes, chips, hidden);
}

const offlineWords = (robot) =>
  `${MEANS.offline.slice(0, -1)}: ${robot.offline_reason ?? "unknown why"}. You can work with recordings all the same: import them in Runs.`;

function buttons() {
  const command = (label, path, states, what) => ({
    states,
    button: el("button", { type: "button", onclick: guarded(what, async () => {
      await post(`robot/${path}`);
      await loadRobot();
    }) }, label),
  });
  const all = [
    command("Enable", "enable", ["inactive"], "The arm could not be enabled."),
    command("Disable", "disable", ["holding"], "The arm could not be disabled."),
    command("Reset", "reset", ["fault"], "The fault could not be reset."),
    command("Connect", "connect", ["offline"], "The drives could not be reached."),
  ];
  return {
    box: el("div", { class: "row" }, all.map((one) => one.button)),
    refresh() {
      const allowed = mayCommand(client);
      for (const { button, states } of all) {
        button.disabled = !allowed || !states.includes(state.robot.state);
        button.title = allowed ? (button.disabled ? `needs: ${states.join(" or ")}` : "") : `${state.robot.lease.holder} commands the arm`;
      }
    },
  };
}

function controllerChoice() {
  const select = el("select", { id: "controller" });
  const shown = () => {
    const robot = state.robot;
    if (!robot || document.activeElement === select) return;
    const names = current().map((model) => model.name);
    fill(select, el("option", { value: "" }, "PID"),
      names.map((name) => el("option", { value: name }, `computed torque with ${name}`)));
    if (robot.model && !names.includes(robot.model)) select.append(el("option", { value: robot.model }, `computed torque with ${robot.model}`));
    select.value = robot.controller === "pid" ? "" : robot.model ?? "";
    select.disabled = !mayCommand(client) || robot.state === "offline";
  };
  select.addEventListener("change", guarded("The controller stays as it was.", async () => {
    const model = select.value;
    try {
      await put("robot/controller", model ? { controller: "computed_torque", model } : { controller: "pid" });
      notice("Controller changed.", { detail: model ? `Computed torque with ${model}.` : "PID." });
    } finally {
      select.blur();
      await loadRobot();
    }
  }));
  watch(["robot", "models"], shown);
  return el("label", { class: "field", htmlFor: "controller" }, "Controller", select);
}

function showAxes(body, axes) {
  if (body.children.length !== Math.max(axes.length, 1) || !axes.length) {
    fill(body, axes.length
      ? axes.map(() => el("tr", {}, Array.from({ length: 7 }, () => el("td", {}))))
      : el("tr", {}, el("td", { colSpan: 7, class: "muted" }, "Nothing is read from the drives.")));
  }
  axes.forEach((axis, k) => {
    const texts = [`${axis.joint} ${axis.name}`, fixed(axis.position, 4), fixed(axis.target, 4), fixed(axis.velocity, 3),
                   fixed(axis.torque, 2), axis.temperature === null ? "–" : fixed(axis.temperature, 1), axis.drive_state ?? "no answer"];
    texts.forEach((text, c) => say(body.children[k].children[c], text));
  });
}

function live(panel, box, chips, hidden) {
  let trail = null, scopes = [];
  followTelemetry(HISTORY, {
    header(told) {
      trail = new Trail(SECONDS, told.rate);
      const joints = told.joints.length;
      scopes = [["Position", "rad", "q"], ["Velocity", "rad/s", "dq"], ["Torque", "N·m", "tau"]]
        .map(([title, unit, stem]) => new Scope(title, unit, stem, joints, hidden));
      fill(box, scopes.map((scope) => scope.box));
      fill(chips, told.joints.map((name, j) => {
        const chip = el("button", { type: "button", class: "chip", "aria-pressed": String(!hidden.has(j)), onclick: () => {
          if (hidden.has(j)) hidden.delete(j);
          else hidden.add(j);
          chip.setAttribute("aria-pressed", String(!hidden.has(j)));
        } }, el("i", {}), `${j + 1} ${name}`);
        chip.style.setProperty("--chip", COLOURS[j % COLOURS.length]);
        return chip;
      }));
    },
    packet: (columns, start, rows) => trail.add(columns, start, rows),
  });
  watch(["robot"], () => { panel.hidden = state.robot?.state === "offline" && !trail?.rows.length; });
  setInterval(() => {
    if (trail && box.offsetParent && !document.hidden) for (const scope of scopes) scope.draw(trail);
  }, REDRAW);
}
