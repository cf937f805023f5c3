// Where the live trace crosses a level, and at which crossing the picture stands. `auto` rolls on when there is none, `normal` keeps
// the last picture, `single` stands at the first one until it is armed again.

import { h, numberField, numberOf, select } from "./dom.js";

const MODES = [["off", "off"], ["auto", "auto"], ["normal", "normal"], ["single", "single"]];
const EDGES = [["rising", "rises above"], ["falling", "falls below"], ["either", "crosses"]];
const SAY = { off: "", auto: "rolling: no trigger", waiting: "waiting", shown: "triggered", held: "stands; again with R" };
export const BEFORE = 0.2; // of the window

export class Trigger {
  #ring = null;
  #next = 0; // rows before this one have been searched
  #crossing = null; // that was found; the window behind it is not yet full
  #shown = null; // {at, rows}
  #since = 0; // time since which there was none

  constructor(changed) {
    this.changed = () => {
      this.again();
      changed();
    };
    this.mode = select(MODES, "off", this.changed, { id: "live-trigger" });
    this.signal = select([], "", this.changed, { id: "live-trigger-signal" });
    this.edge = select(EDGES, "rising", this.changed, { id: "live-trigger-edge" });
    this.level = numberField(0, { id: "live-trigger-level", "aria-label": "level of the trigger on the live trace" }, this.changed);
    this.level.addEventListener("change", this.changed);
    this.unit = h("span");
    this.rearm = h("button", { id: "live-trigger-again", title: "R", onclick: this.changed }, "Again");
    this.status = h("b", { id: "live-trigger-status", role: "status" });
    this.details = h("label", {}, this.signal, this.edge, this.level, this.unit);
    this.element = h("span", { class: "trigger" }, h("label", {}, "Trigger", this.mode), this.details, this.rearm, this.status);
    this.#adapt();
  }

  get on() {
    return this.mode.value !== "off";
  }

  get settings() {
    return { mode: this.mode.value, signal: this.signal.value, edge: this.edge.value, level: numberOf(this.level) ?? 0 };
  }

  set settings({ mode, signal, edge, level }) {
    this.signal.value = signal;
    this.edge.value = edge;
    this.level.value = String(level);
    this.mode.value = this.signal.value === signal ? mode : "off";
    this.changed();
  }

  nextMode() {
    const names = MODES.map(([name]) => name);
    this.mode.value = names[(names.indexOf(this.mode.value) + 1) % names.length];
    this.changed();
  }

  // From now on: what came before is not looked at.
  again() {
    this.#ring = null;
    this.#adapt();
  }

  #adapt() {
    this.details.hidden = !this.on;
    this.rearm.hidden = this.mode.value !== "single";
    this.#say(this.on ? "waiting" : "off");
  }

  #say(what) {
    if (this.status.dataset.status === what) return;
    this.status.dataset.status = what;
    this.status.textContent = SAY[what];
  }

  // {at, rows} of the picture that stands, or null: then the trace rolls.
  update(ring, seconds) {
    if (!this.on) return null;
    const place = ring.names.indexOf(this.signal.value);
    const level = numberOf(this.level);
    if (place < 0 || level === null) return null;
    if (this.#ring !== ring) {
      this.#ring = ring;
      this.#next = ring.written;
      this.#crossing = this.#shown = null;
      this.#since = ring.lastTime;
    }
    while (!(this.mode.value === "single" && this.#shown) && this.#search(ring, place, level, seconds));
    if (this.#shown) {
      const stale = this.mode.value === "auto" && ring.lastTime - this.#shown.at > 2 * seconds + 1;
      this.#say(stale ? "auto" : this.mode.value === "single" ? "held" : "shown");
      return stale ? null : this.#shown;
    }
    this.#say(this.mode.value === "auto" && ring.lastTime - this.#since > seconds ? "auto" : "waiting");
    return null;
  }

  // Whether another picture is complete.
  #search(ring, place, level, seconds) {
    const after = (1 - BEFORE) * seconds;
    for (; this.#crossing === null && this.#next < ring.written; this.#next++) this.#crossing = this.#crossingAt(ring, place, level);
    if (this.#crossing === null || ring.lastTime < this.#crossing + after) return false;
    const at = this.#crossing;
    this.#crossing = null;
    this.#shown = { at, rows: ring.copy(at - BEFORE * seconds, at + after) };
    this.#next = Math.max(this.#next, ring.range(at + after, at + after)[0]);
    return true;
  }

  // The time at which the level is crossed between the next row and the one before, or null.
  #crossingAt(ring, place, level) {
    if (this.#next < 1 || this.#next <= ring.written - ring.capacity) return null;
    const column = ring.columns[place], here = this.#next % ring.capacity, there = (this.#next - 1) % ring.capacity;
    const before = column[there], value = column[here];
    const rises = before < level && value >= level, falls = before > level && value <= level;
    if (!((rises && this.edge.value !== "falling") || (falls && this.edge.value !== "rising"))) return null;
    return ring.t[there] + ((level - before) / (value - before)) * (ring.t[here] - ring.t[there]);
  }
}
