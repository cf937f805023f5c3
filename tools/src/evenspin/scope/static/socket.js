// The connection to the server: requests with answers, messages, rows. Opens itself again; asks for nothing by itself.

const AGAIN_MS = 700;
const ANSWER_MS = 15000;

export class Socket extends EventTarget {
  #socket = null;
  #waiting = new Map();
  #number = 0;

  open() {
    const socket = new WebSocket(`ws://${location.host}/socket`);
    socket.binaryType = "arraybuffer";
    socket.onopen = () => this.#tell("open");
    socket.onmessage = ({ data }) => (typeof data === "string" ? this.#message(JSON.parse(data)) : this.#tell("rows", rowsOf(data)));
    socket.onclose = () => {
      if (this.#socket !== socket) return;
      this.#socket = null;
      for (const { reject } of this.#waiting.values()) reject(new Error("the connection to the scope was lost"));
      this.#waiting.clear();
      this.#tell("close");
      setTimeout(() => this.open(), AGAIN_MS);
    };
    this.#socket = socket;
  }

  // Resolves with the answer; rejects with the reason of a refusal.
  ask(what, fields = {}) {
    return new Promise((resolve, reject) => {
      if (this.#socket?.readyState !== WebSocket.OPEN) {
        reject(new Error("the page has no connection to the scope"));
        return;
      }
      const id = ++this.#number;
      const timer = setTimeout(() => this.#settle(id, { error: "no answer" }), ANSWER_MS);
      this.#waiting.set(id, { resolve, reject, timer });
      this.#socket.send(JSON.stringify({ id, do: what, ...fields }));
    });
  }

  #message(message) {
    if (message.type === "answer") this.#settle(message.id, message);
    else this.#tell(message.type, message);
  }

  #settle(id, message) {
    const waiting = this.#waiting.get(id);
    if (!waiting) return;
    this.#waiting.delete(id);
    clearTimeout(waiting.timer);
    if (message.error !== undefined) waiting.reject(new Error(message.error));
    else waiting.resolve(message);
  }

  #tell(type, detail) {
    this.dispatchEvent(new CustomEvent(type, { detail }));
  }

  on(type, listener) {
    this.addEventListener(type, ({ detail }) => listener(detail));
  }
}

// See messages.py for the frame.
function rowsOf(buffer) {
  const [kind, layout, rows, signals] = new Uint32Array(buffer, 0, 4);
  const t = new Float64Array(buffer, 16, rows);
  const columns = [];
  for (let i = 0; i < signals; i++) columns.push(new Float32Array(buffer, 16 + 8 * rows + 4 * rows * i, rows));
  return { kind, layout, t, columns };
}
