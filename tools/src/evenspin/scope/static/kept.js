// What was kept to compare with: it is drawn faint beneath the present picture, and the change stands below in figures.

import { h } from "./dom.js";
import { number } from "./format.js";

const FAINT = 0.45;
const HANN = 1.5; // lines of a Hann window that the noise of one falls into
const SHOW_MS = 400;

// Mean, and rms about it; rows that were lost do not count.
export function spread(values) {
  let sum = 0, square = 0, count = 0;
  for (const value of values) {
    if (value === null || Number.isNaN(value)) continue;
    sum += value;
    square += value * value;
    count++;
  }
  const mean = sum / count;
  return { mean, rms: Math.sqrt(Math.max(0, square / count - mean * mean)) };
}

// Of what the lines of a spectrum stand for, without the mean.
export const rmsOfLines = (y) => Math.sqrt(y.slice(1).reduce((sum, value) => sum + value * value, 0) / 2 / HANN);

export const change = (before, now) => (before > 0 ? `${now > before ? "+" : ""}${number((100 * (now - before)) / before, 3)} %` : "–");

// Lines that are peaks, not the flanks of one, largest first.
export function peaks(y) {
  const found = [];
  for (let i = 1; i < y.length; i++) if (y[i] >= y[i - 1] && y[i] > (y[i + 1] ?? 0)) found.push(i);
  return found.sort((a, b) => y[b] - y[a]);
}

// [{x, before, now}]: the largest lines of both, the same line only once.
export function compareLines(before, now, most) {
  const reach = 1.5 * Math.max(before.x[1] - before.x[0], now.x[1] - now.x[0]);
  const largest = ({ x, y }, place) => y.reduce((best, value, i) => (Math.abs(x[i] - place) <= reach ? Math.max(best, value) : best), 0);
  const candidates = [before, now].flatMap(({ x, y }) => peaks(y).slice(0, most).map((i) => ({ x: x[i], y: y[i] }))).sort((a, b) => b.y - a.y);
  const chosen = [];
  for (const { x } of candidates) if (!chosen.some((other) => Math.abs(other.x - x) <= reach)) chosen.push({ x, before: largest(before, x), now: largest(now, x) });
  return chosen.slice(0, most).filter(({ before: a, now: b }) => Math.max(a, b) > 1e-3 * candidates[0].y);
}

// Beneath what uPlot draws next. `xs` rise; `toY` makes pixels of a value.
export function drawBeneath(plot, xs, ys, stroke, toY) {
  const { ctx, bbox } = plot;
  const { min, max } = plot.scales.x;
  const perX = bbox.width / (max - min);
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  ctx.beginPath();
  ctx.globalAlpha = FAINT;
  ctx.strokeStyle = stroke;
  ctx.lineWidth = 3 * devicePixelRatio;
  let down = false;
  for (let i = 0; i < xs.length; i++) {
    if (ys[i] === null || Number.isNaN(ys[i])) down = false;
    else {
      const x = bbox.left + (xs[i] - min) * perX, y = toY(ys[i]);
      if (down) ctx.lineTo(x, y);
      else ctx.moveTo(x, y);
      down = true;
    }
  }
  ctx.stroke();
  ctx.restore();
}

export class Kept {
  #shownAt = 0;
  #heads = "";

  // `take()`: what is shown now, or null; `changed()`: draw again.
  constructor(take, changed) {
    this.take = take;
    this.changed = changed;
    this.what = null;
    this.button = h("button", { title: "K: keep what is shown, to compare with", "data-keep": "", onclick: () => this.keep() }, "Keep");
    this.text = h("span");
    this.table = h("table", { class: "lines" });
    this.element = h("div", { class: "strip kept", hidden: true },
      h("p", { class: "between" }, this.text, " ", h("button", { class: "small", "data-forget": "", onclick: () => this.forget() }, "Forget")), this.table);
  }

  keep() {
    const what = this.take();
    if (!what) return;
    this.what = { ...what, title: `Kept at ${new Date().toTimeString().slice(0, 8)}` };
    this.#show();
  }

  forget() {
    this.what = null;
    this.#show();
  }

  #show() {
    this.element.hidden = !this.what;
    this.button.classList.toggle("on", Boolean(this.what));
    this.#shownAt = 0;
    this.changed();
  }

  due(now) {
    if (!this.what || now - this.#shownAt < SHOW_MS) return false;
    this.#shownAt = now;
    return true;
  }

  // columns: [{name, unit, before, now}], in figures; `about`: what the figures are.
  fill(about, columns) {
    this.text.textContent = `${this.what.title}: ${about}`;
    const key = columns.map(({ name, unit }) => `${name} ${unit}`).join();
    if (key !== this.#heads) {
      this.#heads = key;
      this.cells = ["kept", "now", "change"].map(() => columns.map(() => h("td")));
      this.table.replaceChildren(
        h("tr", {}, h("th"), ...columns.map(({ name, unit }) => h("th", {}, name, h("small", {}, unit)))),
        ...["kept", "now", "change"].map((word, row) => h("tr", {}, h("th", {}, word), ...this.cells[row])));
    }
    columns.forEach(({ before, now }, i) => {
      this.cells[0][i].textContent = number(before, 4);
      this.cells[1][i].textContent = number(now, 4);
      this.cells[2][i].textContent = change(before, now);
    });
  }
}
