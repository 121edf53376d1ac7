// Tabs by keyboard, as everybody else has them: one Tab key to the row, arrows within it.
const KEYS = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 };

/** Keep a role="tablist" usable by arrows, Home and End, whoever fills it. */
export function tabsByKeys(row) {
  const tabs = () => [...row.querySelectorAll("[role=tab]")];
  const tidy = () => {
    const all = tabs(), chosen = all.find((one) => one.getAttribute("aria-selected") === "true") ?? all[0];
    for (const one of all) one.tabIndex = one === chosen ? 0 : -1;
  };
  row.addEventListener("keydown", (event) => {
    const all = tabs(), at = all.indexOf(event.target);
    if (at < 0) return;
    const next = event.key in KEYS ? (at + KEYS[event.key] + all.length) % all.length : event.key === "Home" ? 0 : event.key === "End" ? all.length - 1 : -1;
    if (next < 0) return;
    event.preventDefault();
    all[next].click();
    tabs()[next]?.focus(); // the row may have been filled anew
  });
  new MutationObserver(tidy).observe(row, { childList: true, subtree: true, attributes: true, attributeFilter: ["aria-selected"] });
  tidy();
  return row;
}
