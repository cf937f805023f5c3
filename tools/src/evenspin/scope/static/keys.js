// Keyboard. Stop first, and before anybody else sees the key.

import { $, h, isTyping } from "./dom.js";

const LIST = [
  ["Space, Esc", "Stop: everywhere, also while typing"],
  ["A", "Arm, disarm"], ["Shift+Enter", "Start"], ["1 2 3 4 5", "Live, Capture, X-Y, Spectrum, Bode"], ["P", "Pause, continue the live plots"],
  ["+ −", "Shorter, longer window"], ["C", "Take a capture"], ["/", "Find a parameter"], ["G", "Signals"], ["S", "Setpoint"],
  ["O", "Record what is streamed; end the recording"], ["U", "Tools: recording, parameters as a file, calibrations"], ["L", "Layouts: signals, views and cursors by name"], ["K", "Keep what is shown, to compare with"], ["T, R", "Trigger of the live trace: off, auto, normal, single; again"], ["X", "Two cursors and their difference; drag them, or ← → (with Shift in larger steps)"], ["E", "Export CSV"], ["I", "Export picture"], ["D", "Dark, light"], ["?", "This list"],
];

const isStop = (event) => event.key === "Escape" || event.key === " " || event.code === "Space";

export function bindKeys(stop, actions) {
  const dialog = $("keys");
  dialog.append(h("h2", {}, "Keyboard"), h("table", {}, ...LIST.map(([key, what]) => h("tr", {}, h("td", {}, h("kbd", {}, key)), h("td", {}, what)))),
    h("button", { class: "primary", onclick: () => dialog.close() }, "Close"));
  // Not modal: nothing may lie over the stop button.
  const show = () => dialog.show();
  $("help").onclick = show;
  addEventListener("keydown", (event) => {
    const { target, key } = event;
    if (isStop(event)) {
      event.preventDefault();
      event.stopImmediatePropagation();
      if (!event.repeat) stop();
      for (const open of document.querySelectorAll("dialog[open]")) open.close();
      if (isTyping(target)) target.blur(); // what comes next is for the motor, not for the field
      return;
    }
    if (event.ctrlKey || event.metaKey || event.altKey || event.repeat) return;
    const typing = isTyping(target);
    if (event.shiftKey && key === "Enter") {
      event.preventDefault();
      if (typing) target.blur();
      actions.start();
    } else if (key === "Enter" && target.type === "checkbox") {
      target.click(); // the space bar is taken
    } else if (!typing && key === "?") {
      show();
    } else if (!typing && actions[key.toLowerCase()]) {
      event.preventDefault();
      actions[key.toLowerCase()]();
    }
  }, { capture: true });
  // Browsers press a button when the space bar comes up again.
  addEventListener("keyup", (event) => { if (isStop(event)) event.preventDefault(); }, { capture: true });
}
