// Channels of a run or a fault: stretches and spectra as typed arrays.
import { fetchBytes } from "./api.js";

let reader = null, under = 0;
const waiting = [];

/** When nobody waits for columns: what is large and can wait comes after them. */
export const quiet = () => (under ? new Promise((done) => { waiting.push(done); }) : Promise.resolve());

/** Columns of the daemon, as `read` says. */
export async function table(path, query) {
  under += 1;
  try {
    return await read(path, query);
  } finally {
    under -= 1;
    if (!under) for (const done of waiting.splice(0)) done();
  }
}

/** {columns: {name: typed array}, about} of an Arrow stream of the daemon. */
async function read(path, query) {
  reader ??= import("../vendor/arrow.js");
  const [{ tableFromIPC }, bytes] = await Promise.all([reader, fetchBytes(path, query)]);
  const found = tableFromIPC(new Uint8Array(bytes));
  const columns = Object.fromEntries(found.schema.fields.map(({ name }) => [name, found.getChild(name).toArray()]));
  return { columns, about: JSON.parse(found.schema.metadata.get("pa10d")) };
}
