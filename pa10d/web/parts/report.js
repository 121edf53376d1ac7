// One file to send on: written by the daemon, then opened from the address it is at.
import { el } from "../base/dom.js";
import { download, post } from "../base/api.js";
import { guarded, notice } from "../base/notices.js";
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
