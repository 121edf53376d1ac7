// Two sockets that come back by themselves: what happens (JSON), and measured values (binary).
import { token } from "./api.js";

const FIRST = 500, LONGEST = 5000; // ms until the next attempt

function keep(path, handlers) {
  let wait = FIRST, socket = null;
  const open = () => {
    const query = token() ? `${path.includes("?") ? "&" : "?"}token=${encodeURIComponent(token())}` : "";
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    socket = new WebSocket(`${scheme}://${location.host}/api/v1/${path}${query}`);
    socket.binaryType = "arraybuffer";
    socket.onopen = () => { wait = FIRST; handlers.open?.(); };
    socket.onmessage = (message) => handlers.message(message.data);
    socket.onclose = () => {
      handlers.close?.();
      setTimeout(open, wait);
      wait = Math.min(2 * wait, LONGEST);
    };
  };
  open();
  return () => socket.close();
}

export function followEvents({ open, close, event }) {
  keep("events", { open, close, message: (text) => event(JSON.parse(text)) });
}

/** packet(columns, start s, rows as Float32Array); the first one holds the last seconds. What is
 * returned begins anew, with another header. */
export function followTelemetry(history, { header, packet }) {
  let columns = [];
  return keep(`telemetry?history=${history}`, {
    message: (data) => {
      if (typeof data === "string") {
        const told = JSON.parse(data);
        columns = told.columns;
        header(told);
        return;
      }
      packet(columns, new DataView(data).getFloat64(0, true), new Float32Array(data.slice(8)));
    },
  });
}
