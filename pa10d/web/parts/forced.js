// What a fit must not use is refused by the daemon; whoever knows better may go on all the same.
import { post } from "../base/api.js";
import { ask } from "./dialog.js";

export async function postSound(path, body) {
  try {
    return await post(path, body);
  } catch (error) {
    if (!error.document?.type?.endsWith("/unsound")) throw error;
    const said = error.document.findings.map((one) => one.sentence).join("; ");
    if (!await ask("A fit to this would be wrong", `${said}.`, "Use it all the same", { danger: true })) throw error;
    return post(path, { ...body, force: true });
  }
}
