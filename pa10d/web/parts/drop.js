// Recordings that are dropped onto the page, or chosen: read, looked at, decided about, stored.
import { el } from "../base/dom.js";
import { post, send } from "../base/api.js";
import { loadRuns } from "../base/store.js";
import { failed, notice } from "../base/notices.js";

const FILES = ".csv,.gz,.bz2,.zst,.xz,.zip,.txt,.tsv,.dat,.mcap,.db3,.bag,.parquet,.feather,.arrow,.arrows,.mat,.h5,.hdf5,.npz,.npy,.blf,.asc,.trc,.log";
const LARGEST = 512 * 2 ** 20; // bytes, as the daemon takes them
const waits = ({ name }) => `${name} waits for you below. `;
const WORDS = "Drop recordings here (CSV with time, q1 …, tau1 …; ROS bag, Parquet, MAT …), or ";

/** Every episode of a data set: what was stored, and why the others were not. */
async function bringEvery(held, { rules, force }) {
  const { runs, refused } = await post(`recordings/${held.id}/import-every`, { map: rules, force });
  const why = refused.map((one) => `Episode ${one.episode}: ${one.detail}`).join(" ");
  notice(`Imported ${runs.length} of ${runs.length + refused.length} episodes.`, { detail: why });
  return runs;
}

async function bring(held, { rules, part, force, every }) {
  if (every) return bringEvery(held, { rules, force });
  const run = await post(`recordings/${held.id}/import`, { map: rules, part, force });
  const said = (run.findings ?? []).map((one) => one.sentence);
  const known = said.length ? `${said.length} thing${said.length > 1 ? "s" : ""} to know of it: ${said[0]}${said.length > 1 ? " …" : "."}` : "";
  notice(`Imported ${run.name}.`, { detail: [known, run.mapping_kept && `${run.mapping_kept}.`].filter(Boolean).join(" ") });
  return [run];
}

/** `then(run)` is called with every run that was stored. */
export function dropZone(id, then = () => {}) {
  const input = el("input", { type: "file", accept: FILES, multiple: true, id, class: "hidden", onchange: () => { take([...input.files]); input.value = ""; } });
  const text = el("span", {}, WORDS);
  const zone = el("div", { class: "drop" }, text, el("label", { htmlFor: id, class: "button small" }, "choose files"), input);
  const asked = el("div", {});
  let busy = false; // from the first byte that is read until the last answer
  const take = async (files) => {
    if (busy) return notice("One file after the other.", { detail: "Import the one before, or leave it, first." });
    busy = true;
    const { decide } = await import("./preview.js");
    const brought = [];
    let alike = null; // what was decided for all of them
    for (const [k, file] of files.entries()) {
      text.textContent = `Reading ${file.name} … `;
      try {
        if (file.size > LARGEST) throw new Error(`${Math.ceil(file.size / 1e6)} MB, at most ${Math.floor(LARGEST / 1e6)} MB come through the page: on the machine of the daemon, pa10d run import ${file.name} takes it.`);
        let held = await send(file);
        text.textContent = waits(file);
        let runs = alike && await bring(held, alike).catch(() => null);
        while (!runs) {
          const answer = await decide(asked, held, files.length - k - 1);
          if (!answer) break;
          text.textContent = `Importing ${file.name} … `;
          held = answer.seen; // asked again, it stands as it was left
          alike = answer.alike ? answer : alike;
          runs = await bring(held, answer).catch((error) => { failed(`${file.name} was not imported.`, error); });
          if (!runs) text.textContent = waits(file);
        }
        if (runs) brought.push(...runs);
      } catch (error) {
        failed(`${file.name} was not imported.`, error);
      }
    }
    busy = false;
    text.textContent = WORDS;
    await loadRuns().catch(() => {});
    brought.forEach(then);
  };
  const over = (on) => (event) => { event.preventDefault(); zone.classList.toggle("over", on); };
  zone.addEventListener("dragover", over(true));
  zone.addEventListener("dragleave", over(false));
  zone.addEventListener("drop", (event) => { over(false)(event); take([...event.dataTransfer.files]); });
  return el("div", {}, zone, asked);
}
