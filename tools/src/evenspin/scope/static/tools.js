// Calibrations, the recording of what is streamed, and parameters as a file. What they do is done by the scope; the files of
// calibrations and recordings are written where the command runs.

import { askFirst } from "./ask.js";
import { $, h, select } from "./dom.js";
import { withToken } from "./socket.js";
import { seconds } from "./format.js";

const LISTED = 12;

export class Tools {
  constructor(scope) {
    this.scope = scope;
    const said = (id) => h("p", { class: "said", id, role: "status" });
    this.record = h("button", { id: "record", title: "O", onclick: () => this.toggleRecording() }, "Record");
    this.recordSaid = said("record-said");
    this.save = h("a", { class: "button", id: "config-save", href: withToken("/export/drive.toml"), download: "drive.toml" }, "Save as drive.toml");
    this.file = h("input", { type: "file", id: "config-file", accept: ".toml", onchange: () => this.#load() });
    this.configSaid = said("config-said");
    this.what = select([], "", () => this.#describe(), { id: "calibration" });
    this.goal = h("p", { class: "note" });
    this.run = h("button", { class: "primary", id: "calibrate", onclick: () => this.#calibrate() }, "Calibrate");
    this.yes = h("button", { id: "calibrate-yes", onclick: () => this.#answer(true) }, "Done, go on");
    this.no = h("button", { id: "calibrate-no", onclick: () => this.#answer(false) }, "Leave it out");
    this.bar = h("progress", { max: 1, value: 0, "aria-label": "part of the calibration that is done" });
    this.lines = h("div", { id: "calibration-said", role: "status" });
    $("side-tools").append(h("div", { class: "list" },
      h("section", {}, h("h3", {}, "Record"), h("p", { class: "note" }, "All rows that are streamed, into a folder where the command runs: recording.csv and raw.mcap, which survives a crash."),
        this.record, this.recordSaid),
      h("section", {}, h("h3", {}, "Calibrate"), this.what, this.goal, this.run, " ", this.yes, " ", this.no, this.bar, this.lines),
      h("section", {}, h("h3", {}, "Parameters as a file"), h("p", { class: "note" }, "The file of evenspin bench config. Loading shows first what changes; Undo brings it back."),
        this.save, h("label", {}, "Load ", this.file), this.configSaid)));
    scope.on("drive", () => this.#adopt());
    for (const topic of ["role", "status", "state"]) scope.on(topic, () => this.#allow());
    scope.on("recording", (message) => this.#showRecording(message));
    scope.on("calibration", (message) => this.#showCalibration(message));
    this.#showCalibration({ status: "none", lines: [], part: 0 });
    this.#allow();
  }

  #recording = false;
  #calibrating = false;
  #since = 0;

  #adopt() {
    const { procedures } = this.scope.drive;
    const chosen = this.what.value;
    this.what.replaceChildren(...procedures.map(({ name }) => h("option", { value: name }, name)));
    this.what.value = procedures.some(({ name }) => name === chosen) ? chosen : procedures[0].name;
    this.#describe();
    this.#allow();
  }

  get #procedure() {
    return this.scope.drive?.procedures.find(({ name }) => name === this.what.value);
  }

  #describe() {
    const { goal = "", moves = "" } = this.#procedure ?? {};
    this.goal.textContent = `${goal} ${moves}`;
  }

  #allow() {
    const { mayLook, mayWrite, drive, state } = this.scope;
    this.record.disabled = !mayLook;
    this.save.hidden = !drive;
    this.file.disabled = !mayWrite;
    this.run.disabled = !mayWrite || this.#calibrating || state?.state === "run" || state?.state === "fault";
    for (const button of [this.yes, this.no]) button.disabled = !mayWrite;
    if (this.#recording) this.recordSaid.textContent = `${this.recordText} · ${seconds((performance.now() - this.#since) / 1000)}`;
  }

  #say(element, text, bad = false) {
    element.textContent = text;
    element.classList.toggle("bad", bad);
  }

  // ---- recording

  async toggleRecording() {
    try {
      await this.scope.ask("record", { on: !this.#recording });
    } catch (error) {
      this.#say(this.recordSaid, error.message, true);
    }
  }

  #showRecording({ on, text }) {
    if (on && !this.#recording) this.#since = performance.now();
    this.#recording = on;
    this.recordText = text;
    this.record.textContent = on ? "End recording" : "Record";
    this.record.classList.toggle("on", on);
    this.#say(this.recordSaid, text, text.startsWith("The recording is not complete"));
    if (text) this.scope.tell("said", on ? "recording" : "");
  }

  // ---- parameters as a file

  async #load() {
    const [file] = this.file.files;
    if (!file) return;
    try {
      if (file.size > 60000) throw new Error(`${file.name}: larger than 60 kB; it is no file of parameters`);
      const request = { text: await file.text(), name: file.name.slice(0, 100) };
      const { changes } = await this.scope.ask("config", request);
      if (!changes.length) return this.#say(this.configSaid, `${file.name}: no difference to the drive`);
      const lines = changes.slice(0, LISTED).map(({ name, file: wanted, drive, unit }) => `${name}: ${drive} → ${wanted} ${unit}`);
      const more = changes.length > LISTED ? [`and ${changes.length - LISTED} more`] : [];
      if (!(await askFirst(`Load ${changes.length} values from ${file.name}?`, [...lines, ...more], "Load"))) return this.#say(this.configSaid, "Not loaded.");
      await this.scope.ask("config", { ...request, apply: true });
      this.#say(this.configSaid, `${file.name}: ${changes.length} values are in force; Save keeps them, Undo brings the others back.`);
    } catch (error) {
      this.#say(this.configSaid, error.message, true);
    } finally {
      this.file.value = "";
    }
    return null;
  }

  // ---- calibrations

  async #calibrate() {
    const { name, goal, moves } = this.#procedure;
    const stop = "STOP, the space bar or Esc end it at once; the parameters are then those from before.";
    if (!(await askFirst(`Calibrate ${name}?`, [goal, moves, "The live trace rests meanwhile. What is found is in force at once when it is good.", stop], "Calibrate"))) return;
    try {
      await this.scope.ask("calibrate", { name });
    } catch (error) {
      this.#lines([error.message], true);
    }
  }

  #answer(yes) {
    this.scope.ask("calibrate_answer", { yes }).catch((error) => this.#lines([error.message], true));
  }

  #lines(lines, bad = false) {
    this.lines.replaceChildren(...lines.map((line) => h("p", { class: bad || /NOT GOOD|failed/.test(line) ? "said bad" : "said" }, line)));
  }

  #showCalibration({ status, lines, part }) {
    this.#calibrating = status === "running" || status === "question";
    this.yes.hidden = this.no.hidden = status !== "question";
    this.bar.hidden = !this.#calibrating;
    this.bar.value = part;
    this.lines.dataset.status = status;
    this.#lines(lines, status === "failed");
    this.#allow();
  }
}
