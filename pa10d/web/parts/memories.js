// What the drives themselves remember of their errors; they are asked when somebody opens it.
import { el, fill } from "../base/dom.js";
import { client, get, post } from "../base/api.js";
import { mayCommand } from "../base/condition.js";
import { guarded } from "../base/notices.js";
import { table } from "./blocks.js";
import { ask } from "./dialog.js";

export function memories() {
  const found = el("div", {});
  const show = ({ drives }) => fill(found, table(["joint", "error now", "remembered, newest first"], drives.map((one) => [`${one.joint} ${one.name}`, now(one), remembered(one)])),
    el("div", { class: "row" }, el("button", { type: "button", class: "small", onclick: look }, "Ask again"),
      drives.some((one) => one.history?.length) ? el("button", { type: "button", class: "small danger", disabled: !mayCommand(client), onclick: empty }, "Empty them") : null));
  const look = async () => {
    fill(found, el("p", { class: "muted" }, "The drives are asked …"));
    try {
      show(await get("robot/errors"));
    } catch (error) {
      fill(found, el("p", { class: "muted" }, error.message));
    }
  };
  const empty = guarded("The drives' memories could not be emptied.", async () => {
    if (await ask("Empty what the drives remember?", "Every drive forgets its history of errors (0x1003). A fault stays until it is reset.", "Empty", { danger: true })) show(await post("robot/errors/clear"));
  });
  const box = el("details", { class: "notes", id: "memories" }, el("summary", {}, "What the drives remember of their errors"), found);
  box.addEventListener("toggle", () => { if (box.open) look(); });
  return box;
}

const now = (one) => (one.problem ? "?" : one.error?.words ?? (one.wrong_now.join(", ") || "none"));

function remembered({ problem, history }) {
  if (problem) return problem;
  if (!history) return "keeps none";
  return history.length ? history.map((entry) => entry.words + (entry.of_the_maker ? `, maker's own 0x${entry.of_the_maker.toString(16)}` : "")).join("; ") : "none";
}
