// Keyboard. Stop first, and before anybody else sees the key.

import { $, h, isTyping } from "./dom.js";

const LIST = [
  ["Esc", "Stop: everywhere, also while typing"], ["Space", "Stop, outside of text fields"],
  ["A", "Arm, disarm"], ["Shift+Enter", "Start"], ["1 2 3 4", "Live, Capture, X-Y, Spectrum"], ["P", "Pause, continue the live plots"],
  ["+ −", "Shorter, longer window"], ["C", "Take a capture"], ["/", "Find a parameter"], ["G", "Signals"], ["S", "Setpoint"],
  ["E", "Export CSV"], ["I", "Export picture"], ["D", "Dark, light"], ["?", "This list"],
];

export function bindKeys(stop, actions) {
  const dialog = $("keys");
  dialog.append(h("h2", {}, "Keyboard"), h("table", {}, ...LIST.map(([key, what]) => h("tr", {}, h("td", {}, h("kbd", {}, key)), h("td", {}, what)))),
    h("button", { class: "primary", onclick: () => dialog.close() }, "Close"));
  // Not modal: nothing may lie over the stop button.
  const show = () => dialog.show();
  $("help").onclick = show;
  addEventListener("keydown", (event) => {
    const typing = isTyping(event.target);
    if (event.key === "Escape" || (event.key === " " && !typing)) {
      event.preventDefault();
      event.stopImmediatePropagation();
      if (!event.repeat) stop();
      if (event.key === "Escape") dialog.close();
      return;
    }
    if (event.ctrlKey || event.metaKey || event.altKey || event.repeat) return;
    if (event.shiftKey && event.key === "Enter") {
      event.preventDefault();
      actions.start();
    } else if (!typing && event.key === "?") {
      show();
    } else if (!typing && actions[event.key.toLowerCase()]) {
      event.preventDefault();
      actions[event.key.toLowerCase()]();
    }
  }, { capture: true });
}
