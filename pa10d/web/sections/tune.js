// Gains, limits and surroundings: seen, changed with the difference before, undone; and what a change did to the motion.
import { fill } from "../base/dom.js";
import { get } from "../base/api.js";
import { watch } from "../base/store.js";
import { failed } from "../base/notices.js";
import { heading } from "../parts/guide.js";
import { tunedResponse } from "../parts/tune_response.js";
import { tunedValues } from "../parts/tune_values.js";

export function mount(box) {
  const values = tunedValues(load), response = tunedResponse();
  fill(box, heading("tune", "Tune"), values.box, response.box);
  async function load() {
    const [tuning, versions] = await Promise.all([get("profile"), get("profile/versions")]);
    values.show(tuning, versions.items);
    response.show(tuning.joints, tuning.values.find((one) => one.key === "limits.position").units);
  }
  watch(["tuned"], () => load().catch((error) => failed("The profile could not be read.", error)));
}
