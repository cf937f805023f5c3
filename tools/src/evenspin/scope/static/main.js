// Puts the page together. `Scope` is what the page knows; the panels listen to it and ask it.

import { Banners } from "./banners.js";
import { BodeView } from "./bode.js";
import { CaptureView } from "./capture.js";
import { $, h } from "./dom.js";
import { DrivePanel } from "./drive.js";
import { number, RPM_PER_RAD_S } from "./format.js";
import { bindKeys } from "./keys.js";
import { Layouts } from "./layouts.js";
import { LiveView } from "./live.js";
import { Parameters } from "./parameters.js";
import { picture } from "./plot.js";
import { Ring } from "./ring.js";
import { Signals } from "./signals.js";
import { Socket, withToken } from "./socket.js";
import { SpectrumView } from "./spectrum.js";
import { Tools } from "./tools.js";
import { XyView } from "./xy.js";

const CAPTURE = 3;
const SLOW_MS = 200;

class Scope extends EventTarget {
  connected = false;
  refused = false;
  link = { status: "searching", text: "Connecting." };
  drive = null;
  state = null;
  values = {};
  undo = null;
  layout = null;
  ring = new Ring([]);
  role = "watch";
  pages = 1;
  free = false;
  capture = null;
  #socket = new Socket();
  #captureLayout = null;

