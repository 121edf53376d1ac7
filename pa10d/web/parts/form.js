// A form from a JSON schema: numbers, choices, yes/no, and lists as text.
import { el } from "../base/dom.js";

let count = 0;

/** {box, read()}: read() gives the parameters that differ from their defaults, or throws. */
export function formOf(schema) {
  const fields = Object.entries(schema.properties ?? {}).map(([name, part]) => fieldOf(name, part));
  const usual = fields.filter((field) => !field.rare), rare = fields.filter((field) => field.rare);
  return {
    box: el("div", { class: "fields" }, usual.map((field) => field.box),
      rare.length ? el("details", { class: "rare" }, el("summary", {}, "More"),
        el("div", { class: "fields" }, rare.map((field) => field.box))) : null),
    read() {
      const out = {};
      for (const field of fields) {
        const value = field.read();
        if (value !== undefined) out[field.name] = value;
      }
      return out;
    },
    /** Take the values of a plan. */
    write(values) {
      for (const field of fields) if (values[field.name] !== undefined) field.write(values[field.name]);
    },
  };
}

function fieldOf(name, part) {
  const optional = part.anyOf?.some((one) => one.type === "null");
  const kind = part.anyOf?.find((one) => one.type !== "null") ?? part;
  const id = `field-${++count}`;
  const label = el("label", { htmlFor: id }, name.replaceAll("_", " "));
  const hint = el("small", { id: `${id}-hint` }, part.description ?? "");
  const input = inputOf(kind, part, id, optional);
  input.setAttribute("aria-describedby", hint.id);
  return {
    name, rare: kind.type === "array" && name !== "joints" && optional,
    box: el("div", { class: "field" }, label, input, hint),
    read: () => {
      if (typeof part.default === "number" && input.value === inShort(part.default)) return undefined; // a third of pi stays one
      const value = valueOf(input, kind, name);
      return JSON.stringify(value) === JSON.stringify(part.default ?? undefined) ? undefined : value;
    },
    write: (value) => {
      if (input.type === "checkbox") input.checked = value;
      else input.value = kind.type === "array" ? asText(value) : value;
    },
  };
}

function inputOf(kind, part, id, optional) {
  if (kind.type === "boolean") return el("input", { id, type: "checkbox", checked: part.default === true });
  if (kind.enum) return el("select", { id }, kind.enum.map((one) => el("option", {}, one)));
  if (kind.type === "number" || kind.type === "integer") {
    const input = el("input", { id, type: "number", step: kind.type === "integer" ? 1 : "any",
                                inputMode: "decimal", required: !optional, value: typeof part.default === "number" ? inShort(part.default) : "" });
    if (kind.minimum !== undefined) input.min = kind.minimum;
    if (kind.maximum !== undefined) input.max = kind.maximum;
    return input;
  }
  const nested = kind.items?.type === "array";
  return el(nested ? "textarea" : "input", {
    id, spellcheck: "false", value: part.default ? asText(part.default) : "",
    placeholder: nested ? "a row per line" : optional ? "all" : "",
  });
}

const inShort = (value) => String(Number(value.toPrecision(6)));

const asText = (value) => Array.isArray(value[0])
  ? value.map((row) => row.join(", ")).join("\n") : value.join(", ");

function valueOf(input, kind, name) {
  if (input.type === "checkbox") return input.checked;
  const text = input.value.trim();
  if (text === "") return undefined;
  if (kind.type === "number" || kind.type === "integer") return Number(text);
  if (kind.type !== "array") return text;
  const row = (line) => line.split(/[\s,;]+/).filter(Boolean).map((word) => {
    const value = Number(word);
    if (!Number.isFinite(value)) throw new Error(`${name.replaceAll("_", " ")}: '${word}' is no number.`);
    return value;
  });
  return kind.items?.type === "array" ? text.split("\n").filter((l) => l.trim()).map(row) : row(text);
}
