// Plots over one axis, a pane for each unit: speeds with speeds, currents with currents. Used by live and capture.

import { Cursors, nearest } from "./cursors.js";
import { h } from "./dom.js";
import { drawBeneath } from "./kept.js";
import { isReference, number, seconds, withUnit } from "./format.js";
import { axis, css, extent, fitted, Limits, signalColour } from "./plot.js";

const LEAST = { "rad/s": 1, A: 0.2, V: 0.5, rad: 0.1 }; // narrowest range of an axis, by unit

export class Panes {
  #element;
  #panes = [];
  #signals = [];
  #xLabel;
  #xRange = [0, 1];
  #sync = uPlot.sync(`panes ${Math.random()}`);
  #zoom;

  // `xUnit`: "s" or "ms". `zoom`: dragging zooms into a record that stands still, a double click shows all of it; 0 is its trigger.
  constructor(element, xLabel, { zoom = false, xUnit = "s", changed, rearranged = () => {} } = {}) {
    this.rearranged = rearranged;
    this.#element = element;
    this.arrangement = { order: [], folded: [] }; // units
    this.zero = zoom;
    this.level = null; // {place, value} of the trigger
    this.kept = null; // {x, columns: {name: values}, limits: {name: [low, high]}}, beneath what is shown
    const second = xUnit === "ms" ? 1e-3 : 1;
    this.cursors = new Cursors({
      axis: () => ({ name: "t", unit: xUnit }), changed,
      measure: (dt) => [["Δt", seconds(dt * second, 5)], ["1/Δt", dt ? `${number(1 / Math.abs(dt * second), 5)} Hz` : "–"]],
    });
    this.#xLabel = xLabel;
    this.#zoom = zoom;
    element.classList.add("panes");
  }

