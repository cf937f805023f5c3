// Which signals are streamed, with what they are. One choice for all pages and views.

import { $, h } from "./dom.js";
import { signalColour } from "./plot.js";

export class Signals {
  constructor(scope) {
    this.scope = scope;
    this.search = h("input", { type: "search", placeholder: "find a signal", "aria-label": "find a signal", oninput: () => this.show() });
    this.said = h("div", { class: "said" });
    this.list = h("div", { class: "list" });
    $("side-signals").append(h("div", { class: "bar" }, this.search, this.said), this.list);
    for (const topic of ["drive", "layout", "role", "theme"]) scope.on(topic, () => this.show());
  }

  show() {
    const { drive, names } = this.scope;
    if (!drive) {
      this.list.replaceChildren(h("div", { class: "empty" }, "The signals are listed when a drive is connected."));
      return;
    }
    const word = this.search.value.trim().toLowerCase();
    const full = names.length >= drive.stream_signals;
    this.say(`${names.length} of at most ${drive.stream_signals}`);
    const found = drive.signals.filter(({ name, doc }) => `${name} ${doc}`.toLowerCase().includes(word));
    this.list.replaceChildren(...found.map(({ name, unit, doc }) => {
      const on = names.includes(name);
      const off = !this.scope.inControl || (full && !on);
      const box = h("input", { type: "checkbox", checked: on, disabled: off, onchange: () => this.#toggle(name) });
      const code = h("code", {}, name);
      if (on) code.style.color = signalColour(names.indexOf(name));
      return h("label", { class: off ? "signal off" : "signal" }, box, code, h("span", { class: "note" }, unit || "–"), h("p", {}, doc));
    }));
    if (!found.length) this.list.replaceChildren(h("div", { class: "empty" }, `No signal has “${this.search.value}” in it.`));
  }

  async #toggle(name) {
    const { names } = this.scope;
    const next = names.includes(name) ? names.filter((other) => other !== name) : [...names, name];
    if (!next.length) {
      this.show();
      this.say("At least one signal stays.", true);
      return;
    }
    try {
      await this.scope.watch(next);
    } catch (error) {
      this.show();
      this.say(error.message, true);
    }
  }

  say(text, bad = false) {
    this.said.textContent = text;
    this.said.classList.toggle("bad", bad);
  }
}
