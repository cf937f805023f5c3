// Full rate around a trigger: what to record, when, and the record.

import { $, fill, h, numberField, numberOf, select } from "./dom.js";
import { number, seconds, withUnit } from "./format.js";
import { Kept, spread } from "./kept.js";
import { Panes } from "./panes.js";
import { extent } from "./plot.js";

const KINDS = [["rising", "rises above"], ["falling", "falls below"], ["either", "crosses"],
  ["immediate", "at once"], ["manual", "by hand"], ["fault", "at a fault"]];
const FIRST = ["ia_a", "ib_a", "id_a", "iq_a", "iq_ref_a", "speed_rad_s", "vd_v", "vq_v"];

export class CaptureView {
  constructor(scope) {
    this.scope = scope;
    this.element = $("view-capture");
    this.names = [];
    this.record = null;
    this.all = false;
    this.chips = h("div", { class: "chips", role: "group", "aria-label": "signals of the capture" });
    this.more = h("button", { id: "capture-signals", onclick: () => { this.all = !this.all; this.more.textContent = this.all ? "done" : "choose signals…"; this.#adapt(); } }, "choose signals…");
    this.kind = select(KINDS, "immediate", () => this.#adapt(), { id: "trigger" });
    this.watched = select([], "", () => this.#adapt(), { id: "trigger-signal" });
    this.level = numberField(0, { id: "trigger-level", "aria-label": "trigger level" }, () => this.arm());
    this.levelUnit = h("span");
    this.rows = numberField(1000, { id: "capture-rows" }, () => this.arm());
    this.rows.oninput = () => this.#adapt();
    this.pre = numberField(20, { id: "capture-pre" }, () => this.arm());
    this.every = select([["1", "every period"], ["2", "every 2nd"], ["5", "every 5th"], ["10", "every 10th"]], "1", () => this.#adapt());
    this.duration = h("span", { class: "note" });
    this.armButton = h("button", { class: "primary", id: "capture-arm", onclick: () => this.arm(), title: "C" }, "Capture");
    this.repeat = h("input", { type: "checkbox", id: "capture-repeat" });
    this.now = h("button", { id: "capture-now", onclick: () => this.#ask("capture_now") }, "Trigger now");
    this.cancel = h("button", { onclick: () => this.#ask("capture_cancel") }, "Cancel");
    this.status = h("b", { id: "capture-status", role: "status" });
    this.title = h("span", { class: "note", id: "capture-title", title: "Drag in the plot to zoom, double click to see all" });
    this.edge = h("label", {}, this.watched, this.kindWord = h("span"), this.level, this.levelUnit);
    this.body = h("div");
    this.panes = new Panes(this.body, "time from the trigger / ms", { zoom: true, xUnit: "ms", rearranged: () => this.#show() });
    this.kept = new Kept(() => this.#keep(), () => {
      this.panes.kept = this.kept.what;
      this.#show();
    });
    this.empty = h("div", { class: "empty" }, h("b", {}, "No capture yet"),
      "Choose signals and a trigger, then press Capture (C). The drive records every current-loop period in its own memory.");
    this.element.append(
      h("div", { class: "bar" }, this.chips),
      h("div", { class: "bar" }, h("label", {}, "Trigger", this.kind), this.edge,
        h("label", {}, "Rows", this.rows), h("label", {}, "before", this.pre, "%"), this.every, this.duration),
      h("div", { class: "bar" }, this.armButton, h("label", {}, this.repeat, "again and again"), this.now, this.cancel,
        this.panes.cursors.button, this.kept.button, this.status, h("span", { class: "grow" }), this.title),
      this.empty, this.body, this.panes.cursors.element, this.kept.element);
    this.body.hidden = true;
    scope.on("drive", () => this.#adopt());
    scope.on("theme", () => this.#show());
    scope.on("role", () => this.#adapt());
    scope.on("capture", ({ status, text }) => this.#say(status, text));
  }

  #adopt() {
    const all = this.scope.drive.signals;
    this.names = this.names.filter((name) => all.some((signal) => signal.name === name));
    if (!this.names.length) this.names = FIRST.filter((name) => all.some((signal) => signal.name === name));
    this.chips.replaceChildren(...all.map(({ name, doc, unit }) => {
      const chip = h("button", { title: `${withUnit(doc, unit && `(${unit})`)}`, "data-name": name, onclick: () => this.#toggle(name) }, name);
      return chip;
    }), this.more);
    fill(this.watched, all.map((signal) => signal.name), this.watched.value || "speed_rad_s");
    this.#adapt();
  }

  #toggle(name) {
    if (this.names.includes(name)) this.names = this.names.filter((other) => other !== name);
    else if (this.names.length < this.scope.drive.capture_signals) this.names = [...this.names, name];
    else this.#say("failed", `At most ${this.scope.drive.capture_signals} signals: take one away first.`);
    this.#adapt();
  }

  #adapt() {
    const { drive } = this.scope;
    if (!drive) return;
    const edge = ["rising", "falling", "either"].includes(this.kind.value);
    this.edge.hidden = !edge;
    this.levelUnit.textContent = drive.signals.find((signal) => signal.name === this.watched.value)?.unit ?? "";
    for (const chip of this.chips.children) {
      if (!chip.dataset.name) continue;
      const on = this.names.includes(chip.dataset.name);
      chip.setAttribute("aria-pressed", on);
      chip.hidden = !on && !this.all;
    }
    const most = Math.floor(drive.capture_values / Math.max(1, this.names.length));
    const rows = Math.min(Number(this.rows.value) || 0, most);
    const span = (rows * Number(this.every.value)) / drive.pwm_hz;
    this.duration.textContent = `= ${seconds(span)}, at most ${most}`;
    for (const control of [this.armButton, this.now, this.cancel]) control.disabled = !this.scope.mayWrite && !this.scope.mayLook;
  }

  async arm() {
    const [rows, pre, level] = [numberOf(this.rows), numberOf(this.pre), numberOf(this.level)];
    if (rows === null || pre === null || level === null) return;
    this.#say("arming", "Arming");
    await this.#ask("capture", {
      signals: this.names, trigger: this.kind.value, signal: this.watched.value || null, level,
      rows: Math.max(2, Math.round(rows)), pre_pct: pre, decimation: Number(this.every.value), repeat: this.repeat.checked,
    });
  }

  async #ask(what, fields) {
    try {
      await this.scope.ask(what, fields);
    } catch (error) {
      this.#say("failed", error.message);
    }
  }

  #say(status, text) {
    this.status.dataset.status = status;
    this.status.textContent = text;
    this.status.style.color = status === "failed" ? "var(--bad)" : status === "complete" ? "var(--good)" : "var(--warn)";
  }

  take(layout, t, columns) {
    this.record = { ...layout, t: Array.from(t, (value) => 1000 * value), columns };
    this.element.dataset.record = layout.id;
    this.all = false;
    this.more.textContent = "choose signals…";
    this.#adapt();
    this.#show();
  }

  #show() {
    const { record } = this;
    if (!record) return;
    this.empty.hidden = true;
    this.body.hidden = false;
    this.title.textContent = `${record.title} · ${record.rows} rows at ${number(record.rate_hz / 1000, 3)} kHz`;
    this.panes.show(record.names.map((name, index) => ({ name, unit: record.units[index], index })));
    this.panes.draw(record.t, record.columns.map((column) => Array.from(column)), extent([record.t]));
  }

  get state() {
    return {
      signals: this.names, trigger: this.kind.value, signal: this.watched.value, level: numberOf(this.level) ?? 0,
      rows: Math.max(2, numberOf(this.rows) ?? 1000), before_pct: numberOf(this.pre) ?? 20, every: Number(this.every.value), repeat: this.repeat.checked,
      cursors: this.panes.cursors.state, panes: this.panes.arrangement,
    };
  }

  set state({ signals, trigger, signal, level, rows, before_pct: before, every, repeat, cursors, panes }) {
    this.names = signals;
    for (const [field, value] of [[this.kind, trigger], [this.watched, signal], [this.level, level], [this.rows, rows], [this.pre, before], [this.every, every]]) field.value = String(value);
    this.repeat.checked = repeat;
    this.panes.arrangement = panes;
    this.#adopt();
    this.#show();
    this.panes.cursors.state = cursors;
  }

  #keep() {
    const { record } = this;
    if (!record) return null;
    const by = (make) => Object.fromEntries(record.names.map((name, i) => [name, make(Array.from(record.columns[i]))]));
    return { x: record.t, columns: by((values) => values), limits: by((values) => extent([values])), spread: by(spread) };
  }

  draw(now) {
    const { record } = this;
    if (!record) return;
    this.panes.figures((place) => record.columns[place].at(-1));
    if (!this.kept.due(now)) return;
    const both = record.names.map((name, i) => ({ name, unit: record.units[i], before: this.kept.what.spread[name]?.rms, now: spread(record.columns[i]).rms }));
    this.kept.fill("rms about the mean of the record", both.filter(({ before }) => before !== undefined));
  }
}
