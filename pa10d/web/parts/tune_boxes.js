// Boxes around the arm, a row each.
import { el, fill } from "../base/dom.js";

const triple = (text) => text.split(/[\s,;×]+/).filter(Boolean).map(Number);
const fine = (values) => values.length === 3 && values.every(Number.isFinite);

/** changed(boxes): after each edit that leaves three numbers in every place for three. */
export function boxesEditor(boxes, changed) {
  const body = el("tbody", {}), none = el("p", { class: "muted" }, "No boxes."), said = el("p", { class: "bad", role: "status" });
  const table = el("div", { class: "scroll bare", tabIndex: 0, role: "region", "aria-label": "Boxes" }, el("table", { class: "tuning" },
    el("thead", {}, el("tr", {}, ["name", "size, m", "centre, m", "turned by, rad"].map((head) => el("th", { scope: "col" }, head)), el("td", {}))), body));
  const rows = boxes.map((box) => ({ ...box }));
  const texts = { size: "size", xyz: "centre", rpy: "turn" };
  const tell = () => {
    const wrong = rows.flatMap((box, k) => Object.keys(texts).filter((key) => box[key] && !fine(box[key])).map((key) => `box ${k + 1}: ${texts[key]}: expected three numbers`));
    said.textContent = wrong[0] ?? "";
    if (!wrong.length) changed(rows.map((box) => ({ ...box })));
  };
  const text = (box, k, key) => el("input", { "aria-label": `${texts[key]} of box ${k + 1}`, value: (box[key] ?? [0, 0, 0]).join(", "), spellcheck: "false", oninput: (event) => {
    const values = triple(event.target.value);
    if (key === "rpy" && values.every((x) => x === 0)) delete box.rpy;
    else box[key] = values;
    tell();
  } });
  const draw = () => {
    none.hidden = rows.length > 0;
    table.hidden = !rows.length;
    fill(body, rows.map((box, k) => el("tr", {},
      el("td", {}, el("input", { "aria-label": `name of box ${k + 1}`, value: box.name ?? "", placeholder: `box ${k + 1}`, oninput: (event) => {
        if (event.target.value.trim()) box.name = event.target.value.trim();
        else delete box.name;
        tell();
      } })), ["size", "xyz", "rpy"].map((key) => el("td", {}, text(box, k, key))),
      el("td", {}, el("button", { type: "button", class: "small", "aria-label": `remove box ${k + 1}`, onclick: () => { rows.splice(k, 1); draw(); tell(); } }, "Remove")))));
  };
  draw();
  return el("div", { class: "below" }, none, table, el("button", { type: "button", class: "small below", onclick: () => {
    rows.push({ name: `box ${rows.length + 1}`, size: [0.5, 0.5, 0.5], xyz: [1.5, 0, 0.25] });
    draw();
    tell();
  } }, "Add a box"), said);
}
