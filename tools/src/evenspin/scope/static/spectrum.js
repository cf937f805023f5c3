// Ripple as lines, in orders of the angle when it is among the signals. The server computes, with the analysis of evenspin.

import { Cursors, nearest } from "./cursors.js";
import { $, fill, h, numberField, numberOf, select } from "./dom.js";
import { Kept, compareLines, drawBeneath, peaks, rmsOfLines } from "./kept.js";
import { number, seconds } from "./format.js";
import { axis, fitted, nice, signalColour } from "./plot.js";

const AGAIN_MS = 400;
const TOP = 6;
const LABEL = { electrical: "order of the electrical angle", mechanical: "order of the mechanical angle (per turn)", hz: "frequency / Hz" };

export class SpectrumView {
  #fit = null;
  #asked = 0;
  #busy = false;
  #axis = "";
  #unit = "";
  #lines = [];
  #floor = 0; // of a logarithmic axis

  constructor(scope) {
    this.scope = scope;
    this.element = $("view-spectrum");
    this.signal = select([], "", () => this.#reset(), { id: "spectrum-signal" });
    this.source = select([["live", "live"], ["capture", "capture"]], "live", () => this.#choices(), { id: "spectrum-source" });
    this.axisSelect = select([["electrical", "electrical orders"], ["mechanical", "mechanical orders"], ["hz", "hertz"]], "electrical", () => this.#reset(), { id: "spectrum-axis" });
    this.seconds = select([["1", "1 s"], ["2", "2 s"], ["5", "5 s"], ["10", "10 s"], ["30", "30 s"]], "5", () => this.#reset());
    this.most = numberField(24, { id: "spectrum-most", "aria-label": "highest order" }, () => this.#reset());
    this.log = h("input", { type: "checkbox", onchange: () => this.#reset() });
    this.note = h("span", { class: "note", id: "spectrum-note" });
    this.cursors = new Cursors({
      axis: () => (this.#axis === "hz" ? { name: "f", unit: "Hz" } : { name: "order", unit: "" }),
      measure: (d) => (this.#axis === "hz" ? [["Δf", `${number(d, 5)} Hz`], ["1/Δf", d ? seconds(1 / Math.abs(d), 5) : "–"]] : [["Δ order", number(d, 5)]]),
      changed: () => this.#figures(), snap: (place, reach) => this.#peak(place, reach),
    });
    this.kept = new Kept(() => this.#keep(), () => this.#reset());
    this.body = h("div", { class: "plot" });
    this.table = h("div", { class: "strip" });
    this.empty = h("div", { class: "empty" });
    this.element.append(
      h("div", { class: "bar" }, h("label", {}, "Signal", this.signal), h("label", {}, "from", this.source),
        h("label", {}, "last", this.seconds), h("label", {}, "in", this.axisSelect), h("label", {}, "up to order", this.most),
        h("label", {}, this.log, "logarithmic"), this.cursors.button, this.kept.button, this.note),
      this.empty, this.body, this.cursors.element, this.kept.element, this.table);
    scope.on("layout", () => this.#choices());
    scope.on("theme", () => this.#reset());
    scope.on("record", () => this.source.value === "capture" && this.#choices());
  }

  #choices() {
    const names = (this.source.value === "capture" ? this.scope.capture.record?.names : this.scope.names) ?? [];
    fill(this.signal, names, this.signal.value || "speed_rad_s");
    this.#reset();
  }

  #reset() {
    this.#fit?.destroy();
    this.#fit = null;
    this.#asked = 0;
  }

  get state() {
    return {
      signal: this.signal.value, source: this.source.value, axis: this.axisSelect.value, seconds: Number(this.seconds.value),
      max_order: Math.min(500, Math.max(1, numberOf(this.most) ?? 24)), log: this.log.checked, cursors: this.cursors.state,
    };
  }

  set state({ signal, source, axis: kind, seconds: last, max_order: most, log, cursors }) {
    for (const [field, value] of [[this.source, source], [this.axisSelect, kind], [this.seconds, last], [this.most, most]]) field.value = String(value);
    this.log.checked = log;
    this.#choices();
    this.signal.value = signal;
    this.cursors.state = cursors;
    this.#reset();
  }

  draw(now) {
    if (this.#busy || now - this.#asked < AGAIN_MS) return;
    this.#asked = now;
    this.#ask();
  }

  async #ask() {
    const most = numberOf(this.most);
    if (most === null || !this.signal.value) {
      this.#nothing("Choose a signal that is streamed, or take a capture first.");
      return;
    }
    this.#busy = true;
    try {
      const answer = await this.scope.ask("spectrum", {
        signal: this.signal.value, source: this.source.value, seconds: Number(this.seconds.value),
        max_order: Math.min(500, Math.max(1, most)), axis: this.axisSelect.value,
      });
      this.#show(answer);
    } catch (error) {
      this.#nothing(error.message);
    } finally {
      this.#busy = false;
    }
  }

  #nothing(text) {
    this.empty.hidden = false;
    this.body.hidden = true;
    this.table.replaceChildren();
    this.empty.replaceChildren(h("b", {}, "No lines yet"), text);
  }

  #show({ axis: kind, x, y, mean, note }) {
    if (!x.length) {
      this.#nothing(note);
      return;
    }
    this.note.textContent = note;
    this.empty.hidden = true;
    this.body.hidden = false;
    const unit = this.scope.drive?.signals.find(({ name }) => name === this.signal.value)?.unit ?? "";
    if (!this.#fit || this.#axis !== kind) this.#build(kind, unit);
    this.#lines = y;
    const high = Math.max(...y.slice(1), ...(this.#comparable?.y.slice(1) ?? []), 1e-9);
    this.#floor = high / 1e5;
    this.range = this.log.checked ? [high / 1e4, 2 * high] : [0, nice(0, 1.08 * high)[1]];
    this.xRange = [0, x.at(-1)];
    this.#fit.plot.setData([x, this.#floored(y)]);
    this.#table(x, y, mean, unit, kind);
    this.#unit = unit;
    this.#figures();
    this.#compare();
  }

  #floored(y) {
    return this.log.checked ? y.map((value) => Math.max(value, this.#floor)) : y;
  }

  // The largest line within reach: a mouse does not hit one of hundreds.
  #peak(place, reach) {
    const [x, y] = this.#fit.plot.data;
    let best = nearest(x, place);
    for (let i = nearest(x, place - reach); x[i] <= place + reach; i++) if (y[i] > y[best]) best = i;
    return x[best] ?? place;
  }

  // On the lines themselves: between two of them there is nothing.
  #figures() {
    const x = this.#fit?.plot.data[0] ?? [], y = this.#lines;
    if (!x.length) return;
    this.cursors.at = this.cursors.at.map((place) => (Number.isFinite(place) ? x[nearest(x, place)] : place));
    this.cursors.place();
    this.cursors.show([{ name: this.signal.value, unit: this.#unit, at: (place) => y[nearest(x, place)] }]);
  }

  #build(kind, unit) {
    this.#reset();
    this.#asked = performance.now();
    this.#axis = kind;
    this.range ??= [0, 1];
    this.xRange ??= [0, 1];
    const stroke = signalColour(0);
    this.#fit = fitted(this.body, {
      cursor: { drag: { x: false, y: false } },
      scales: { x: { time: false, range: () => this.xRange }, y: { distr: this.log.checked ? 3 : 1, range: () => this.range } },
      axes: [axis(LABEL[kind], { size: 34 }), axis(["amplitude", unit].filter(Boolean).join(" / "), { size: 64 })],
      padding: [12, 14, 0, 0], hooks: { drawAxes: [(plot) => this.#drawKept(plot)] },
      series: [{}, { label: this.signal.value, stroke, width: 2.5, fill: `${stroke}44`, points: { show: false } }],
    }, [[], []]);
    this.cursors.forget();
    this.cursors.attach(this.#fit.plot);
  }

  #table(x, y, mean, unit, kind) {
    const all = peaks(y);
    const top = all.slice(0, TOP).filter((i) => y[i] > 1e-3 * y[all[0]]); // below is the floor of the analysis
    const row = (title, cells) => h("tr", {}, h("th", {}, title), ...cells.map((cell) => h("td", {}, cell)));
    this.table.replaceChildren(h("table", { class: "lines", id: "spectrum-lines" },
      row(kind === "hz" ? "frequency / Hz" : "order", top.map((i) => number(x[i], 4))),
      row(["amplitude", unit].filter(Boolean).join(" / "), top.map((i) => number(y[i], 4))),
      row("of the mean", top.map((i) => (Math.abs(mean) > 1e-6 ? `${number((100 * y[i]) / Math.abs(mean), 3)} %` : "–")))));
  }

  #keep() {
    const [x, y] = this.#fit?.plot.data ?? [[]];
    return x.length ? { x: [...x], y: [...this.#lines], axis: this.#axis, signal: this.signal.value } : null;
  }

  // Only the same signal over the same axis can be compared.
  get #comparable() {
    const { what } = this.kept;
    return what && what.signal === this.signal.value && what.axis === this.#axis ? what : null;
  }

  #compare() {
    const { what } = this.kept;
    const kept = this.#comparable;
    if (!what) return;
    const axisName = { hz: "hertz", electrical: "electrical orders", mechanical: "mechanical orders" }[what.axis];
    if (!kept) {
      this.kept.fill(`${what.signal} in ${axisName}, which is not what is shown`, []);
      return;
    }
    const now = { x: this.#fit.plot.data[0], y: this.#lines };
    const word = what.axis === "hz" ? "Hz" : "order";
    const lines = compareLines(kept, now, TOP).map(({ x, before, now: present }) => ({ name: `${number(x, 4)}`, unit: word, before, now: present }));
    this.kept.fill(`${what.signal}, amplitudes of the largest lines, and rms of all`, [
      { name: "rms", unit: this.#unit, before: rmsOfLines(kept.y), now: rmsOfLines(now.y) }, ...lines]);
  }

  #drawKept(plot) {
    const kept = this.#comparable;
    if (kept) drawBeneath(plot, kept.x, this.#floored(kept.y), signalColour(1), (value) => plot.valToPos(value, "y", true));
  }
}
