// Where the daemon wants a token, ask for it once; it is kept until the tab is closed.
import { el } from "../base/dom.js";
import { useToken } from "../base/api.js";
import { loadEverything } from "../base/store.js";

export function askForToken() {
  return new Promise((done) => {
    const field = el("input", { type: "password", id: "token", autocomplete: "off", required: true });
    const wrong = el("p", { class: "bad", role: "alert" });
    const form = el("form", { method: "dialog" },
      el("h2", {}, "This bench wants a token"),
      el("p", {}, "It was given to 'pa10d serve' with --token-file or PA10D_TOKEN. Ask whoever started it."),
      el("label", { htmlFor: "token" }, "Token"), field, wrong,
      el("div", { class: "row" }, el("button", { class: "primary" }, "Enter")));
    const dialog = el("dialog", { oncancel: (event) => event.preventDefault() }, form);
    form.addEventListener("submit", async (event) => {
      event.preventDefault();
      useToken(field.value.trim());
      try {
        await loadEverything();
        dialog.close();
        dialog.remove();
        done();
      } catch (error) {
        wrong.textContent = error.status === 401 ? "That is not the token." : error.message;
      }
    });
    document.body.append(dialog);
    dialog.showModal();
  });
}
