// Requests to the daemon. A refusal becomes a Problem whose message says what to do.
const SILENT = { status: 0, detail: "The daemon does not answer.", remedy: "Is it still running on the machine of the arm?" };
const TOKEN = "pa10d-token", CLIENT = "pa10d-client";

/** Who this page is: the same after a refresh, another one in every tab. */
export const client = (() => {
  const known = sessionStorage.getItem(CLIENT);
  if (known) return known;
  const bytes = crypto.getRandomValues(new Uint8Array(3));
  const made = "browser-" + [...bytes].map((b) => b.toString(16).padStart(2, "0")).join("");
  sessionStorage.setItem(CLIENT, made);
  return made;
})();

export const token = () => sessionStorage.getItem(TOKEN) ?? "";
export const useToken = (value) => sessionStorage.setItem(TOKEN, value);

export class Problem extends Error {
  constructor(document) {
    super(document.detail || document.title || "the daemon refused");
    this.document = document;
    this.status = document.status;
    this.remedy = document.remedy ?? "";
  }
}

export async function ask(method, path, { body, query, raw, within } = {}) {
  const address = path.startsWith("/") ? path : `/api/v1/${path}`;
  const headers = { "X-Client": client };
  if (token()) headers.Authorization = `Bearer ${token()}`;
  if (body !== undefined) headers["Content-Type"] = "application/json";
  let answer;
  try {
    answer = await fetch(address + asQuery(query), {
      method, headers, signal: within ? AbortSignal.timeout(within) : undefined, body: raw ?? (body === undefined ? undefined : JSON.stringify(body)),
    });
  } catch {
    throw new Problem(SILENT);
  }
  if (!answer.ok) throw new Problem(await problemOf(answer));
  return answer.json();
}

/** What is not JSON: an ArrayBuffer. */
export async function fetchBytes(path, query) {
  const headers = { "X-Client": client, ...(token() ? { Authorization: `Bearer ${token()}` } : {}) };
  let answer;
  try {
    answer = await fetch(`/api/v1/${path}` + asQuery(query), { headers });
  } catch {
    throw new Problem(SILENT);
  }
  if (!answer.ok) throw new Problem(await problemOf(answer));
  return answer.arrayBuffer();
}

export const get = (path, query, within) => ask("GET", path, { query, within });
export const post = (path, body = {}) => ask("POST", path, { body });
export const put = (path, body) => ask("PUT", path, { body });
export const patch = (path, body) => ask("PATCH", path, { body });
export const remove = (path) => ask("DELETE", path);
/** A file to be looked at before it is imported. */
export const send = (file) => ask("POST", "recordings", { raw: file, query: { filename: file.name } });

/** Give a file of the API to the user: by fetch, so that the token comes along. */
export async function download(path, query, filename) {
  const headers = token() ? { Authorization: `Bearer ${token()}` } : {};
  const answer = await fetch(`/api/v1/${path}` + asQuery(query), { headers });
  if (!answer.ok) throw new Problem(await problemOf(answer));
  const link = document.createElement("a");
  link.href = URL.createObjectURL(await answer.blob());
  link.download = filename;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

function asQuery(query) {
  if (!query) return "";
  const pairs = Object.entries(query).flatMap(([key, value]) =>
    (Array.isArray(value) ? value : [value])
      .filter((one) => one !== undefined && one !== null)
      .map((one) => [key, String(one)]));
  return pairs.length ? "?" + new URLSearchParams(pairs) : "";
}

async function problemOf(answer) {
  try {
    return await answer.json();
  } catch {
    return { status: answer.status, detail: `the daemon answered ${answer.status}` };
  }
}
