// Channels of a run or a fault: stretches and spectra as typed arrays.
import { fetchBytes } from "./api.js";

let reader = null;

/** {columns: {name: typed array}, about} of an Arrow stream of the daemon. */
export async function table(path, query) {
  reader ??= import("../vendor/arrow.js");
  const [{ tableFromIPC }, bytes] = await Promise.all([reader, fetchBytes(path, query)]);
  const read = tableFromIPC(new Uint8Array(bytes));
  const columns = Object.fromEntries(read.schema.fields.map(({ name }) => [name, read.getChild(name).toArray()]));
  return { columns, about: JSON.parse(read.schema.metadata.get("pa10d")) };
}
