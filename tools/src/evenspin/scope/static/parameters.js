// Every parameter with unit, limits and what it is; Enter hands it to the drive, which takes it over or says why not.

import { askFirst } from "./ask.js";
import { $, h, numberField, numberOf, select } from "./dom.js";
import { exact } from "./format.js";

const LISTED = 8; // changes named in a question

export class Parameters {
  #rows = new Map();

  constructor(scope) {
    this.scope = scope;
    this.search = h("input", { type: "search", id: "find-parameter", placeholder: "find a parameter", "aria-label": "find a parameter", oninput: () => this.filter() });
    this.changed = h("input", { type: "checkbox", onchange: () => this.filter() });
    this.said = h("div", { class: "said", role: "status" });
    this.list = h("div", { class: "list" });
    const command = (what, text, title) => h("button", { title, "data-command": what, onclick: () => this.#command(what, text) }, text);
    this.buttons = [
      command("save", "Save", "Keep them over a power cycle"), command("restore", "Restore", "Take the saved ones"),
      command("defaults", "Defaults", "Take those of the firmware; not saved"), command("read_values", "Read", "Read all again"),
    ];
    this.undo = command("undo", "Undo", "Take the values of before");
    this.buttons.push(this.undo);
    $("side-parameters").append(
      h("div", { class: "bar" }, this.search, h("label", { title: "other than the default of the firmware" }, this.changed, "changed •")),
      this.list, h("div", { class: "bar strip" }, ...this.buttons, this.said));
    scope.on("drive", () => this.build());
    scope.on("values", () => this.fill());
    scope.on("role", () => this.#allow());
    this.list.append(h("div", { class: "empty" }, "The parameters are listed when a drive is connected."));
  }

  build() {
    this.#rows.clear();
    const children = this.scope.drive.parameters.map((field) => this.#row(field));
    this.list.replaceChildren(...children);
    this.fill();
    this.#allow();
  }

  #showUndo() {
    const { undo } = this.scope;
    this.undo.hidden = !undo;
    if (undo) this.undo.textContent = `Undo ${undo.what} (${undo.count})`;
  }

  #row(field) {
    const { name, unit, kind, doc, choices } = field;
    const apply = () => this.#apply(field);
    let input;
    if (kind === "choice") input = select(choices.map((word, i) => [String(i), word]), "", apply);
    else if (kind === "flag") input = select([["0", "off"], ["1", "on"]], "", apply);
    else input = numberField("", {}, apply);
    input.dataset.parameter = name;
    input.setAttribute("aria-label", name);
    const refusal = h("p", { class: "refusal", role: "alert" });
    const range = kind === "float" || kind === "integer" ? [`${exact(field.minimum)} … ${exact(field.maximum)}`, unit].filter(Boolean).join(" ") : "";
    const preset = `default ${choices[field.default] ?? (kind === "flag" ? (field.default ? "on" : "off") : exact(field.default))}`;
    const limits = h("p", { class: "limits" }, [range, preset, field.at_rest ? "changes at rest only" : ""].filter(Boolean).join(" · "));
    const text = h("p", {}, doc);
    const words = name.split("_").flatMap((word, i) => (i ? ["_", h("wbr"), word] : [word]));
    const element = h("div", { class: "parameter" }, h("code", {}, ...words), input, limits, text, refusal);
    input.addEventListener("input", () => input.classList.toggle("edited", Number(input.value) !== Number(exact(this.scope.values[name]))));
    if (!doc) input.addEventListener("focus", () => this.#document(name, text), { once: true });
    this.#rows.set(name, { field, input, element, refusal });
    return element;
  }

  // A drive of other firmware: its lists came from the drive, its words are fetched when somebody looks.
  async #document(name, text) {
    try {
      text.textContent = (await this.scope.ask("document", { name })).text;
    } catch {
      // the limits stay
    }
  }

  fill() {
    this.#showUndo();
    for (const [name, row] of this.#rows) {
      const { field, input, element, refusal } = row;
      const value = this.scope.values[name];
      if (value === undefined) continue;
      // What somebody is typing stays, and what was refused, with its reason: until the drive holds another value.
      const kept = input.classList.contains("edited") && (document.activeElement === input || input.classList.contains("refused"));
      if (!kept || value !== row.held) {
        input.value = exact(value);
        input.classList.remove("edited", "refused");
        refusal.textContent = "";
      }
      row.held = value;
      element.classList.toggle("changed", Math.fround(field.default) !== Math.fround(value));
    }
    this.filter();
  }

  filter() {
    const word = this.search.value.trim().toLowerCase();
    for (const { field, element } of this.#rows.values()) {
      const found = `${field.name} ${field.doc} ${field.unit}`.toLowerCase().includes(word);
      element.hidden = !found || (this.changed.checked && !element.classList.contains("changed"));
    }
  }

  #allow() {
    for (const { input } of this.#rows.values()) input.disabled = !this.scope.mayWrite;
    for (const button of this.buttons) button.disabled = !this.scope.mayWrite && button.dataset.command !== "read_values";
  }

  async #apply({ name }) {
    const { input, refusal } = this.#rows.get(name);
    refusal.textContent = "";
    const value = numberOf(input);
    if (value === null) {
      refusal.textContent = "This is not a number.";
      return;
    }
    try {
      await this.scope.ask("set", { values: { [name]: value } });
      input.classList.remove("edited", "refused");
      input.value = exact(this.scope.values[name]);
    } catch (error) {
      input.classList.add("refused");
      refusal.textContent = error.message;
    }
  }

  // What would change, as far as it is known before.
  #question(what) {
    const { drive, values } = this.scope;
    if (!["defaults", "restore", "save"].includes(what)) return null;
    const differing = drive.parameters.filter(({ name, default: preset }) => Math.fround(preset) !== Math.fround(values[name]));
    const listed = differing.slice(0, LISTED).map(({ name, default: preset }) => `${name}: ${exact(values[name])}, default ${exact(preset)}`);
    const more = differing.length > LISTED ? [`and ${differing.length - LISTED} more`] : [];
    return {
      defaults: [`Take the defaults of all ${drive.parameters.length} parameters?`,
        [`${differing.length} differ from the defaults of the list. Undo brings back what changes.`, ...listed, ...more], "Take defaults"],
      restore: ["Take the saved parameters?", ["All parameters change to what was saved last. Undo brings back what is in force now."], "Take the saved ones"],
      save: ["Save the parameters?", ["What was saved before is replaced, for good."], "Save"],
    }[what];
  }

  async #command(what, text) {
    const question = this.#question(what);
    if (question && !(await askFirst(...question))) return;
    try {
      await this.scope.ask(what);
      this.#say(`${text}: done`);
    } catch (error) {
      this.#say(error.message, true);
    }
  }

  #say(text, bad = false) {
    this.said.textContent = text;
    this.said.classList.toggle("bad", bad);
  }
}
