// Where the daemon wants a token, ask for it once; it is kept until the tab is closed.
import { el } from "../base/dom.js";
import { useToken } from "../base/api.js";
import { loadEverything } from "../base/store.js";
import { dialog } from "./dialog.js";

export function askForToken() {
  return new Promise((done) => {
    const field = el("input", { type: "password", id: "token", autocomplete: "off", required: true });
    const wrong = el("p", { class: "bad", role: "alert" });
    const form = el("form", {},
      el("p", {}, "Whoever started this bench has chosen it: ask for it."),
      el("label", { htmlFor: "token" }, "Token"), field, wrong,
      el("div", { class: "row" }, el("button", { class: "primary" }, "Enter")));
    form.addEventListener("submit", async (event) => {
      event.preventDefault();
      useToken(field.value.trim());
      try {
        await loadEverything();
        open.done();
        done();
      } catch (error) {
        wrong.textContent = error.status === 401 ? "That is not the token." : error.message;
      }
    });
    const open = dialog("This bench is locked", form);
  });
}
