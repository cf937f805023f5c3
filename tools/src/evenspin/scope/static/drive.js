// The hand on the drive: what to do, arm, start. Stop is in main.js, where nothing can be in its way.

import { $, h, numberField, numberOf } from "./dom.js";
import { RPM_PER_RAD_S, exact, parseNumber } from "./format.js";

const HINT = {
  none: "No drive is connected.",
  init: "The drive has not started up; arm and start.",
  offset_calibration: "Measuring the offsets of the current sensors; the motor must stand still.",
  align: "Aligning: the rotor moves to find the electrical zero.",
  ready: "Arm, then start. The motor will turn.",
  run: "Running. Enter takes over a new setpoint.",
  short: "Braking: the lower switches short the motor until it rests.",
  fault: "Switched off by a fault: read it above, then clear it.",
};

const WATCH_HINT = { ready: "At rest.", run: "Running.", init: "The drive has not started up.", fault: "Switched off by a fault." };

export class DrivePanel {
  constructor(scope) {
    this.scope = scope;
    this.mode = "speed";
    const enter = () => this.apply();
    this.speed = numberField(30, { id: "speed", "aria-label": "speed in rad/s" }, enter);
    this.rpm = numberField(exact((30 * RPM_PER_RAD_S).toFixed(2)), { id: "rpm", "aria-label": "speed in r/min" }, enter);
    // What is no number goes over as it is: both fields say so.
    const follow = (from, to, factor, places) => () => {
      const value = parseNumber(from.value);
      to.value = value === null ? from.value : exact((value * factor).toFixed(places));
    };
    this.speed.oninput = follow(this.speed, this.rpm, RPM_PER_RAD_S, 2);
    this.rpm.oninput = follow(this.rpm, this.speed, 1 / RPM_PER_RAD_S, 4);
    this.id = numberField(0, { id: "id-ref" }, enter);
    this.iq = numberField(0, { id: "iq-ref" }, enter);
    this.turns = numberField(0, { id: "turns" }, enter);
    this.torque = numberField(0, { id: "torque" }, enter);
    this.limit = numberField(30, { id: "speed-limit", "aria-label": "limit of the speed in rad/s" }, enter);
    const modes = [["speed", "Speed"], ["current", "Current"], ["position", "Position"], ["torque", "Torque"]];
    this.modeButtons = modes.map(([mode, text]) => h("button", { "data-mode": mode, onclick: () => this.setMode(mode) }, text));
    this.fields = {
      speed: h("div", { class: "setpoints" }, h("label", {}, this.speed, "rad/s"), h("label", {}, this.rpm, "r/min")),
      current: h("div", { class: "setpoints" }, h("label", {}, "id", this.id, "A"), h("label", {}, "iq", this.iq, "A")),
      position: h("div", { class: "setpoints one" }, h("label", {}, this.turns, "turns from zero")),
      torque: h("div", { class: "setpoints" }, h("label", {}, "iq", this.torque, "A"), h("label", {}, "≤ ±", this.limit, "rad/s")),
    };
    this.armButton = h("button", { id: "arm", title: "A", onclick: () => this.arm() }, "Arm");
    this.startButton = h("button", { id: "start", class: "primary", title: "Shift+Enter", onclick: () => this.start() }, "Start");
    this.said = h("div", { class: "said", id: "drive-said", role: "status" });
    $("drive").append(
      h("div", { class: "segments", role: "group", "aria-label": "what is controlled" }, ...this.modeButtons),
      ...Object.values(this.fields), h("div", { class: "actions" }, this.armButton, this.startButton), this.said);
    for (const topic of ["state", "status", "role", "drive"]) scope.on(topic, () => this.show());
    this.setMode("speed");
  }

  setMode(mode) {
    this.mode = mode;
    for (const [name, element] of Object.entries(this.fields)) element.hidden = name !== mode;
    this.show();
  }

  // The setpoint of the mode in force, ready to be typed over.
  select() {
    const field = { speed: this.speed, current: this.iq, position: this.turns, torque: this.torque }[this.mode];
    field.focus();
    field.select();
  }

  show() {
    const { state, mayWrite } = this.scope;
    const name = state?.state ?? "none";
    if (name === "run" && state.mode in this.fields && state.mode !== this.mode) {
      this.setMode(state.mode); // what another page has started
      return;
    }
    for (const button of this.modeButtons) {
      button.setAttribute("aria-pressed", button.dataset.mode === this.mode);
      button.disabled = name === "run" && button.dataset.mode !== this.mode;
    }
    const armed = Boolean(state?.armed);
    this.armButton.disabled = !mayWrite || name === "run" || name === "fault" || !state;
    this.armButton.textContent = armed ? "Armed" : "Arm";
    this.armButton.classList.toggle("on", armed);
    this.startButton.disabled = !mayWrite || (name !== "run" && !armed);
    this.startButton.textContent = name === "run" ? "Apply" : "Start";
    const key = `${name} ${mayWrite}`;
    if (key !== this.#shown) this.#say((mayWrite ? HINT[name] : WATCH_HINT[name] ?? HINT[name]) ?? "");
    this.#shown = key;
  }

  #shown = "";

  #setpoint() {
    const fields = {
      speed: [["speed_rad_s", this.speed]],
      current: [["id_a", this.id], ["iq_a", this.iq]],
      position: [["position_turns", this.turns]],
      torque: [["iq_a", this.torque], ["speed_rad_s", this.limit]],
    }[this.mode];
    const values = { mode: this.mode };
    for (const [name, field] of fields) {
      values[name] = numberOf(field);
      if (values[name] === null) throw new Error(`${name} = “${field.value}”: must be a number, such as 30 or 30.5`);
    }
    return values;
  }

  arm() {
    return this.#do(() => this.scope.ask("arm", { on: !this.scope.state?.armed }));
  }

  start() {
    if (this.scope.state?.state === "run") return this.apply();
    return this.#do(async () => this.scope.ask("start", this.#setpoint()));
  }

  // Enter in a field: a running drive takes it over, a resting one does not start.
  apply() {
    if (this.scope.state?.state !== "run") return this.#do(async () => this.#setpoint(), "Kept for the start.");
    return this.#do(async () => this.scope.ask("setpoint", this.#setpoint()), "Taken over.");
  }

  async #do(what, good = null) {
    try {
      await what();
      if (good) this.#say(good);
    } catch (error) {
      this.#say(error.message, true);
    }
  }

  #say(text, bad = false) {
    this.said.textContent = text;
    this.said.classList.toggle("bad", bad);
  }
}
