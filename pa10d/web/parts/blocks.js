// Blocks of a report as elements; the daemon makes them once for report and page.
import { el } from "../base/dom.js";
import { plot } from "./figure.js";

const makers = {
  text: (b) => el("p", { class: b.muted ? "muted" : "" }, b.text),
  lines: (b) => b.items.length
    ? el("ol", { class: "ranked" }, b.items.map(([tag, text]) => el("li", {}, tag ? el("b", {}, `${tag} `) : null, text)))
    : el("p", {}, b.otherwise),
  cards: (b) => el("div", { class: "cards" }, b.items.map(([what, value, remark]) =>
    el("div", { class: "card" }, el("span", {}, what), el("strong", {}, value), el("small", {}, remark)))),
  table: (b) => table(b.head, b.rows),
  plot: (b) => plot(b),
  facts: (b) => el("dl", { class: "facts" }, b.items.filter(([, answer]) => answer)
    .flatMap(([asked, answer]) => [el("dt", {}, asked), el("dd", {}, answer)])),
  verdict: (b) => el("p", { class: `verdict ${b.kind}` }, b.sentence),
  command: () => null, // the page has buttons for it
  section: (b) => section(b),
};

export const block = (b) => makers[b.block](b);

export function section(b, level = "h2") {
  const head = el(level, {}, b.title, " ", b.mark ? el("small", {}, b.mark) : null);
  const inner = b.blocks.map(block);
  if (b.folded === null || b.folded === undefined) return el("div", { class: "block" }, head, inner);
  return el("details", { class: "block", open: !b.folded }, el("summary", {}, head), inner);
}

export const table = (head, rows) => el("div", { class: "scroll", tabIndex: 0, role: "region", "aria-label": `table: ${head.filter(Boolean).join(", ")}` }, el("table", {},
  el("thead", {}, el("tr", {}, head.map((cell) => (cell ? el("th", { scope: "col" }, cell) : el("td", {}))))),
  el("tbody", {}, rows.map((row) => el("tr", {}, row.map((cell) => el("td", {}, cell)))))));
