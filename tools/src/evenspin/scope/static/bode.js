// Frequency response of the drive as it runs, point by point. The server measures; here are its gains, phases and coherences.

import { $, h, numberField, numberOf, select } from "./dom.js";
import { number } from "./format.js";
import { axis, css, extent, fitted, nice, signalColour } from "./plot.js";

const PLACES = [["torque", "torque: loop gain, plant"], ["current", "current loop"], ["speed", "closed speed loop"]];
const GOOD = 0.95;
const PANES = [
  ["gain", "gain / dB", (each) => each.gain_db, 10],
  ["phase", "phase / °", (each) => each.phase_deg, 45],
  ["coherence", "coherence", (each) => each.coherence, 0.1],
];

export class BodeView {
  #plots = [];
  #found = null;
  #before = null; // the measurement before this one, drawn dashed
  #running = false;

  constructor(scope) {
    this.scope = scope;
    this.element = $("view-bode");
    this.place = select(PLACES, "torque", () => this.#units(), { id: "bode-place" });
    this.first = numberField(2, { id: "bode-first", "aria-label": "lowest frequency, Hz" });
    this.last = numberField("", { id: "bode-last", placeholder: "0.45 fs", "aria-label": "highest frequency, Hz" });
    this.points = numberField(24, { id: "bode-points", "aria-label": "number of frequencies" });
    this.amplitude = numberField("", { id: "bode-amplitude", placeholder: "limit / 20", "aria-label": "amplitude" });
    this.unit = h("span", { class: "note" });
    this.start = h("button", { class: "primary", id: "bode-start", onclick: () => this.#start() }, "Measure");
    this.end = h("button", { id: "bode-end", onclick: () => this.#end() }, "End");
    this.bar = h("progress", { max: 1, value: 0, "aria-label": "part of the measurement that is done" });
    this.csv = h("button", { id: "bode-csv", onclick: () => this.exportCsv() }, "CSV of the points");
    this.lines = h("div", { class: "strip", id: "bode-said", role: "status" });
    this.empty = h("div", { class: "empty" }, h("b", {}, "No frequency response yet"),
      "Start the motor, away from standing still, and measure: a sine is added to the reference, at one frequency after the other. The live trace rests meanwhile.");
    this.bodies = PANES.map(([name]) => h("div", { class: "plot bode-plot", id: `bode-${name}` }));
    this.element.append(
      h("div", { class: "bar" }, h("label", {}, "Sine in", this.place), h("label", {}, "from", this.first), h("label", {}, "to", this.last, "Hz"),
        h("label", {}, this.points, "points"), h("label", {}, "amplitude", this.amplitude, this.unit), this.start, this.end, this.bar, this.csv),
      this.empty, ...this.bodies, this.lines);
    scope.on("bode", (message) => this.#take(message));
    scope.on("theme", () => this.#draw());
    for (const topic of ["role", "status", "state", "drive"]) scope.on(topic, () => this.#allow());
    this.#units();
    this.#show();
    this.#allow();
  }

  draw() {}

  rebuild() {
    this.#draw();
  }

  #units() {
    this.unit.textContent = this.place.value === "speed" ? "rad/s" : "A";
  }

  #allow() {
    this.start.disabled = !this.scope.mayWrite || this.#running || this.scope.state?.state !== "run";
    this.start.title = this.scope.state?.state === "run" ? "" : "The motor must run.";
    this.end.disabled = !this.scope.mayWrite;
    this.start.hidden = this.#running;
    this.end.hidden = this.bar.hidden = !this.#running;
    this.csv.hidden = !this.#found;
  }

  async #start() {
    const optional = (field) => (field.value.trim() === "" ? null : numberOf(field));
    const wanted = { place: this.place.value, first_hz: numberOf(this.first), last_hz: optional(this.last), points: Math.round(numberOf(this.points)), amplitude: optional(this.amplitude) };
    if (this.#found) this.#before = this.#found;
    try {
      await this.scope.ask("bode", wanted);
    } catch (error) {
      this.#say([error.message], true);
    }
  }

  #end() {
    this.scope.ask("bode_end", {}).catch((error) => this.#say([error.message], true));
  }

  #say(lines, bad = false) {
    this.lines.replaceChildren(...lines.map((line) => h("p", { class: bad ? "said bad" : "said" }, line)));
  }

  #take({ status, part, lines, found }) {
    this.#running = status === "running";
    this.bar.value = part;
    this.lines.dataset.status = status;
    if (found) this.#found = found;
    this.#say(lines, status === "failed");
    this.#allow();
    this.#show();
  }

  #show() {
    this.empty.hidden = this.#found !== null;
    for (const body of this.bodies) body.hidden = this.#found === null;
    if (this.#found && !this.element.hidden) this.#draw();
  }

  // Frequencies of both measurements together; what one of them does not have is null.
  #columns(of) {
    const all = [this.#found, this.#before].filter(Boolean);
    const x = [...new Set(all.flatMap(({ points }) => points.map(({ f_hz: f }) => f)))].sort((a, b) => a - b);
    const series = all.flatMap((found, index) => Object.keys(found.units).map((name, colour) => {
      const known = new Map(found.points.map((point) => [point.f_hz, of(point[name])]));
      return { name, colour, before: index > 0, y: x.map((f) => known.get(f) ?? null) };
    }));
    return { x, series };
  }

  #draw() {
    for (const { destroy } of this.#plots) destroy();
    this.#plots = [];
    if (!this.#found || this.element.hidden) return;
    this.#plots = PANES.map(([name, label, of, least], index) => {
      const { x, series } = this.#columns(of);
      const [low, high] = name === "coherence" ? [0, 1] : nice(...extent(series.map(({ y }) => y)), least);
      return fitted(this.bodies[index], {
        cursor: { drag: { x: false, y: false } },
        scales: { x: { time: false, distr: 3 }, y: { range: () => [low - 0.05 * (high - low), high + 0.05 * (high - low)] } },
        axes: [axis(index === PANES.length - 1 ? "frequency / Hz" : "", { size: 34 }), axis(label, { size: 64 })],
        padding: [8, 14, 0, 0], hooks: { drawAxes: [(plot) => this.#guide(plot, name)] },
        series: [{}, ...series.map(({ name: text, colour, before }) => ({
          label: text, stroke: signalColour(colour), width: before ? 1 : 2, dash: before ? [5, 5] : [], spanGaps: true, points: { show: !before, size: 5 },
        }))],
      }, [x, ...series.map(({ y }) => y)]);
    });
    this.bodies[0].dataset.names = Object.keys(this.#found.units).join();
    this.#legend();
  }

  #legend() {
    const names = Object.entries(this.#found.units).map(([name, unit], colour) => {
      const item = h("span", {}, `■ ${name}${unit ? ` / ${unit}` : ""}  `);
      item.style.color = signalColour(colour);
      return item;
    });
    const old = this.#before ? "dashed: the measurement before" : "";
    this.lines.prepend(h("p", { class: "said", id: "bode-legend" }, ...names, old));
    for (const other of [...this.lines.querySelectorAll("#bode-legend")].slice(1)) other.remove();
  }

  // 0 dB, −180°, and from where on a point is good.
  #guide(plot, name) {
    const y = plot.valToPos({ gain: 0, phase: -180, coherence: GOOD }[name], "y", true);
    const { left, top, width, height } = plot.bbox;
    if (y < top || y > top + height) return;
    const pen = plot.ctx;
    pen.save();
    pen.strokeStyle = css("--soft");
    pen.setLineDash([6, 6]);
    pen.beginPath();
    pen.moveTo(left, y);
    pen.lineTo(left + width, y);
    pen.stroke();
    pen.restore();
  }

  exportCsv() {
    if (!this.#found) return;
    const names = Object.keys(this.#found.units);
    const head = ["f_hz", ...names.flatMap((name) => ["gain", "phase_deg", "coherence", "error"].map((what) => `${name}_${what}`)), "good"];
    const rows = this.#found.points.map((point) => [point.f_hz, ...names.flatMap((name) => ["gain", "phase_deg", "coherence", "error"].map((what) => point[name][what] ?? "")), point.good ? 1 : 0]);
    const url = URL.createObjectURL(new Blob([[head, ...rows].map((row) => row.join()).join("\n") + "\n"], { type: "text/csv" }));
    h("a", { href: url, download: "bode.csv" }).click();
    setTimeout(() => URL.revokeObjectURL(url), 1000);
    this.scope.tell("said", `${number(rows.length)} points exported`);
  }
}
