// Numbers and times as a person reads them.
export function number(value, digits = 3) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e5 || size < 1e-4) return value.toExponential(digits - 1);
  return String(Number(value.toPrecision(digits)));
}

/** So many decimals; what rounds to nothing has no sign. */
export const fixed = (value, digits) => (Number.isFinite(value) ? value.toFixed(digits).replace(/^-(?=[0.]*$)/, "") : "–");

export function seconds(value) {
  if (!Number.isFinite(value)) return "–";
  if (value < 90) return `${Math.round(value)} s`;
  return `${Math.floor(value / 60)} min ${Math.round(value % 60)} s`;
}

export function when(iso) {
  const date = new Date(iso);
  if (Number.isNaN(date.getTime())) return "";
  const today = date.toDateString() === new Date().toDateString();
  const time = date.toLocaleTimeString([], { hour: "2-digit", minute: "2-digit" });
  return today ? time : `${date.toLocaleDateString()} ${time}`;
}

/** base, base-2 …: the first that is not taken. */
export function freeName(base, taken) {
  let name = base;
  for (let k = 2; taken.includes(name); k += 1) name = `${base}-${k}`;
  return name;
}

/** m0, m1 …: the first number that is not taken. */
export function nextModelName(taken) {
  let k = 0;
  while (taken.includes(`m${k}`)) k += 1;
  return `m${k}`;
}

/** point_to_point as "Point to point". */
export const titled = (id) => id[0].toUpperCase() + id.slice(1).replaceAll("_", " ");
