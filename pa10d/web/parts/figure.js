// One plot in a card: title, figure, how to read it; with `load`, full detail on zoom.
import { el, say } from "../base/dom.js";
import { inNumbers } from "./in_numbers.js";

/** Draw when it comes near the window: most plots of a page are never looked at. */
const watcher = new IntersectionObserver((entries) => {
  for (const entry of entries) {
    if (!entry.isIntersecting) continue;
    watcher.unobserve(entry.target);
    entry.target.drawNow?.()?.catch(() => {}); // it says so in its place
  }
}, { rootMargin: "300px" });

/** The plot library is large: it comes with the first plot that is looked at. */
let library = null;
function plots() {
  library ??= script("plotly.js").then(() => script("plots.js")).then(() => pa10dPlots);
  library.catch(() => { library = null; }); // the next plot tries again
  return library;
}

function script(name) {
  return new Promise((done, lost) => {
    const source = new URL(`../${name}`, import.meta.url).href;
    document.head.append(el("script", {
      src: source, onload: done, onerror: () => lost(new Error("The plots could not be loaded: the daemon does not answer.")),
    }));
  });
}

export async function draw(box, figure) {
  box.classList.add("waiting");
  try {
    const { draw: onto } = await plots();
    box.querySelector(":scope > p")?.remove();
    const done = await onto(box, figure);
    box.drawn?.();
    return done;
  } catch (error) {
    box.replaceChildren(el("p", { class: "bad pad" }, error.message));
    throw error;
  } finally {
    box.classList.remove("waiting");
  }
}

/** A plot block of a report: {title, figures, reading, advice}. */
export function plot({ title, figures, reading, advice }) {
  const named = "data" in figures ? { "": figures } : figures;
  const names = Object.keys(named);
  const height = Math.max(...names.map((name) => named[name].layout.height ?? 300));
  const canvas = el("div", { class: "canvas" });
  canvas.style.height = `${height / 16}rem`;
  const choice = names.length > 1
    ? el("select", { "aria-label": `${title}: choose`, onchange: () => draw(canvas, named[choice.value]) },
      names.map((name) => el("option", { value: name }, name)))
    : null;
  canvas.drawNow = () => draw(canvas, named[choice?.value ?? names[0]]);
  watcher.observe(canvas);
  return card(title, choice, canvas, reading, advice);
}

export function card(title, tools, canvas, reading, advice) {
  return el("figure", { class: "plot" },
    el("figcaption", {}, el("span", {}, title), tools), canvas, inNumbers(canvas.matches(".canvas") ? canvas : canvas.querySelector(".canvas"), title),
    reading ? words(reading, advice) : null);
}

export function words(reading, advice = "") {
  return el("details", { class: "words", open: true }, el("summary", {}, "How to read this"),
    el("p", {}, reading.read),
    el("p", {}, el("b", {}, "What to do next: "), advice ? el("b", {}, `${advice} `) : null, reading.then));
}

/** A plot that asks `load({begin, end})` for what is seen, also after every zoom along x. */
export class Zoomable {
  /** `load({begin, end})` fetches what is seen; `point(x)` is told where the cursor is. */
  constructor(height, load, point = null) {
    this.point = point;
    this.canvas = el("div", { class: "canvas" });
    this.canvas.style.height = `${height / 16}rem`;
    this.trouble = el("p", { class: "bad pad", role: "alert", hidden: true });
    this.box = el("div", {}, this.trouble, this.canvas);
    this.load = load;
    this.asked = 0;
    this.span = null; // what is looked at, [begin, end]; null: the whole
  }

  /** Draw the whole, or a stretch of it; what was loaded, or null: the plot itself says what went wrong. */
  async show(span = null) {
    const mine = ++this.asked;
    this.span = span;
    this.canvas.classList.add("waiting");
    const found = await this.load(span ? { begin: span[0], end: span[1] } : {}).catch((error) => {
      if (mine === this.asked) this.say(error.message);
    });
    if (mine !== this.asked) return null;
    const drawn = found && await this.draw(found.figure);
    if (mine === this.asked) this.canvas.classList.remove("waiting");
    return drawn ? found : null;
  }

  /** Whether it could be drawn: the plot says in its own place why not. */
  async draw(figure) {
    this.trouble.hidden = true;
    const drawn = await draw(this.canvas, figure).then(() => true, () => false);
    if (drawn) this.listen();
    return drawn;
  }

  /** What is drawn below is not what was asked for last. */
  say(text) {
    say(this.trouble, text);
    this.trouble.hidden = false;
  }

  listen() {
    if (this.listening) return;
    this.listening = true;
    this.canvas.on("plotly_relayout", (changed) => {
      const span = spanOf(changed);
      if (span !== undefined) this.show(span);
    });
    if (this.point) this.canvas.on("plotly_hover", (event) => this.point(Number(event.points[0].x)));
    this.canvas.on("plotly_doubleclick", () => { this.show(); return false; });
  }
}

/** [begin, end] of a zoom, null for the whole, undefined where x did not change. */
function spanOf(changed) {
  if (changed["xaxis.autorange"]) return null;
  if ("xaxis.range[0]" in changed) return [changed["xaxis.range[0]"], changed["xaxis.range[1]"]].map(Number);
  if (changed["xaxis.range"]) return changed["xaxis.range"].map(Number);
  return undefined;
}

/** Empty state: what is not there, and what to do about it. */
export const empty = (text, link) =>
  el("div", { class: "empty" }, el("p", {}, text), link ? el("a", { class: "button", href: link.href }, link.label) : null);

