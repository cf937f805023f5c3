// The stream as it comes, rolling. Counts the frames that were really drawn.

import { $, h, select } from "./dom.js";
import { Panes } from "./panes.js";

const MEAN_S = 0.2;
const FIGURES_MS = 150;

export class LiveView {
  constructor(scope) {
    this.scope = scope;
    this.element = $("view-live");
    this.seconds = 5;
    this.pausedAt = null;
    this.fps = 0;
    this.#frames = [];
    this.pauseButton = h("button", { onclick: () => this.pause(), title: "P" }, "Pause");
    const windows = [["1", "1 s"], ["2", "2 s"], ["5", "5 s"], ["10", "10 s"], ["30", "30 s"], ["60", "60 s"], ["120", "120 s"]];
    this.windowSelect = select(windows, "5", (value) => this.setSeconds(Number(value)), { id: "window" });
    this.rateSelect = select(["100", "200", "500", "1000", "2000"], "1000", (value) => scope.watch(scope.names, Number(value)), { id: "rate" });
    this.note = h("span", { class: "note" });
    this.body = h("div");
    this.empty = h("div", { class: "empty" });
    this.element.append(
      h("div", { class: "bar" }, this.pauseButton, h("label", {}, "Window", this.windowSelect),
        h("label", {}, "Rate", this.rateSelect, "Hz"), h("span", { class: "grow" }), this.note),
      this.empty, this.body);
    this.panes = new Panes(this.body, "time before now / s");
    scope.on("layout", () => this.rebuild());
    scope.on("theme", () => this.rebuild());
    scope.on("status", () => this.#showEmpty());
    this.#showEmpty();
  }

  #frames;
  #drawn = -1;
  #figuresAt = 0;

  setSeconds(seconds) {
    this.seconds = seconds;
    this.windowSelect.value = String(seconds);
    this.#drawn = -1;
  }

  zoom(factor) {
    const all = [...this.windowSelect.options].map((option) => Number(option.value));
    const next = all[all.indexOf(this.seconds) + factor];
    if (next) this.setSeconds(next);
  }

  pause(on = this.pausedAt === null) {
    this.pausedAt = on ? this.scope.ring.lastTime : null;
    this.pauseButton.textContent = on ? "Continue" : "Pause";
    this.pauseButton.classList.toggle("on", on);
    this.#drawn = -1;
  }

  rebuild() {
    const { names, units, rate_hz } = this.scope.layout ?? { names: [], units: [] };
    this.panes.show(names.map((name, index) => ({ name, unit: units[index], index })));
    if (rate_hz) this.rateSelect.value = String(Math.round(rate_hz));
    this.#drawn = -1;
    this.#showEmpty();
  }

  #showEmpty() {
    const { link, ring, names } = this.scope;
    const rows = ring.written > 0 && names.length > 0;
    this.empty.hidden = rows;
    this.body.hidden = !rows;
    if (rows) return;
    const connected = link.status === "connected";
    this.empty.replaceChildren(
      h("b", {}, connected ? "Waiting for rows" : "No drive yet"),
      connected ? "Choose signals on the right (G)."
        : "The scope keeps looking. Plug the drive in and switch it on, or start a virtual one in a terminal: evenspin drive --pty");
  }

  draw(now) {
    const { ring } = this.scope;
    if (!ring.written) return;
    if (this.body.hidden) this.#showEmpty();
    if (this.#drawn >= 0 && (this.pausedAt !== null || ring.written === this.#drawn)) {
      this.#figures(now); // the cursor may move
      return;
    }
    const end = this.pausedAt ?? ring.lastTime;
    const shown = ring.window(end - this.seconds, end, this.panes.resolution, end);
    this.panes.draw(shown.t, shown.columns, [-this.seconds, 0]);
    this.#drawn = ring.written;
    this.#figures(now);
    this.#count(now);
  }

  #figures(now) {
    if (now - this.#figuresAt < FIGURES_MS) return;
    this.#figuresAt = now;
    this.panes.figures((place) => this.scope.ring.mean(this.scope.names[place], MEAN_S));
    this.note.textContent = this.panes.cursorText("s") && `at ${this.panes.cursorText("s")}`;
  }

  #count(now) {
    this.#frames.push(now);
    while (this.#frames[0] < now - 1000) this.#frames.shift();
    this.fps = this.#frames.length;
  }
}
