// Plots over one axis, a pane for each unit: speeds with speeds, currents with currents. Used by live and capture.

import { h } from "./dom.js";
import { isReference, number, withUnit } from "./format.js";
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

  // `zoom`: dragging zooms into a record that stands still, a double click shows all of it; 0 is its trigger.
  constructor(element, xLabel, { zoom = false } = {}) {
    this.#element = element;
    this.#xLabel = xLabel;
    this.#zoom = zoom;
    element.classList.add("panes");
  }

  set xLabel(text) {
    this.#xLabel = text;
    this.rebuild();
  }

  // signals: [{name, unit, index}], `index` chooses the colour.
  show(signals) {
    this.#signals = signals;
    this.rebuild();
  }

  rebuild() {
    for (const pane of this.#panes) pane.fit.destroy();
    const units = [...new Set(this.#signals.map((signal) => signal.unit))];
    this.#panes = units.map((unit, number_) => this.#pane(unit, number_ + 1 === units.length));
    this.#element.replaceChildren(...this.#panes.map((pane) => pane.element));
    for (const pane of this.#panes) pane.fit = fitted(pane.plotElement, pane.options, pane.empty);
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
        drawAxes: [(plot) => { plot.ctx.lineJoin = "bevel"; }],
        draw: [(plot) => this.#drawZero(plot)],
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

  #drawZero(plot) {
    if (!this.#zoom || plot.scales.x.min > 0 || plot.scales.x.max < 0) return;
    const x = Math.round(plot.valToPos(0, "x", true)) + 0.5;
    plot.ctx.save();
    plot.ctx.strokeStyle = css("--warn");
    plot.ctx.setLineDash([4, 4]);
    plot.ctx.beginPath();
    plot.ctx.moveTo(x, plot.bbox.top);
    plot.ctx.lineTo(x, plot.bbox.top + plot.bbox.height);
    plot.ctx.stroke();
    plot.ctx.restore();
  }

  // How many stretches of time the plots can tell apart: the lines are nearly two pixels wide.
  get resolution() {
    return Math.max(100, ((this.#panes[0]?.plotElement.clientWidth ?? 600) - 60) / 2);
  }

  // columns in the order of the signals.
  draw(x, columns, xRange) {
    this.#xRange = xRange;
    for (const pane of this.#panes) {
      const chosen = pane.places.map((place) => columns[place]);
      pane.limits.follow(...extent(chosen), LEAST[pane.unit] ?? 0);
      pane.fit.plot.setData([x, ...chosen]);
    }
  }

  // Figures beside the names: at the cursor if there is one, else from `value(place)`.
  figures(value) {
    for (const pane of this.#panes) {
      const at = pane.fit.plot.cursor.idx;
      pane.places.forEach((place, i) => {
        const shown = at !== null && at !== undefined && pane.fit.plot.cursor.left >= 0
          ? pane.fit.plot.data[i + 1][at] : value(place);
        pane.figures[i].textContent = number(shown ?? NaN);
      });
    }
  }

  // Where the cursor is, as text, or "".
  cursorText(unit) {
    for (const { fit } of this.#panes) {
      const { idx, left } = fit.plot.cursor;
      if (idx !== null && idx !== undefined && left >= 0) return withUnit(number(fit.plot.data[0][idx]), unit);
    }
    return "";
  }
}
