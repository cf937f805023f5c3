// Questions before what reaches far. Not modal: nothing may lie over the stop button, and no key may be kept from it.

import { $, h } from "./dom.js";

// Resolves to true when `action` is pressed. A second question takes the place of the first.
export function askFirst(title, lines, action) {
  const dialog = $("ask");
  dialog.close();
  return new Promise((resolve) => {
    const answer = (yes) => () => {
      resolve(yes);
      dialog.close();
    };
    const cancel = h("button", { id: "ask-cancel", onclick: answer(false) }, "Cancel");
    dialog.replaceChildren(h("h2", {}, title), ...lines.map((line) => h("p", {}, line)),
      h("div", { class: "actions" }, cancel, h("button", { id: "ask-do", class: "primary", onclick: answer(true) }, action)));
    dialog.onclose = () => resolve(false);
    dialog.show();
    cancel.focus();
  });
}
