// Layouts by name: signals, window, views, trigger, cursors, panes. Kept in this browser, taken away and brought as a file.

import { askFirst } from "./ask.js";
import { $, h } from "./dom.js";
import { anyText, flag, list, oneOf, orNull, record, text, within } from "./shape.js";

const FORMAT = "evenspin scope layouts";
const PLACE = "layouts"; // in the storage of the browser
const MOST = 100;
const FILE_OCTETS = 1 << 20;

const LARGE = 1e9;
const cursors = record({ on: flag, at: list(orNull(within(-LARGE, LARGE)), 2, 2) });
const panes = record({ order: list(anyText, 0, 32), folded: list(anyText, 0, 32) });
const edge = oneOf("rising", "falling", "either");
const source = oneOf("live", "capture");
const LAYOUT = record({
  signals: list(text, 1, 32), rate_hz: within(1, 1e5), view: oneOf("live", "capture", "xy", "spectrum"),
  live: record({
    seconds: oneOf(1, 2, 5, 10, 30, 60, 120), cursors, panes,
    trigger: record({ mode: oneOf("off", "auto", "normal", "single"), signal: anyText, edge, level: within(-LARGE, LARGE) }),
  }),
  capture: record({
    signals: list(text, 0, 32), trigger: oneOf("rising", "falling", "either", "immediate", "manual", "fault"), signal: anyText,
    level: within(-LARGE, LARGE), rows: within(2, 65535), before_pct: within(0, 95), every: oneOf(1, 2, 5, 10), repeat: flag, cursors, panes,
  }),
  xy: record({ x: anyText, y: anyText, source, seconds: oneOf(0.2, 0.5, 1, 2, 5, 10), ripple: flag, square: flag }),
  spectrum: record({
    signal: anyText, source, axis: oneOf("electrical", "mechanical", "hz"), seconds: oneOf(1, 2, 5, 10, 30), max_order: within(1, 500), log: flag, cursors,
  }),
});

// The layouts of a file, by name; throws one line when it is none.
export function readLayouts(octets) {
  if (octets.length > FILE_OCTETS) throw new Error("the file is larger than 1 MB: it is no file of layouts");
  let content;
  try {
    content = JSON.parse(octets);
  } catch {
    throw new Error("the file is no JSON; a file of layouts is what Export writes");
  }
  record({ format: oneOf(FORMAT), version: oneOf(1), layouts: (value, place) => record({})(typeof value === "object" && value !== null && !Array.isArray(value) ? {} : value, place) })(content, "file");
  const names = Object.keys(content.layouts);
  if (names.length > MOST) throw new Error(`file.layouts: has ${names.length} layouts; at most ${MOST}`);
  for (const name of names) {
    text(name, "name of a layout");
    LAYOUT(content.layouts[name], name);
  }
  return content.layouts;
}

export const unknownSignals = (layout, drive) => [...new Set([...layout.signals, ...layout.capture.signals])].filter((name) => !drive.signals.some((signal) => signal.name === name));

