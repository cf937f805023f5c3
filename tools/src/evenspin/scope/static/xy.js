// One signal over another: the current vector, ripple over the angle of the rotor.

import { $, fill, h, select } from "./dom.js";
import { withUnit } from "./format.js";
import { axis, extent, fitted, nice, signalColour } from "./plot.js";

const ANGLE = "theta_m_rad";
const ELECTRICAL = "electrical angle";
const POINTS = 20000;

export class XyView {
  #fit = null;
  #drawn = -1;

  constructor(scope) {
    this.scope = scope;
    this.element = $("view-xy");
    this.x = select([], "", () => this.rebuild(), { id: "xy-x" });
    this.y = select([], "", () => this.rebuild(), { id: "xy-y" });
    this.source = select([["live", "live"], ["capture", "capture"]], "live", () => this.#choices());
    this.seconds = select([["0.2", "0.2 s"], ["0.5", "0.5 s"], ["1", "1 s"], ["2", "2 s"], ["5", "5 s"], ["10", "10 s"]], "2", () => (this.#drawn = -1));
    this.ripple = h("input", { type: "checkbox", onchange: () => this.rebuild() });
    this.square = h("input", { type: "checkbox", onchange: () => this.rebuild() });
    this.body = h("div", { class: "plot" });
    this.empty = h("div", { class: "empty" });
    this.element.append(
      h("div", { class: "bar" },
        h("button", { onclick: () => this.preset("id_a", "iq_a", false, true) }, "id / iq"),
        h("button", { id: "xy-ripple", onclick: () => this.preset(ANGLE, "speed_rad_s", true, false) }, "Speed ripple / angle"),
        h("label", {}, "X", this.x), h("label", {}, "Y", this.y), h("label", {}, "from", this.source),
        h("label", {}, "last", this.seconds), h("label", {}, this.ripple, "less the mean"), h("label", {}, this.square, "same scale")),
      this.empty, this.body);
    scope.on("layout", () => this.#choices());
    scope.on("theme", () => this.rebuild());
    scope.on("record", () => this.source.value === "capture" && this.#choices());
  }

  #rows() {
    const { ring, capture } = this.scope;
    if (this.source.value === "capture") return capture.record;
    const { t, columns } = ring.window(ring.lastTime - Number(this.seconds.value), ring.lastTime, POINTS);
    return { names: ring.names, units: this.scope.layout?.units ?? [], t, columns };
  }

  #choices() {
    const names = (this.source.value === "capture" ? this.scope.capture.record?.names : this.scope.names) ?? [];
    fill(this.x, names.includes(ANGLE) ? [...names, ELECTRICAL] : names, this.x.value || "id_a");
    fill(this.y, names, this.y.value || "iq_a");
    this.rebuild();
  }

  async preset(x, y, ripple, square) {
    const missing = [x, y].filter((name) => !this.scope.names.includes(name));
    this.source.value = "live";
    if (missing.length) await this.scope.watch([...this.scope.names, ...missing].slice(-this.scope.drive.stream_signals));
    this.ripple.checked = ripple;
    this.square.checked = square;
    this.#choices();
    this.x.value = x;
    this.y.value = y;
    this.rebuild();
  }

  get state() {
    const { x, y, source, seconds, ripple, square } = this;
    return { x: x.value, y: y.value, source: source.value, seconds: Number(seconds.value), ripple: ripple.checked, square: square.checked };
  }

  set state({ x, y, source, seconds, ripple, square }) {
    this.source.value = source;
    this.seconds.value = String(seconds);
    this.ripple.checked = ripple;
    this.square.checked = square;
    this.#choices();
    this.x.value = x;
    this.y.value = y;
    this.rebuild();
  }

  rebuild() {
    this.#fit?.destroy();
    this.#fit = null;
    this.#drawn = -1;
    if (this.element.hidden) return;
    const units = Object.fromEntries((this.scope.drive?.signals ?? []).map(({ name, unit }) => [name, unit]));
    const label = (name) => (name === ELECTRICAL ? "electrical angle / rad" : [name, units[name]].filter(Boolean).join(" / "));
    this.ranges = { x: [0, 1], y: [0, 1] };
    const ripple = this.ripple.checked ? " less its mean" : "";
    this.#fit = fitted(this.body, {
      padding: [12, 14, 0, 0], mode: 2, cursor: { drag: { x: false, y: false }, points: { show: false } },
      scales: { x: { time: false, range: () => this.ranges.x }, y: { range: () => this.ranges.y } },
      axes: [axis(label(this.x.value), { size: 34, space: 80 }), axis(label(this.y.value).replace(" /", `${ripple} /`), { size: 64 })],
      series: [null, { stroke: signalColour(0), paths: dots, facets: [{ scale: "x", auto: true }, { scale: "y", auto: true }] }],
    }, [null, [[], []]]);
  }

  draw() {
    const key = this.source.value === "capture" ? this.scope.capture.record?.id ?? -2 : this.scope.ring.written;
    if (this.#drawn === key) return;
    if (!this.#fit) this.rebuild();
    this.#drawn = key;
    const rows = this.#rows();
    const [xs, ys] = rows ? this.#columns(rows) : [null, null];
    const enough = xs?.length > 2 && ys?.length > 2;
    this.empty.hidden = enough;
    this.body.hidden = !enough;
    if (!enough) {
      this.empty.replaceChildren(h("b", {}, "Nothing to show yet"), "Choose two signals that are streamed, or take a capture first.");
      return;
    }
    let x = nice(...padded(extent([xs])), 1e-6), y = nice(...padded(extent([ys])), 1e-6);
    if (this.x.value === ANGLE || this.x.value === ELECTRICAL) x = [0, 2 * Math.PI];
    if (this.square.checked) [x, y] = this.#sameScale(x, y);
    this.ranges = { x, y };
    this.#fit.plot.setData([null, [xs, ys]]);
  }

  #columns({ names, columns }) {
    const theta = columns[names.indexOf(ANGLE)];
    const pairs = this.scope.values.pole_pairs ?? 1;
    const xs = this.x.value === ELECTRICAL && theta
      ? Array.from(theta, (angle) => (angle * pairs) % (2 * Math.PI)) : columns[names.indexOf(this.x.value)];
    let ys = columns[names.indexOf(this.y.value)];
    if (!xs || !ys) return [null, null];
    if (this.ripple.checked) {
      const finite = Array.from(ys).filter((value) => value !== null);
      const mean = finite.reduce((sum, value) => sum + value, 0) / Math.max(1, finite.length);
      ys = Array.from(ys, (value) => (value === null ? null : value - mean));
    }
    return [xs, ys];
  }

  // As many units per pixel in both directions: a circle is a circle.
  #sameScale(x, y) {
    const { width, height } = this.#fit.plot.bbox;
    const perPixel = Math.max((x[1] - x[0]) / width, (y[1] - y[0]) / height);
    const around = ([low, high], pixels) => [(low + high - perPixel * pixels) / 2, (low + high + perPixel * pixels) / 2];
    return [around(x, width), around(y, height)];
  }
}

const padded = ([low, high]) => [low - 0.04 * (high - low), high + 0.04 * (high - low)];

// Old points are pale, new ones bright; a path would join the end of a turn with its beginning.
function dots(plot) {
  uPlot.orient(plot, 1, (series, xs, ys, scaleX, scaleY, toX, toY, left, top, width, height) => {
    const { ctx } = plot;
    ctx.save();
    ctx.fillStyle = series.stroke();
    const size = 2 * devicePixelRatio;
    for (let i = 0; i < xs.length; i++) {
      if (xs[i] === null || ys[i] === null) continue;
      if (i % 64 === 0) ctx.globalAlpha = 0.25 + (0.75 * i) / xs.length;
      ctx.fillRect(toX(xs[i], scaleX, width, left) - size / 2, toY(ys[i], scaleY, height, top) - size / 2, size, size);
    }
    ctx.restore();
  });
  return null;
}
