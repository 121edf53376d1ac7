// A virtual arm that hides something: a night passes by a button, and at the end it tells its secret.
import { el, fill } from "../base/dom.js";
import { post } from "../base/api.js";
import { whyNot } from "../base/condition.js";
import { change, loadRobot, state, watch } from "../base/store.js";
import { guarded, notice } from "../base/notices.js";
import { ask } from "./dialog.js";

/** A panel that is there only where the arm hides something. */
export function storyPanel() {
  const box = el("div", { class: "panel", id: "story", hidden: true });
  const show = () => {
    const { story } = state;
    box.hidden = !story?.hides;
    if (box.hidden) return;
    const night = el("button", { type: "button", onclick: guarded("The night could not pass.", async () => {
      change({ story: await post("story/night") });
      await loadRobot();
      notice("It is day 2.", { detail: "The arm was switched off and on again. Has it changed? Ask what has changed since your model." });
    }) }, "Let a night pass");
    const tell = el("button", { type: "button", onclick: guarded("It could not be told.", async () => {
      if (await ask("Reveal what the arm hides?", "There is no way back to not knowing. The investigation's report stays as it is.", "Reveal")) change({ story: await post("story/reveal") });
    }) }, "Reveal what it hides");
    const allow = () => {
      const why = whyNot(["inactive"]);
      night.disabled = Boolean(why);
      night.title = why;
    };
    fill(box, el("div", { class: "row between" }, el("h2", {}, "This arm hides something ", el("small", {}, `day ${story.day}`)),
      el("div", { class: "row" }, story.day === 1 ? night : null, story.hidden ? null : tell)),
    story.hidden
      ? el("p", { class: "verdict none" }, `It hides: ${story.hidden}${story.since_the_night ? ", since the night" : ""}.`)
      : el("p", { class: "muted" }, story.day === 1
        ? "Something may be in it since it was built: ask what is missing in its model. Where nothing is, something may happen to it over night: let it pass, then ask what has changed since."
        : "What was to happen to it has happened: ask what has changed since the model of day 1."));
    watch(["robot", "jobs", "condition"], allow, night);
  };
  watch(["story"], show);
  return box;
}