  // `zero`: a line stands at 0, where the trigger was.
  setAxis(label, zero) {
    this.zero = zero;
    if (label === this.#xLabel) return;
    this.#xLabel = label;
    this.rebuild();
  }

  // signals: [{name, unit, index}], `index` chooses the colour.
  show(signals) {
    this.#signals = signals;
    this.rebuild();
  }

  rebuild() {
    for (const pane of this.#panes) pane.fit.destroy();
    this.cursors.forget();
    const { order, folded } = this.arrangement;
    const units = [...new Set(this.#signals.map((signal) => signal.unit))];
    const rank = (unit) => (order.includes(unit) ? order.indexOf(unit) : order.length + units.indexOf(unit));
    const sorted = units.toSorted((a, b) => rank(a) - rank(b));
    const last = sorted.filter((unit) => !folded.includes(unit)).at(-1);
    this.#panes = sorted.map((unit) => this.#pane(unit, unit === last));
    this.#panes.forEach((pane, i) => pane.element.firstChild.append(this.#buttons(sorted, i)));
    this.#element.replaceChildren(...this.#panes.map((pane) => pane.element));
    for (const pane of this.#panes) {
      pane.fit = fitted(pane.plotElement, pane.options, pane.empty);
      this.cursors.attach(pane.fit.plot);
    }
  }

  #buttons(units, i) {
    const unit = units[i];
    const { folded } = this.arrangement;
    const open = !folded.includes(unit);
    const rearrange = (change) => () => {
      this.arrangement = { ...this.arrangement, ...change };
      this.rebuild();
      this.rearranged();
    };
    const swapped = units.with(i, units[i - 1]).with(i - 1, unit);
    return h("div", { class: "arrange" },
      i > 0 ? h("button", { class: "small", "data-up": unit, title: "one place up", onclick: rearrange({ order: swapped }) }, "↑") : null,
      h("button", { class: "small", "data-fold": unit, title: open ? "fold away" : "unfold", "aria-expanded": String(open), onclick: rearrange({ folded: open ? [...folded, unit] : folded.filter((other) => other !== unit) }) }, open ? "–" : "+"));
  }

  #pane(unit, isLast) {
    const places = this.#signals.flatMap((signal, place) => (signal.unit === unit ? [place] : []));
    const figures = places.map(() => h("b", {}, "–"));
    const legend = h("div", { class: "legend" }, ...places.map((place, i) => {
      const { name, index } = this.#signals[place];
      const mark = h("i", { class: isReference(name) ? "dashed" : "" });
      mark.style.borderTopColor = signalColour(index);
      return h("span", { "data-signal": name }, mark, name, figures[i], h("em", {}, unit));
    }));
    const plotElement = h("div", { class: "plot" });
    const limits = new Limits();
    const pane = { places, figures, limits, plotElement, unit, element: h("div", { class: "pane" }, legend, plotElement) };
    pane.element.classList.toggle("folded", this.arrangement.folded.includes(unit));
    pane.element.style.flexGrow = isLast ? "1.16" : "1"; // room for the labels of the time axis
    pane.empty = [[], ...places.map(() => [])];
    pane.options = {
      cursor: {
        sync: { key: this.#sync.key, setSeries: false }, drag: { x: this.#zoom, y: false },
        points: { size: 7 }, y: false,
      },
      padding: [8, 12, 0, 0],
      scales: { x: { time: false, range: (_, low, high) => this.#range(low, high) }, y: { range: () => limits.range } },
      axes: [
        axis(isLast ? this.#xLabel : undefined, isLast ? { size: 30 } : { size: 8, values: (_, ticks) => ticks.map(() => "") }),
        axis(unit || "–", { size: 50, space: 20 }),
      ],
      series: [{}, ...places.map((place) => {
        const { name, index } = this.#signals[place];
        const dash = isReference(name) ? { dash: [7, 5] } : {};
        return { label: name, stroke: signalColour(index), width: 1.6, points: { show: false }, spanGaps: false, ...dash };
      })],
      hooks: {
        // Round joints, uPlot's choice, cost a fifth of the frames without a graphics processor.
        drawAxes: [(plot) => { plot.ctx.lineJoin = "bevel"; }, (plot) => this.#drawKept(plot, places)],
        draw: [(plot) => this.#drawMarks(plot, places)],
        setScale: this.#zoom ? [() => this.cursors.place()] : [],
      },
    };
    return pane;
  }

  // uPlot asks with the limits of a drag, or with those of the data: then the whole record is shown.
  #range(low, high) {
    const [from, to] = this.#xRange;
    const dragged = this.#zoom && low !== null && high - low < 0.98 * (to - from);
    return dragged ? [low, high] : [from, to];
  }

  #drawKept(plot, places) {
    if (!this.kept) return;
    const { top, height } = plot.bbox, { min, max } = plot.scales.y;
    const toY = (value) => top + ((max - value) / (max - min)) * height;
    for (const place of places) {
      const { name, index } = this.#signals[place];
      const ys = this.kept.columns[name];
      if (ys) drawBeneath(plot, this.kept.x, ys, signalColour(index), toY);
    }
  }

  #drawMarks(plot, places) {
    const { left, top, width, height } = plot.bbox;
    const at = (value, scale) => Math.round(plot.valToPos(value, scale, true)) + 0.5;
    const line = (from, to) => {
      plot.ctx.save();
      plot.ctx.strokeStyle = css("--warn");
      plot.ctx.setLineDash([4, 4]);
      plot.ctx.beginPath();
      plot.ctx.moveTo(...from);
      plot.ctx.lineTo(...to);
      plot.ctx.stroke();
      plot.ctx.restore();
    };
    const { x, y } = plot.scales;
    if (this.zero && x.min <= 0 && x.max >= 0) line([at(0, "x"), top], [at(0, "x"), top + height]);
    const { level } = this;
    if (level && places.includes(level.place) && level.value >= y.min && level.value <= y.max) {
      line([left, at(level.value, "y")], [left + width, at(level.value, "y")]);
    }
  }

  // How many stretches of time the plots can tell apart: the lines are nearly two pixels wide.
  get resolution() {
    const width = Math.max(0, ...this.#panes.map((pane) => pane.plotElement.clientWidth)); // one may be folded
    return Math.max(100, ((width || 600) - 60) / 2);
  }

  // columns in the order of the signals.
  draw(x, columns, xRange) {
    this.#xRange = xRange;
    for (const pane of this.#panes) {
      const chosen = pane.places.map((place) => columns[place]);
      const kept = pane.places.map((place) => this.kept?.limits[this.#signals[place].name] ?? []);
      pane.limits.follow(...extent([...chosen, ...kept]), LEAST[pane.unit] ?? 0);
      pane.fit.plot.setData([x, ...chosen]);
    }
    this.cursors.place();
  }

  // Figures beside the names: under the mouse if it is there, else from `value(place)`; and those of the two cursors, from
  // `at(place, x)` or from what is drawn.
  figures(value, at = (place, x) => this.#drawn(place, x)) {
    this.cursors.show(this.#signals.map(({ name, unit }, place) => ({ name, unit, at: (x) => at(place, x) })));
    for (const pane of this.#panes) {
      const { idx, left } = pane.fit.plot.cursor;
      pane.places.forEach((place, i) => {
        const shown = idx !== null && idx !== undefined && left >= 0 ? pane.fit.plot.data[i + 1][idx] : value(place);
        pane.figures[i].textContent = number(shown ?? NaN);
      });
    }
  }

  #drawn(place, x) {
    const pane = this.#panes.find(({ places }) => places.includes(place));
    const { data } = pane.fit.plot;
    return data[0].length ? data[pane.places.indexOf(place) + 1][nearest(data[0], x)] ?? NaN : NaN;
  }

  // Where the mouse is, as text, or "".
  cursorText(unit) {
    for (const { fit } of this.#panes) {
      const { idx, left } = fit.plot.cursor;
      if (idx !== null && idx !== undefined && left >= 0) return withUnit(number(fit.plot.data[0][idx]), unit);
    }
    return "";
  }
}
