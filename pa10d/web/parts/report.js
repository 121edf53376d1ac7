// One file to send on: written by the daemon, then opened from the address it is at.
import { el } from "../base/dom.js";
import { download, post, token } from "../base/api.js";
import { failed, guarded, notice } from "../base/notices.js";
import { finished } from "./jobs.js";

/** model() and runs(): which model, judged by which runs; without runs by those it was judged by. */
export const reportButton = (model, runs = () => []) => el("button", {
  type: "button", class: "report", title: "Robot, runs, fit, parameters, errors and versions in one HTML file",
  onclick: guarded("The report could not be written.", async () => {
    const name = model();
    const job = await finished(await post(`models/${encodeURIComponent(name)}/reports`, { runs: runs() }));
    await download(`reports/${job.id}`, undefined, `${name}.html`);
    notice(`The report of ${name} is written.`, { detail: `${name}.html is in the browser's downloads; it opens without a network.` });
  }) }, "Report");

/** A file that the daemon has written. Where it wants a token, a link cannot bring one: then it is downloaded. */
export const fileLink = (path, filename, says, more) => el("a", { href: `api/v1/${path}`, ...more,
  onclick: (event) => {
    if (!token()) return;
    event.preventDefault();
    download(path, undefined, filename).catch((error) => failed("The file could not be fetched.", error));
  } }, says);
