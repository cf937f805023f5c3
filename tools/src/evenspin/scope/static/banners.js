// What must not be missed, above everything: the fault with its advice, a lost connection, who may do what.

import { $, h } from "./dom.js";

export class Banners {
  #shown = "";

  constructor(scope) {
    this.scope = scope;
    for (const topic of ["state", "status", "role", "drive"]) scope.on(topic, () => this.show());
  }

  show() {
    const found = this.#all();
    const key = JSON.stringify(found.map(({ key: name }) => name));
    if (key === this.#shown) return; // a button that is being pressed must not be replaced
    this.#shown = key;
    $("banners").replaceChildren(...found.map(({ element }) => element()));
  }

  #all() {
    const { link, state, drive, role, pages, free, connected, refused } = this.scope;
    const found = [];
    const add = (name, bad, title, text, ...buttons) => found.push({
      key: [name, title, text, this.scope.mayWrite],
      element: () => h("div", { class: bad ? "banner bad" : "banner", "data-banner": name }, h("h2", {}, title), h("p", {}, text), ...buttons),
    });
    if (refused) {
      add("server", true, "The scope was started again", "Its address is a new one: open the one that `evenspin scope` printed. The motor was stopped when the scope ended.");
      return found;
    }
    if (!connected) {
      add("server", true, "No connection to the scope", "Is `evenspin scope` still running? When it ends, it stops the motor. The page tries again.");
      return found;
    }
    if (link.status !== "connected") {
      add("link", true, "No drive", link.text);
    }
    if (state?.fault) {
      const { name, cause, check, text } = state.fault;
      add("fault", true, `Fault: ${name}`, cause ? `${cause} Check first: ${check}` : text,
        h("button", { id: "last-samples", onclick: () => this.scope.lastSamples() }, "Show last samples"),
        h("button", { id: "clear-fault", class: "primary", disabled: !this.scope.inControl, onclick: () => this.scope.clearFault() }, "Clear fault"));
    }
    if (drive?.read_only) add("read-only", false, "Read only", `This drive can be watched and stopped, not changed: ${drive.read_only}.`);
    if (role === "watch") {
      const open = pages === 1 ? "This is the only open page" : `${pages} pages are open`;
      add("watch", false, free ? "Nobody is in control" : "Watching",
        free ? `The page that was in control has gone, and the motor was stopped. ${open}.` : `Another page is in control; ${open}. Stop works here, too.`,
        h("button", { id: "take-control", onclick: () => this.scope.ask("take_control").catch(() => {}) }, "Take control"));
    }
    return found;
  }
}
