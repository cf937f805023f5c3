// Elements without a framework: h("button", {class: "primary", onclick}, "Start").

import { openInPage } from "./choice.js";
import { parseNumber } from "./format.js";

export function h(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (name in element && typeof value !== "string") element[name] = value;
    else element.setAttribute(name, value);
  }
  element.append(...children.filter((child) => child !== null && child !== undefined));
  return element;
}

export const $ = (id) => document.getElementById(id);

export function select(words, chosen, onchange, attributes = {}) {
  const element = h("select", { onchange: () => onchange(element.value), ...attributes });
  fill(element, words, chosen);
  openInPage(element);
  return element;
}

// words: strings, or [value, text]. Keeps the choice when it is still there.
export function fill(element, words, chosen = element.value) {
  const pairs = words.map((word) => (Array.isArray(word) ? word : [word, word]));
  element.replaceChildren(...pairs.map(([value, text]) => h("option", { value }, text)));
  element.value = pairs.some(([value]) => value === chosen) ? chosen : (pairs[0]?.[0] ?? "");
}

// A field for a number as people write it; null when it is none. `onenter` is called with Enter.
export function numberField(value, attributes = {}, onenter = () => {}) {
  const field = h("input", { class: "number", inputmode: "decimal", autocomplete: "off", value: String(value), ...attributes });
  field.addEventListener("keydown", (event) => {
    if (event.key !== "Enter" || event.shiftKey) return;
    field.blur(); // a digit that is typed next is no part of the number any more
    onenter();
  });
  return field;
}

export function numberOf(field) {
  const value = parseNumber(field.value);
  field.classList.toggle("refused", value === null);
  return value;
}

// Where keys are text. A closed list of choices is none: its keys are shortcuts, as everywhere.
export const isTyping = (element) => element.matches?.("input:not([type=checkbox]), textarea, select[size]") ?? false;
