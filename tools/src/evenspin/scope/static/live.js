// The stream as it comes, rolling. Counts the frames that were really drawn.

import { $, fill, h, select } from "./dom.js";
import { Kept, spread } from "./kept.js";
import { Panes } from "./panes.js";
import { extent } from "./plot.js";
import { BEFORE, Trigger } from "./trigger.js";

const MEAN_S = 0.2;
const FIGURES_MS = 150;
const ROLLING = "time before now / s", STANDING = "time from the trigger / s";

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
    this.panes = new Panes(this.body, ROLLING, { changed: () => (this.#figuresAt = 0), rearranged: () => (this.#drawn = -1) });
    this.trigger = new Trigger(() => {
      this.#standing = null;
      this.#triggerChanged();
    });
    this.kept = new Kept(() => this.#take(), () => {
      this.panes.kept = this.kept.what;
      this.#drawn = -1;
    });
    this.empty = h("div", { class: "empty" });
    this.element.append(
      h("div", { class: "bar" }, this.pauseButton, h("label", {}, "Window", this.windowSelect),
        h("label", {}, "Rate", this.rateSelect, "Hz"), this.panes.cursors.button, this.kept.button, this.trigger.element, h("span", { class: "grow" }), this.note),
      this.empty, this.body, this.panes.cursors.element, this.kept.element);
    scope.on("layout", () => this.rebuild());
    scope.on("theme", () => this.rebuild());
    scope.on("status", () => this.#showEmpty());
    this.#showEmpty();
  }

  #frames;
  #drawn = -1;
  #standing = null; // the picture of the trigger
  #origin = NaN; // time at the 0 of the axis
  #figuresAt = 0;

  setSeconds(seconds) {
    this.seconds = seconds;
    this.windowSelect.value = String(seconds);
    this.#drawn = -1;
  }

  get state() {
    return { seconds: this.seconds, cursors: this.panes.cursors.state, panes: this.panes.arrangement, trigger: this.trigger.settings };
  }

  set state({ seconds, cursors, panes, trigger }) {
    this.setSeconds(seconds);
    this.panes.arrangement = panes;
    this.rebuild();
    this.trigger.settings = trigger;
    this.panes.cursors.state = cursors;
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
    fill(this.trigger.signal, names, this.trigger.signal.value || "speed_rad_s");
    if (this.#standing?.rows.names.join() !== names.join()) this.#standing = null;
    this.panes.show(names.map((name, index) => ({ name, unit: units[index], index })));
    this.#triggerChanged();
    if (rate_hz) this.rateSelect.value = String(Math.round(rate_hz));
    this.#drawn = -1;
    this.#showEmpty();
  }

  #triggerChanged() {
    const { signal, level } = this.trigger.settings;
    const place = this.scope.names.indexOf(signal);
    this.trigger.unit.textContent = this.scope.layout?.units[place] ?? "";
    this.panes.level = this.trigger.on && place >= 0 ? { place, value: level } : null;
    this.#drawn = -1;
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
    if (this.pausedAt === null) this.#standing = this.trigger.update(ring, this.seconds);
    const standing = this.#standing;
    if (!standing || standing.at !== this.#origin || this.#drawn < 0) this.#show(standing);
    this.#drawn = ring.written;
    this.#figures(now);
    this.#count(now);
  }

  #show(standing) {
    const end = this.pausedAt ?? this.scope.ring.lastTime;
    this.rows = standing?.rows ?? this.scope.ring;
    this.#origin = standing?.at ?? end;
    this.xRange = standing ? [-BEFORE * this.seconds, (1 - BEFORE) * this.seconds] : [-this.seconds, 0];
    this.panes.setAxis(standing ? STANDING : ROLLING, Boolean(standing));
    const shown = this.rows.window(this.#origin + this.xRange[0], this.#origin + this.xRange[1], this.panes.resolution, this.#origin);
    this.panes.draw(shown.t, shown.columns, this.xRange);
  }

  #figures(now) {
    if (now - this.#figuresAt < FIGURES_MS) return;
    this.#figuresAt = now;
    const { ring, names } = this.scope;
    this.panes.figures((place) => ring.mean(names[place], MEAN_S), (place, t) => this.rows?.at(place, this.#origin + t) ?? NaN);
    if (this.kept.due(now)) this.#compare();
    this.note.textContent = this.panes.cursorText("s") && `at ${this.panes.cursorText("s")}`;
  }

  get #shownTimes() {
    return this.xRange.map((x) => this.#origin + x);
  }

  #take() {
    if (!this.rows?.written) return null;
    const [from, to] = this.#shownTimes;
    const { t, columns } = this.rows.window(from, to, this.panes.resolution, this.#origin);
    const names = this.rows.names;
    const by = (make) => Object.fromEntries(names.map((name, i) => [name, make(i)]));
    return { x: t, columns: by((i) => columns[i]), limits: by((i) => extent([columns[i]])), spread: by((i) => spread(this.rows.values(i, from, to))) };
  }

  #compare() {
    const { names, layout } = this.scope;
    const columns = names.flatMap((name, i) => {
      const before = this.kept.what.spread[name];
      return before ? [{ name, unit: layout.units[i], before: before.rms, now: spread(this.rows.values(i, ...this.#shownTimes)).rms }] : [];
    });
    this.kept.fill("rms about the mean of what is shown", columns);
  }

  #count(now) {
    this.#frames.push(now);
    while (this.#frames[0] < now - 1000) this.#frames.shift();
    this.fps = this.#frames.length;
  }
}
