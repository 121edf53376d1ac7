// Recordings that are dropped onto the page, or chosen: read, judged, stored.
import { el } from "../base/dom.js";
import { upload } from "../base/api.js";
import { loadRuns } from "../base/store.js";
import { failed, guarded, notice } from "../base/notices.js";

const FILES = ".csv,.gz,.bz2,.zst,.txt,.tsv,.mcap,.db3,.parquet,.feather,.arrow,.mat,.npz,.blf,.asc,.trc,.log";
const WORDS = "Drop recordings here (CSV with time, q1 …, tau1 …; ROS bag, Parquet, MAT …), or ";

async function bring(file, force = false) {
  const run = await upload(file, force);
  const said = (run.findings ?? []).map((one) => one.sentence);
  notice(`Imported ${run.name}.`, { detail: said.length ? `${said.length} thing${said.length > 1 ? "s" : ""} to know of it: ${said[0]}${said.length > 1 ? " …" : "."}` : "" });
  return run;
}

/** Errors of the checks can be overruled; nothing else can. */
function refused(file, error, then) {
  if (!error.document?.findings) return failed(`${file.name} was not imported.`, error);
  const said = error.document.findings.map((one) => `${one.sentence}${one.advice ? ` (${one.advice})` : ""}`).join("; ");
  notice(`${file.name} was not imported: a fit to it would be wrong.`, { kind: "error", detail: said, action: { label: "Import it all the same", do: guarded("It was not imported.", async () => {
    const run = await bring(file, true);
    await loadRuns();
    then(run);
  }) } });
}

/** `then(run)` is called with every run that was stored. */
export function dropZone(id, then = () => {}) {
  const input = el("input", { type: "file", accept: FILES, multiple: true, id, class: "hidden", onchange: () => { take([...input.files]); input.value = ""; } });
  const text = el("span", {}, WORDS);
  const zone = el("div", { class: "drop" }, text, el("label", { htmlFor: id, class: "button small" }, "choose files"), input);
  const take = async (files) => {
    const brought = [];
    for (const file of files) {
      text.textContent = `Reading ${file.name} … `;
      await bring(file).then((run) => brought.push(run), (error) => refused(file, error, then));
    }
    text.textContent = WORDS;
    await loadRuns().catch(() => {});
    brought.forEach(then);
  };
  const over = (on) => (event) => { event.preventDefault(); zone.classList.toggle("over", on); };
  zone.addEventListener("dragover", over(true));
  zone.addEventListener("dragleave", over(false));
  zone.addEventListener("drop", (event) => { over(false)(event); take([...event.dataTransfer.files]); });
  return zone;
}
