// The address names what is shown: #/compare/ID/4 is the section "compare" with ["ID", "4"].

/** Its parts, the section's name first. */
export const inAddress = () => location.hash.replace(/^#\//, "").split("/").map(decoded);

function decoded(part) {
  try {
    return decodeURIComponent(part);
  } catch {
    return part; // typed by hand
  }
}

/** Say what a section shows now. What comes late leaves whoever has gone on to another section there. */
export function sayAddress(section, ...rest) {
  if (inAddress()[0] === section) history.replaceState(null, "", `#/${[section, ...rest].join("/")}`);
}
