// Elements in one line: el("button", { class: "primary", onclick: f }, "Start").
export function el(tag, props = {}, ...children) {
  const made = document.createElement(tag);
  for (const [key, value] of Object.entries(props)) {
    if (value === undefined || value === null || value === false) continue;
    if (key.startsWith("on")) made.addEventListener(key.slice(2), value);
    else if (key === "dataset") Object.assign(made.dataset, value);
    else if (key in made && key !== "list" && key !== "form" && !key.startsWith("aria")) {
      if (key === "class") made.className = value;
      else made[key] = value;
    } else if (key === "class") made.className = value;
    else made.setAttribute(key, value === true ? "" : value);
  }
  made.append(...children.flat(Infinity).filter((child) => child !== null && child !== undefined));
  return made;
}

/** The same for drawings. */
export function svg(tag, attributes, ...children) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
}

/** Put children in the place of what an element holds. */
export function fill(box, ...children) {
  box.replaceChildren(...children.flat(Infinity).filter((child) => child !== null && child !== undefined));
  return box;
}

const called = (one) => [one.tagName, one.getAttribute("aria-label"), one.value, one.textContent].join();

/** Fill again, and leave the keyboard on the thing it was on. */
export function refill(box, ...children) {
  const held = box.contains(document.activeElement) ? called(document.activeElement) : null;
  fill(box, ...children);
  if (held !== null) [...box.querySelectorAll("input, button, a, summary")].find((one) => called(one) === held)?.focus();
}

/** The same, but only where other elements would stand there: what is being pressed stays under the pointer. */
export function renew(box, ...children) {
  const fresh = fill(box.cloneNode(false), ...children);
  if (fresh.innerHTML !== box.innerHTML.replaceAll(' data-busy="yes"', "")) refill(box, ...fresh.childNodes);
}

/** How much larger than usual the reader wants letters: what is drawn does not grow by itself. */
export const larger = () => parseFloat(getComputedStyle(document.documentElement).fontSize) / 16;

/** Change text only where it differs, so that nothing flickers. */
export function say(box, text) {
  if (box.textContent !== text) box.textContent = text;
}
