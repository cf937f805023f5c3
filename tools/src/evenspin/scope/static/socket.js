// The connection to the server: requests with answers, messages, rows. Opens itself again; asks for nothing by itself.
// A second connection carries stops alone, so that nothing that was asked before can stand in front of one.

const AGAIN_MS = 500;
const ANSWER_MS = 15000;
const SILENT_MS = 2000; // the server says something several times a second
const WATCH_MS = 250;

// Of the address that the command printed: whoever does not have it is refused.
const access = new URLSearchParams(location.search).get("token") ?? "";

export const withToken = (path) => `${path}${path.includes("?") ? "&" : "?"}token=${encodeURIComponent(access)}`;

// The same when this page is loaded again: it keeps its place.
function pageToken() {
  const token = sessionStorage.getItem("page") ?? Array.from(crypto.getRandomValues(new Uint32Array(4)), (n) => n.toString(36)).join("");
  sessionStorage.setItem("page", token);
  return token;
}

export class Socket extends EventTarget {
  #socket = null;
  #waiting = new Map();
  #number = 0;
  #stops = null;
  #heardAt = 0;

  open() {
    const socket = new WebSocket(`ws://${location.host}${withToken(`/socket?page=${pageToken()}`)}`);
    socket.binaryType = "arraybuffer";
    let opened = false;
    socket.onopen = () => {
      opened = true;
      this.#tell("open");
    };
    socket.onmessage = ({ data }) => {
      this.#heardAt = performance.now();
      if (typeof data === "string") this.#message(JSON.parse(data));
      else this.#tell("rows", rowsOf(data));
    };
    socket.onclose = () => this.#lost(socket, opened);
    this.#socket = socket;
    this.#heardAt = performance.now();
    const watch = setInterval(() => {
      if (this.#socket !== socket) clearInterval(watch);
      else if (performance.now() - this.#heardAt > SILENT_MS) {
        this.#lost(socket);
        socket.close();
      }
    }, WATCH_MS);
    if (this.#stops === null) this.#openStops();
  }

  #lost(socket, opened = true) {
    if (this.#socket !== socket) return;
    this.#socket = null;
    this.#stops?.close();
    for (const { reject } of this.#waiting.values()) reject(new Error("the connection to the scope was lost"));
    this.#waiting.clear();
    this.#tell("close");
    setTimeout(() => (opened ? this.open() : this.#again()), AGAIN_MS);
  }

  // Not let in: a scope that was started again has another token, and this page says so. Else it tries again.
  async #again() {
    const answer = await fetch(withToken("/"), { method: "HEAD", signal: AbortSignal.timeout(SILENT_MS) }).catch(() => null);
    if (answer?.status === 403) this.#tell("refused");
    else this.open();
  }

  #openStops() {
    const stops = new WebSocket(`ws://${location.host}${withToken(`/stop?page=${pageToken()}`)}`);
    stops.onmessage = ({ data }) => this.#message(JSON.parse(data));
    stops.onclose = () => {
      this.#stops = null;
      if (this.#socket !== null) setTimeout(() => this.#stops ?? this.#openStops(), AGAIN_MS);
    };
    this.#stops = stops;
  }

  // Leaves the page before this returns, on both ways; resolves when one of them has brought an answer.
  stop() {
    const ways = [this.#stops, this.#socket].filter((way) => way?.readyState === WebSocket.OPEN);
    if (!ways.length) return Promise.reject(new Error("the page has no connection to the scope"));
    return Promise.any(ways.map((way) => this.#send(way, "stop", {}))).catch(({ errors }) => Promise.reject(errors[0]));
  }

  // Resolves with the answer; rejects with the reason of a refusal.
  ask(what, fields = {}) {
    if (this.#socket?.readyState !== WebSocket.OPEN) return Promise.reject(new Error("the page has no connection to the scope"));
    return this.#send(this.#socket, what, fields);
  }

  #send(way, what, fields) {
    return new Promise((resolve, reject) => {
      const id = ++this.#number;
      way.send(JSON.stringify({ id, do: what, ...fields }));
      const timer = setTimeout(() => this.#settle(id, { error: "no answer" }), ANSWER_MS);
      this.#waiting.set(id, { resolve, reject, timer });
    });
  }

  #message(message) {
    if (message.type === "answer") this.#settle(message.id, message);
    else if (message.type === "alive") this.#socket?.send('{"do":"alive"}');
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