  open() {
    const socket = this.#socket;
    const keep = (type, change) => socket.on(type, (message) => { change(message); this.tell(type, message); });
    socket.on("open", () => { this.connected = true; this.tell("status"); });
    socket.on("close", () => { this.connected = false; this.state = null; this.tell("status"); this.tell("state"); });
    socket.on("refused", () => { this.refused = true; this.tell("status"); });
    keep("drive", (message) => (this.drive = message));
    keep("state", (message) => (this.state = message));
    keep("values", ({ values, undo }) => Object.assign(this, { values, undo }));
    keep("role", ({ role, pages, free }) => Object.assign(this, { role, pages, free }));
    for (const type of ["capture", "recording", "calibration", "bode"]) keep(type, () => {});
    keep("layout", (message) => this.#newLayout(message));
    socket.on("link", (message) => {
      this.link = message;
      if (message.status !== "connected") this.state = null;
      this.tell("status");
      this.tell("state");
    });
    socket.on("capture_layout", (message) => (this.#captureLayout = message));
    socket.on("rows", (rows) => this.#rows(rows));
    socket.open();
  }

  // The same signals after a cable was out: the plot goes on, with a gap.
  #newLayout(message) {
    const same = this.layout && message.names.join() === this.layout.names.join();
    if (!same) this.ring = new Ring(message.names);
    this.layout = message;
  }

  #rows({ kind, layout, t, columns }) {
    if (kind === CAPTURE) {
      if (this.#captureLayout?.id === layout) this.capture.take(this.#captureLayout, t, columns);
      this.tell("record");
    } else if (layout === this.layout?.id && t.length) {
      if (t[0] < this.ring.lastTime) this.ring = new Ring(this.layout.names); // the drive has started again
      else if (t[0] - this.ring.lastTime > 0.1) this.ring.append([t[0]], columns.map(() => [NaN]));
      this.ring.append(t, columns);
    }
  }

  get names() {
    return this.layout?.names ?? [];
  }

  get inControl() {
    return this.connected && this.link.status === "connected" && this.role === "control";
  }

  get mayWrite() {
    return this.inControl && this.drive !== null && !this.drive.read_only;
  }

  // Streaming and capturing change nothing: a drive of other firmware allows them, too.
  get mayLook() {
    return this.inControl;
  }

  ask(what, fields) {
    return this.#socket.ask(what, fields);
  }

  stop() {
    return this.#socket.stop();
  }

  watch(names, rate = this.layout?.rate_hz ?? 1000) {
    return this.ask("watch", { signals: names, rate_hz: rate });
  }

  clearFault() {
    return this.ask("clear_fault").catch((error) => this.tell("said", error.message));
  }

  async lastSamples() {
    try {
      await this.ask("last_fault");
      showView("capture");
    } catch (error) {
      this.tell("said", error.message);
    }
  }

  tell(type, detail) {
    this.dispatchEvent(new CustomEvent(type, { detail }));
  }

  on(type, listener) {
    this.addEventListener(type, ({ detail }) => listener(detail));
  }
}

const scope = new Scope();
const views = {};
let shown = "live";

// ---- stop: first, so that nothing that fails below can be in its way

function stop() {
  scope.stop().catch((error) => {
    scope.tell("said", `stop: ${error.message}; a drive that hears nothing stops by itself after 0.5 s`);
  });
}
$("stop").addEventListener("pointerdown", stop); // a finger that slides off has stopped it, too
$("stop").addEventListener("click", (event) => event.detail === 0 && stop()); // Enter on the button

// ---- header and footer

function showHeader() {
  const { link, state, connected, drive } = scope;
  const status = connected ? link.status : "gone";
  $("link").dataset.status = status;
  $("link").title = `${drive?.port ?? ""} ${link.text}`;
  $("link").querySelector("span").textContent = status === "connected" ? `${drive?.name ?? ""}` : status === "gone" ? "scope ended" : "searching";
  const name = state?.state ?? "none";
  $("state").dataset.state = name;
  $("state").querySelector("span").textContent = name === "none" ? "no drive" : name.replace("_", " ") + (state.armed && name === "ready" ? " · armed" : "");
  document.title = `${name === "none" ? "no drive" : name} · evenspin scope`;
}

const READ = [
  ["speed_rad_s", "speed", (v) => number(v * RPM_PER_RAD_S, 4), "r/min"], ["speed_rad_s", "speed", (v) => number(v), "rad/s"],
  ["iq_a", "iq", (v) => number(v), "A"], ["vdc_v", "dc link", (v) => number(v), "V"],
];

let said = "";
function showSlowThings() {
  const { ring, state, layout } = scope;
  const there = READ.filter(([name]) => ring.names.includes(name) && state);
  $("readouts").replaceChildren(...there.map(([name, text, show, unit]) => h("div", { "data-read": `${name} ${unit}` }, h("small", {}, text), show(ring.mean(name, 0.2)), " ", h("em", {}, unit))));
  const item = (text, value, alert = false) => h("span", { class: alert ? "alert" : "" }, `${text} `, h("b", {}, value));
  const foot = $("foot");
  foot.dataset.fps = views.live.fps;
  foot.dataset.lost = state?.lost_rows ?? "";
  foot.replaceChildren(
    item("drive time", state ? `${state.uptime_s.toFixed(1)} s` : "–"),
    item("stream", layout ? `${layout.names.length} signals at ${number(layout.rate_hz, 4)} Hz` : "–"),
    item("lost rows", String(state?.lost_rows ?? "–"), state?.lost_rows > 0), item("frames", shown === "live" && views.live.pausedAt === null ? `${views.live.fps}/s` : "–"),
    item("bad frames on the link", String(state?.frames_bad ?? "–")), h("span", { class: "alert", id: "said" }, said));
}

// ---- views

function showView(name) {
  shown = name;
  for (const key of Object.keys(views)) views[key].element.hidden = key !== name;
  for (const tab of document.querySelectorAll("[data-view]")) tab.setAttribute("aria-selected", tab.dataset.view === name);
  views[name].rebuild?.();
}

const KEPT_VIEWS = ["live", "capture", "xy", "spectrum"];

const layoutNow = () => ({
  signals: scope.names, rate_hz: scope.layout.rate_hz, view: shown === "bode" ? "live" : shown, ...Object.fromEntries(KEPT_VIEWS.map((name) => [name, views[name].state])),
});

async function applyLayout(layout) {
  const same = layout.signals.join() === scope.names.join() && layout.rate_hz === scope.layout?.rate_hz;
  if (!same) await scope.watch(layout.signals, layout.rate_hz);
  for (const name of KEPT_VIEWS) views[name].state = layout[name];
  showView(layout.view);
}

function showSide(name) {
  for (const key of ["parameters", "signals", "tools"]) $(`side-${key}`).hidden = key !== name;
  for (const tab of document.querySelectorAll("[data-side]")) tab.setAttribute("aria-selected", tab.dataset.side === name);
}

const fromCapture = () => shown === "capture" || views[shown].source?.value === "capture";

function exportCsv() {
  if (shown === "bode") return views.bode.exportCsv();
  const source = fromCapture() ? "capture" : "live";
  if (source === "live" ? !scope.ring.written : !scope.capture.record) {
    said = "export: there are no rows yet";
    return null;
  }
  h("a", { href: withToken(`/export/${source}.csv?seconds=${views.live.seconds}`), download: `${source}.csv` }).click();
  return null;
}

function exportPicture() {
  const what = fromCapture() ? scope.capture.record?.title ?? "" : `drive time ${number(scope.ring.lastTime, 6)} s`;
  const image = picture(views[shown].element, `evenspin scope · ${scope.drive?.name ?? ""} · ${shown} · ${what}`);
  image?.toBlob((blob) => {
    const url = URL.createObjectURL(blob);
    h("a", { href: url, download: `${shown}.png` }).click();
    setTimeout(() => URL.revokeObjectURL(url), 1000);
  });
}

function setTheme(theme) {
  document.documentElement.dataset.theme = theme;
  localStorage.setItem("theme", theme);
  scope.tell("theme");
}
const otherTheme = () => setTheme(document.documentElement.dataset.theme === "dark" ? "light" : "dark");

// ---- all of it

document.documentElement.dataset.theme = localStorage.getItem("theme")
  ?? (matchMedia("(prefers-color-scheme: light)").matches ? "light" : "dark");
scope.on("said", (text) => (said = text));
const drive = new DrivePanel(scope);
views.live = new LiveView(scope);
views.capture = scope.capture = new CaptureView(scope);
views.xy = new XyView(scope);
views.spectrum = new SpectrumView(scope);
views.bode = new BodeView(scope);
const layouts = new Layouts(scope, layoutNow, applyLayout);
const parameters = new Parameters(scope);
new Signals(scope);
const tools = new Tools(scope);
new Banners(scope);
for (const topic of ["state", "status", "drive"]) scope.on(topic, showHeader);
for (const tab of document.querySelectorAll("[data-view]")) tab.onclick = () => showView(tab.dataset.view);
for (const tab of document.querySelectorAll("[data-side]")) tab.onclick = () => showSide(tab.dataset.side);
$("theme").onclick = otherTheme;
$("exports").append(
  h("button", { id: "show-layouts", title: "L: signals, views and cursors by name", onclick: () => layouts.show() }, "Layouts"), " ",
  h("button", { id: "export-csv", title: "E: these rows in the log format", onclick: exportCsv }, "CSV"), " ",
  h("button", { id: "export-png", title: "I: what is shown as a picture", onclick: exportPicture }, "PNG"));
bindKeys(stop, {
  start: () => drive.start(), a: () => drive.arm(), p: () => views.live.pause(), t: () => { showView("live"); views.live.trigger.nextMode(); }, r: () => views.live.trigger.again(), c: () => { showView("capture"); views.capture.arm(); },
  1: () => showView("live"), 2: () => showView("capture"), 3: () => showView("xy"), 4: () => showView("spectrum"), 5: () => showView("bode"),
  "+": () => views.live.zoom(-1), "-": () => views.live.zoom(1), "/": () => { showSide("parameters"); parameters.search.focus(); },
  u: () => showSide("tools"), o: () => tools.toggleRecording(), l: () => layouts.show(), k: () => views[shown].kept?.keep(), x: () => (views[shown].panes ?? views[shown]).cursors?.toggle(), g: () => showSide("signals"), s: () => drive.select(), e: exportCsv, i: exportPicture, d: otherTheme,
});
showView("live");
showSide("parameters");
showHeader();
scope.open();

let slowAt = 0;
function frame(now) {
  requestAnimationFrame(frame); // first: a picture that cannot be drawn must not be the last one
  views[shown].draw(now);
  if (now - slowAt > SLOW_MS) {
    slowAt = now;
    showSlowThings();
  }
}
requestAnimationFrame(frame);
