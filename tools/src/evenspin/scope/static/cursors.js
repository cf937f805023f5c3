// Two cursors, A and B, over the plots of a view, and what lies between them in figures. A cursor is a handle that is dragged,
// or moved with the arrow keys; it stands at its place on the axis while the trace moves beneath it.

import { h } from "./dom.js";
import { number } from "./format.js";

const NAMES = ["A", "B"];
const SNAP_PX = 5;
const ROWS = ["A", "B", "B − A"];
const FIRST = [1 / 3, 2 / 3]; // of what is shown

// Index of the point next to x; xs rise.
export function nearest(xs, x) {
  let low = 0, high = xs.length - 1;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (xs[middle] < x) low = middle + 1;
    else high = middle;
  }
  return low > 0 && x - xs[low - 1] < xs[low] - x ? low - 1 : low;
}

export class Cursors {
  on = false;
  at = [NaN, NaN];
  #plots = [];
  #heads = "";

  // `measure(dx)`: lines of text about the distance; `axis()`: {name, unit} of what the cursors stand on.
  // `snap(x, reach)`: where a cursor comes to rest that is dragged to x.
  constructor({ axis, measure, changed = () => {}, snap = (x) => x }) {
    this.snap = snap;
    this.axis = axis;
    this.measure = measure;
    this.changed = changed;
    this.button = h("button", { title: "X: two cursors and their difference", "data-cursors": "", "aria-pressed": "false", onclick: () => this.toggle() }, "Cursors");
    this.cells = [];
    this.text = h("p", { class: "between", role: "status" });
    this.table = h("table", { class: "lines" });
    this.element = h("div", { class: "strip cursors", hidden: true }, this.text, this.table);
  }

  toggle(on = !this.on) {
    this.on = on;
    this.button.classList.toggle("on", on);
    this.button.setAttribute("aria-pressed", on);
    this.element.hidden = !on;
    if (on) this.#intoView();
    this.place();
    this.changed();
  }

  get state() {
    return { on: this.on, at: this.at.map((x) => (Number.isFinite(x) ? x : null)) };
  }

  set state({ on, at }) {
    this.at = at.map((x) => x ?? NaN);
    this.toggle(on);
  }

  // Where none can be seen, as after a zoom, they come to where they can.
  #intoView() {
    const { min, max } = this.#plots[0]?.plot.scales.x ?? {};
    if (!(max > min)) return;
    this.at = this.at.map((x, i) => (x >= min && x <= max ? x : min + FIRST[i] * (max - min)));
  }

  // After a plot was made; what is attached with `forget` first is all there is.
  forget() {
    this.#plots = [];
  }

  attach(plot) {
    const handles = NAMES.map((name, i) => {
      const handle = h("div", { class: "cursor", tabindex: "0", role: "slider", "aria-label": `cursor ${name}`, "data-cursor": name }, h("b", {}, name));
      handle.addEventListener("pointerdown", (event) => this.#drag(event, handle, plot, i));
      handle.addEventListener("mousedown", (event) => event.stopPropagation()); // no zoom begins here
      handle.addEventListener("dblclick", (event) => event.stopPropagation());
      handle.addEventListener("keydown", (event) => this.#step(event, plot, i));
      return handle;
    });
    plot.over.append(...handles);
    this.#plots.push({ plot, handles, left: ["", ""] });
    this.place();
  }

  #drag(event, handle, plot, i) {
    event.preventDefault();
    handle.focus({ preventScroll: true });
    handle.setPointerCapture(event.pointerId);
    const move = ({ clientX }) => {
      const { left, width } = plot.over.getBoundingClientRect();
      this.#move(plot, i, (clientX - left) / width, this.snap);
    };
    const end = () => {
      handle.removeEventListener("pointermove", move);
      handle.removeEventListener("lostpointercapture", end);
    };
    handle.addEventListener("pointermove", move);
    handle.addEventListener("lostpointercapture", end);
  }

  #step(event, plot, i) {
    const direction = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (!direction) return;
    event.preventDefault();
    const { min, max } = plot.scales.x;
    const pixels = event.shiftKey ? 20 : 1;
    this.#move(plot, i, (this.at[i] - min) / (max - min) + (direction * pixels) / plot.over.clientWidth);
  }

  #move(plot, i, part, snap = (x) => x) {
    const { min, max } = plot.scales.x;
    const reach = (SNAP_PX * (max - min)) / plot.over.clientWidth;
    this.at[i] = snap(min + Math.min(1, Math.max(0, part)) * (max - min), reach);
    this.place();
    this.changed();
  }

  // Cheap: nothing is touched that is where it belongs.
  place() {
    for (const each of this.#plots) {
      const { min, max } = each.plot.scales.x;
      if (this.on && !this.at.some(Number.isFinite) && max > min) this.#intoView();
      each.handles.forEach((handle, i) => {
        const part = (this.at[i] - min) / (max - min);
        const left = this.on && part >= 0 && part <= 1 ? `${(100 * part).toFixed(3)}%` : "";
        if (left === each.left[i]) return;
        each.left[i] = left;
        handle.style.left = left;
        handle.classList.toggle("shown", left !== "");
      });
    }
  }

  // columns: [{name, unit, at: (x) => value}]
  show(columns) {
    if (!this.on || !this.at.every(Number.isFinite)) return;
    const { name, unit } = this.axis();
    this.#rebuild([{ name, unit }, ...columns]);
    const values = [(x) => x, ...columns.map(({ at }) => at)].map((at) => this.at.map(at));
    values.forEach(([a, b], column) => {
      [a, b, b - a].forEach((value, row) => (this.cells[row][column].textContent = number(value, 5)));
    });
    this.text.replaceChildren(...this.measure(this.at[1] - this.at[0]).flatMap(([word, value]) => [`${word} = `, h("b", {}, value), "  "]));
  }

  #rebuild(heads) {
    const key = heads.map(({ name, unit }) => `${name} ${unit}`).join();
    if (key === this.#heads) return;
    this.#heads = key;
    this.cells = ROWS.map(() => heads.map(() => h("td")));
    this.table.replaceChildren(
      h("tr", {}, h("th"), ...heads.map(({ name, unit }) => h("th", {}, name, h("small", {}, unit)))),
      ...ROWS.map((word, row) => h("tr", {}, h("th", {}, word), ...this.cells[row])));
  }
}