export class Layouts {
  // `now()`: the layout in force; `apply(layout)`: take one over.
  constructor(scope, now, apply) {
    Object.assign(this, { scope, now, apply });
    this.dialog = $("layouts");
    this.name = h("input", { id: "layout-name", placeholder: "name, without blanks", "aria-label": "name of the layout", maxlength: "100", autocomplete: "off" });
    this.name.addEventListener("keydown", (event) => event.key === "Enter" && !event.shiftKey && (this.name.blur(), this.save()));
    this.list = h("table", { class: "saved" });
    this.said = h("p", { class: "said", role: "status", id: "layouts-said" });
    this.file = h("input", { type: "file", id: "layouts-file", accept: ".json", onchange: () => this.#import() });
    this.dialog.append(
      h("h2", {}, "Layouts"), h("p", { class: "bar" }, this.name, h("button", { id: "layout-save", class: "primary", onclick: () => this.save() }, "Save this one")),
      this.list, this.said,
      h("div", { class: "bar" }, h("button", { id: "layouts-export", onclick: () => this.#export() }, "Export"), h("label", {}, "Import", this.file),
        h("button", { id: "layouts-close", onclick: () => this.dialog.close() }, "Close")));
  }

  show() {
    this.dialog.show();
    this.#list();
    this.#say("Kept in this browser; Export writes them into a file.");
    this.name.focus();
  }

  get #saved() {
    try {
      return readLayouts(localStorage.getItem(PLACE) ?? "");
    } catch {
      return {};
    }
  }

  set #saved(layouts) {
    localStorage.setItem(PLACE, JSON.stringify({ format: FORMAT, version: 1, layouts }));
    this.#list();
  }

  #list() {
    const rows = Object.entries(this.#saved).map(([name, layout]) => h("tr", { "data-layout": name },
      h("td", {}, h("b", {}, name)), h("td", { class: "note" }, `${layout.signals.length} signals, ${layout.view}`),
      h("td", {}, h("button", { class: "small", "data-load": "", onclick: () => this.load(name) }, "Load")),
      h("td", {}, h("button", { class: "small", "data-delete": "", onclick: () => this.#delete(name) }, "Delete"))));
    this.list.replaceChildren(...(rows.length ? rows : [h("tr", {}, h("td", { class: "note" }, "None is saved yet."))]));
  }

  async save() {
    const name = this.name.value.trim();
    const saved = this.#saved;
    if (!name) return this.#say("Type a name first.", true);
    if (!this.scope.names.length) return this.#say("There are no signals yet: wait for a drive.", true);
    if (Object.keys(saved).length >= MOST && !saved[name]) return this.#say(`There are ${MOST} layouts already: delete one first.`, true);
    if (saved[name] && !(await askFirst(`Replace the layout ${name}?`, ["What was saved under this name is gone."], "Replace"))) return null;
    this.#saved = { ...saved, [name]: this.now() };
    return this.#say(`Saved as ${name}.`);
  }

  async load(name) {
    const layout = this.#saved[name];
    const { drive } = this.scope;
    if (!drive) return this.#say("No drive is connected: its signals are needed.", true);
    const unknown = unknownSignals(layout, drive);
    if (unknown.length) return this.#say(`${name}: this drive has no signal ${unknown.join(", ")}`, true);
    try {
      await this.apply(layout);
    } catch (error) {
      return this.#say(`${name}: ${error.message}`, true);
    }
    return this.#say(`${name} is in force.`);
  }

  async #delete(name) {
    if (!(await askFirst(`Delete the layout ${name}?`, ["There is no undo; Export keeps a copy."], "Delete"))) return;
    const { [name]: _, ...rest } = this.#saved;
    this.#saved = rest;
    this.#say(`${name} is deleted.`);
  }

  #export() {
    const content = JSON.stringify({ format: FORMAT, version: 1, layouts: this.#saved }, null, 1);
    const url = URL.createObjectURL(new Blob([content], { type: "application/json" }));
    h("a", { href: url, download: "evenspin-layouts.json" }).click();
    setTimeout(() => URL.revokeObjectURL(url), 1000);
  }

  async #import() {
    const [file] = this.file.files;
    if (!file) return;
    try {
      if (file.size > FILE_OCTETS) throw new Error("the file is larger than 1 MB: it is no file of layouts");
      const brought = readLayouts(await file.text());
      const saved = this.#saved;
      const both = Object.keys(brought).filter((name) => saved[name]);
      if (both.length && !(await askFirst("Replace layouts?", [`Saved here, too: ${both.join(", ")}`], "Replace"))) return;
      this.#saved = { ...saved, ...brought };
      const { drive } = this.scope;
      const without = drive ? Object.entries(brought).map(([name, layout]) => [name, unknownSignals(layout, drive)]).filter(([, unknown]) => unknown.length) : [];
      const warning = without.map(([name, unknown]) => `${name} needs ${unknown.join(", ")}, which this drive does not have`).join("; ");
      this.#say([`Imported: ${Object.keys(brought).join(", ") || "none"}.`, warning].filter(Boolean).join(" "), Boolean(warning));
    } catch (error) {
      this.#say(`${file.name}: ${error.message}`, true);
    } finally {
      this.file.value = "";
    }
  }

  #say(what, bad = false) {
    this.said.textContent = what;
    this.said.classList.toggle("bad", bad);
  }
}
