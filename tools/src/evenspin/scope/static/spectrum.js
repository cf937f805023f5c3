// Ripple as lines, in orders of the angle when it is among the signals. The server computes, with the analysis of evenspin.

import { $, fill, h, numberField, numberOf, select } from "./dom.js";
import { number } from "./format.js";
import { axis, fitted, nice, signalColour } from "./plot.js";

const AGAIN_MS = 400;
const TOP = 6;
const LABEL = { electrical: "order of the electrical angle", mechanical: "order of the mechanical angle (per turn)", hz: "frequency / Hz" };

export class SpectrumView {
  #fit = null;
  #asked = 0;
  #busy = false;
  #axis = "";

  constructor(scope) {
    this.scope = scope;
    this.element = $("view-spectrum");
    this.signal = select([], "", () => this.#reset(), { id: "spectrum-signal" });
    this.source = select([["live", "live"], ["capture", "capture"]], "live", () => this.#choices());
    this.axisSelect = select([["electrical", "electrical orders"], ["mechanical", "mechanical orders"], ["hz", "hertz"]], "electrical", () => this.#reset(), { id: "spectrum-axis" });
    this.seconds = select([["1", "1 s"], ["2", "2 s"], ["5", "5 s"], ["10", "10 s"], ["30", "30 s"]], "5", () => this.#reset());
    this.most = numberField(24, { id: "spectrum-most", "aria-label": "highest order" }, () => this.#reset());
    this.log = h("input", { type: "checkbox", onchange: () => this.#reset() });
    this.note = h("span", { class: "note", id: "spectrum-note" });
    this.body = h("div", { class: "plot" });
    this.table = h("div", { class: "strip" });
    this.empty = h("div", { class: "empty" });
    this.element.append(
      h("div", { class: "bar" }, h("label", {}, "Signal", this.signal), h("label", {}, "from", this.source),
        h("label", {}, "last", this.seconds), h("label", {}, "in", this.axisSelect), h("label", {}, "up to order", this.most),
        h("label", {}, this.log, "logarithmic"), this.note),
      this.empty, this.body, this.table);
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
    const high = Math.max(...y.slice(1), 1e-9);
    this.range = this.log.checked ? [high / 1e4, 2 * high] : [0, nice(0, 1.08 * high)[1]];
    this.xRange = [0, x.at(-1)];
    this.#fit.plot.setData([x, y.map((value) => (this.log.checked ? Math.max(value, high / 1e5) : value))]);
    this.#table(x, y, mean, unit, kind);
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
      padding: [12, 14, 0, 0],
      series: [{}, { label: this.signal.value, stroke, width: 2.5, fill: `${stroke}44`, points: { show: false } }],
    }, [[], []]);
  }

  // The largest lines: peaks, not the flanks of one.
  #table(x, y, mean, unit, kind) {
    const peaks = [];
    for (let i = 1; i < y.length; i++) {
      if (y[i] >= (y[i - 1] ?? 0) && y[i] > (y[i + 1] ?? 0)) peaks.push(i);
    }
    peaks.sort((a, b) => y[b] - y[a]);
    const top = peaks.slice(0, TOP).filter((i) => y[i] > 1e-3 * y[peaks[0]]); // below is the floor of the analysis
    const row = (title, cells) => h("tr", {}, h("th", {}, title), ...cells.map((cell) => h("td", {}, cell)));
    this.table.replaceChildren(h("table", { class: "lines", id: "spectrum-lines" },
      row(kind === "hz" ? "frequency / Hz" : "order", top.map((i) => number(x[i], 4))),
      row(["amplitude", unit].filter(Boolean).join(" / "), top.map((i) => number(y[i], 4))),
      row("of the mean", top.map((i) => (Math.abs(mean) > 1e-6 ? `${number((100 * y[i]) / Math.abs(mean), 3)} %` : "–")))));
  }
}
