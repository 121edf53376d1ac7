// A place in a section where the arm is seen. One drawing serves all of them: it moves to the one
// that came into sight last, and is fetched with the first.
import { el, fill, say } from "../base/dom.js";
import { get, fetchBytes } from "../base/api.js";
import { fixed } from "../base/units.js";
import { quiet } from "../base/columns.js";

let stage = null, owner = null;

let told = null, slides = [];
/** The chain of joints, asked for once. */
export function shapeOnce() {
  told ??= get("robot/shape");
  told.then((shape) => { slides = shape.joints.map((one) => one.prismatic); }, () => { told = null; });
  return told;
}

/** What the position of a joint (from 0) is measured in, as far as the shape is known; and of all of them. */
export const unitOf = (joint) => (slides[joint] ? "m" : "rad");
export const unitOfAll = () => [...new Set(slides.map((_, j) => unitOf(j)))].sort().reverse().join(" or ") || "rad";

/** The drawing, with everything it needs, once. */
function stageReady() {
  stage ??= build();
  stage.catch(() => { stage = null; }); // the next one tries again
  return stage;
}

async function build() {
  const [{ ArmScene }, shape] = await Promise.all([import("./arm_scene.js"), shapeOnce()]);
  const meshes = await Promise.all(shape.meshes.map(async ({ link, place }, k) => ({ link, place, ...unpacked(await fetchBytes(`robot/shape/meshes/${k}`)) })));
  return new ArmScene(shape, meshes);
}

function unpacked(buffer) {
  const [vertices, triangles] = new Uint32Array(buffer, 0, 2);
  return { vertices: new Float32Array(buffer, 8, 3 * vertices), triangles: new Uint32Array(buffer, 8 + 12 * vertices, 3 * triangles) };
}

const sight = new IntersectionObserver((entries) => {
  for (const { target, isIntersecting } of entries) if (isIntersecting) target.arm.claim();
});

/** `label`: what it shows, for the title; `tools`: elements beside it. */
export function armView(label, ...tools) {
  const title = el("span", {}, label), place = el("div", { class: "arm-stage" }, el("p", { class: "muted pad" }, "The arm is being drawn …"));
  const reading = el("p", { class: "arm-reading muted", role: "status", "aria-live": "off" });
  const views = el("span", { class: "row" }, [["corner", "Corner"], ["front", "Front"], ["side", "Side"], ["top", "Top"]].map(([from, name]) =>
    el("button", { type: "button", class: "small", onclick: () => stage?.then((scene) => scene.look(from)) }, name)));
  const around = el("p", { class: "muted around", hidden: true });
  const box = el("figure", { class: "plot arm" }, el("figcaption", {}, title, views), place, tools, reading, around);
  const shown = { q: null, ghost: null, lit: [] };
  const apply = async () => {
    if (owner !== view || !stage) return;
    const scene = await stage.catch(() => null);
    if (!scene || owner !== view) return;
    scene.pose(shown.q ?? scene.shape.joints.map(() => 0));
    scene.ghostPose(shown.ghost);
    scene.light(shown.lit);
    scene.draw();
  };
  const fit = () => {
    if (owner === view && place.clientWidth) stage?.then((scene) => scene.resize(place.clientWidth, place.clientHeight)).catch(() => {});
  };
  const view = {
    box,
    /** q: rad (m), one per joint; ghost: the same of a motion that is planned, null for none. */
    show({ q, ghost, lit, words, name }) {
      if (q !== undefined) shown.q = q;
      if (ghost !== undefined) shown.ghost = ghost;
      if (lit !== undefined) shown.lit = lit;
      if (words !== undefined) say(reading, words);
      if (name !== undefined) say(title, name);
      apply();
    },
    async claim() {
      owner = view;
      await quiet();
      try {
        const scene = await stageReady();
        if (owner !== view) return;
        if (scene.canvas.parentElement !== place) {
          scene.canvas.setAttribute("role", "img");
          scene.canvas.setAttribute("aria-label", `${label}; its angles stand in the text below`);
          fill(place, scene.canvas);
          around.hidden = !scene.shape.boxes.length;
          say(around, `Around it, as the profile says: ${scene.shape.boxes.map((one) => `'${one.name}'`).join(", ")}.`);
        }
        fit();
        apply();
      } catch (error) {
        fill(place, el("p", { class: "muted pad" }, `The arm cannot be drawn here: ${error.message}`));
      }
    },
  };
  place.arm = view;
  sight.observe(place);
  new ResizeObserver(fit).observe(place);
  return view;
}

/** Angles in words: for everybody who does not see the picture. */
export const inWords = (q) => q.map((value, j) => `${j + 1}:\u00a0${fixed(value, 3)}`).join("   ");
