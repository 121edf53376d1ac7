// The stop button by itself: it needs nothing else of the page, and says whether it was heard.
// Esc pressed twice stops, too, wherever the keyboard's focus is; it types nothing anywhere.
(() => {
  const TWICE = 600, PATIENCE = 1500, AGAIN = 1000, SHOWN = 8000, REST = 6000, LOOK = 200; // ms
  const QUIET = 1; // s without a sign of life of the control process, which gives two a second
  const EMERGENCY = "Press the hardware emergency stop.";
  const AT_REST = {
    holding: "The arm stands still and is held.",
    inactive: "The arm stands still, unpowered.",
    fault: "The arm is in a fault, which has stopped it.",
  };
  const MOVING = ["running", "stopping", "enabling", "disabling", "resetting"];
  const button = document.getElementById("stop"), said = document.getElementById("stop-said");
  let turn = 0, hide = 0, lastEscape = -Infinity;

  function say(text, kind) {
    clearTimeout(hide);
    const close = document.createElement("button");
    close.type = "button";
    close.textContent = "Close";
    close.onclick = () => { said.hidden = true; };
    said.className = kind;
    said.replaceChildren(text, ...(kind === "waiting" ? [] : [close]));
    said.hidden = false;
    if (kind === "heard") hide = setTimeout(close.onclick, SHOWN);
  }

  async function ask(method, path, signal) {
    const headers = { "X-Client": sessionStorage.getItem("pa10d-client") ?? "stop-button" };
    const token = sessionStorage.getItem("pa10d-token");
    if (token) headers.Authorization = `Bearer ${token}`;
    const answer = await fetch(`/api/v1/robot${path}`, { method, headers, signal, cache: "no-store" });
    const told = await answer.json().catch(() => ({}));
    if (!answer.ok) throw new Error(told.detail ?? `the daemon answered ${answer.status}`);
    return told;
  }

  const silent = (why) => say(`STOP WAS NOT HEARD: ${why}. ${EMERGENCY} It is being tried again.`, "bad");

  /** Until the daemon has answered: a lost daemon may come back, and the arm may still move. */
  async function stop() {
    const mine = ++turn;
    button.classList.add("pressed");
    setTimeout(() => button.classList.remove("pressed"), 400);
    say("Stop was pressed …", "waiting");
    while (mine === turn) {
      const sent = new AbortController(); // for both questions: a lost connection may hang
      const watch = setInterval(() => look(mine, sent), 2 * PATIENCE);
      const late = setTimeout(() => look(mine, sent), PATIENCE);
      try {
        let told = await ask("POST", "/stop", sent.signal);
        const patient = performance.now() + REST;
        while (mine === turn && (MOVING.includes(told.state) || hangs(told)) && performance.now() < patient) {
          if (hangs(told)) unanswered(told.quiet);
          else say(`Stop was heard; the arm is ${told.state} …`, "waiting");
          await new Promise((done) => setTimeout(done, LOOK));
          told = await ask("GET", "", sent.signal);
        }
        if (mine === turn) heard(told);
        return;
      } catch (error) {
        if (mine !== turn) return;
        silent(error.name === "TypeError" || error.name === "AbortError" ? "the daemon does not answer" : error.message);
        await new Promise((done) => setTimeout(done, AGAIN));
      } finally {
        clearTimeout(late);
        clearInterval(watch);
        sent.abort();
      }
    }
  }

  /** No answer yet: is the arm still coming to rest, or is nobody there? */
  async function look(mine, sent) {
    const limit = setTimeout(() => sent.abort(), PATIENCE);
    try {
      const told = await ask("GET", "", sent.signal);
      if (mine !== turn) return;
      if (hangs(told)) unanswered(told.quiet);
      else say(`Stop was sent; the arm is ${told.state} …`, "waiting");
    } catch {
      sent.abort();
    } finally {
      clearTimeout(limit);
    }
  }

  const hangs = ({ state, quiet }) => quiet > QUIET && state !== "offline";
  const unanswered = (seconds) => say(`Stop was sent, but the control process has not answered for ${Math.round(seconds)} s. If the arm moves: ${EMERGENCY.toLowerCase()}`, "bad");

  function heard(told) {
    const { state, offline_reason: why } = told;
    if (hangs(told)) unanswered(told.quiet);
    else if (AT_REST[state]) say(`Stop was heard. ${AT_REST[state]}`, "heard");
    else if (state === "offline") say(`Stop was heard, but no drive answers${why ? ` (${why})` : ""}. If the arm moves: ${EMERGENCY.toLowerCase()}`, "bad");
    else say(`Stop was heard, but the arm is still ${state}. ${EMERGENCY}`, "bad");
    standBy(turn, told);
  }

  /** What it says holds for as long as it stands there: an arm that was still moving or unknown
      comes to rest, and somebody may move one that was at rest. */
  async function standBy(mine, before) {
    const as = (told) => `${hangs(told)} ${told.state} ${told.offline_reason ?? ""}`;
    const moved = hangs(before) || MOVING.includes(before.state);
    while (true) {
      await new Promise((done) => setTimeout(done, LOOK));
      if (mine !== turn || said.hidden) return;
      const told = await ask("GET", "").catch(() => null);
      if (mine !== turn || said.hidden) return;
      if (told ? as(told) === as(before) : moved || before.state === "offline") continue;
      if (told && (moved || hangs(told) || !MOVING.includes(told.state))) heard(told);
      else said.hidden = true;
      return;
    }
  }

  button.form.addEventListener("submit", (event) => { event.preventDefault(); stop(); });
  addEventListener("keydown", (event) => {
    if (event.key !== "Escape" || event.repeat) return;
    if (event.timeStamp - lastEscape < TWICE) {
      lastEscape = -Infinity;
      stop();
    } else lastEscape = event.timeStamp;
  }, true);
})();
