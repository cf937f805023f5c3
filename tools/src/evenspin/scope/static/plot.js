// uPlot in the dress of this page.

export const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

export const signalColour = (index) => css(`--s${index % 8}`);

const FONT = "13px system-ui, 'DejaVu Sans', sans-serif";

// As many digits as it takes to tell the ticks apart.
const tickTexts = (_, ticks) => ticks.map((tick) => (tick === null ? "" : String(Number(tick.toPrecision(6))).replace("-", "−")));

export function axis(label, options = {}) {
  return {
    label, labelFont: `600 ${FONT}`, font: FONT, stroke: css("--soft"), labelSize: 18, labelGap: 0,
    grid: { stroke: css("--grid"), width: 1 }, ticks: { stroke: css("--line"), width: 1, size: 5 }, values: tickTexts,
    ...options,
  };
}

// Limits that follow the signal without trembling: wider at once, narrower only when half of them is unused for a second.
export class Limits {
  #low = NaN;
  #high = NaN;
  #roomy = 0;

  // `least`: never narrower than this, so that noise at rest does not fill the plot.
  follow(low, high, least) {
    if (!(low <= high)) return this.range;
    const pad = 0.06 * Math.max(high - low, least);
    const [wantLow, wantHigh] = nice(low - pad, high + pad, least);
    const now = performance.now();
    const outside = !(low >= this.#low && high <= this.#high);
    const tight = wantHigh - wantLow > 0.5 * (this.#high - this.#low);
    if (outside) {
      this.#low = Math.min(wantLow, Number.isNaN(this.#low) ? wantLow : Math.max(this.#low, wantLow - (wantHigh - wantLow)));
      this.#high = Math.max(wantHigh, Number.isNaN(this.#high) ? wantHigh : Math.min(this.#high, wantHigh + (wantHigh - wantLow)));
      this.#roomy = now;
    } else if (tight) {
      this.#roomy = now;
    } else if (now - this.#roomy > 1000) {
      [this.#low, this.#high] = [wantLow, wantHigh];
      this.#roomy = now;
    }
    return this.range;
  }

  get range() {
    return Number.isNaN(this.#low) ? [-1, 1] : [this.#low, this.#high];
  }
}

export function nice(low, high, least = 0) {
  if (high - low < least) {
    const middle = (low + high) / 2;
    [low, high] = [middle - least / 2, middle + least / 2];
  }
  const step = 10 ** Math.floor(Math.log10(Math.max(high - low, 1e-12))) / 5;
  return [Math.floor(low / step) * step, Math.ceil(high / step) * step];
}

export function extent(columns) {
  let low = Infinity, high = -Infinity;
  for (const column of columns) {
    for (const value of column) {
      if (value === null || Number.isNaN(value)) continue;
      if (value < low) low = value;
      if (value > high) high = value;
    }
  }
  return [low, high];
}

// A plot that fills its element, now and when that changes its size.
export function fitted(element, options, data) {
  const size = () => ({ width: Math.max(50, element.clientWidth), height: Math.max(40, element.clientHeight) });
  const plot = new uPlot({ ...options, ...size(), legend: { show: false } }, data, element);
  const observer = new ResizeObserver(() => {
    const { width, height } = size();
    if (width !== plot.width || height !== plot.height) plot.setSize({ width, height });
  });
  observer.observe(element);
  return { plot, destroy: () => { observer.disconnect(); plot.destroy(); } };
}

// The plots of a view as a picture, with what they show written on it.
export function picture(view, title) {
  const bounds = view.getBoundingClientRect();
  const canvases = [...view.querySelectorAll("canvas")].filter((canvas) => canvas.offsetParent);
  if (!canvases.length) return null;
  const scale = devicePixelRatio || 1, top = 34;
  const image = document.createElement("canvas");
  const first = Math.min(...canvases.map((canvas) => canvas.getBoundingClientRect().top)) - 30;
  image.width = bounds.width * scale;
  image.height = (bounds.bottom - first + top) * scale;
  const pen = image.getContext("2d");
  pen.scale(scale, scale);
  pen.fillStyle = css("--card");
  pen.fillRect(0, 0, bounds.width, bounds.height + top + 30);
  pen.fillStyle = css("--ink");
  pen.font = `600 15px system-ui, 'DejaVu Sans', sans-serif`;
  pen.fillText(title, 12, 22);
  for (const canvas of canvases) {
    const place = canvas.getBoundingClientRect();
    pen.drawImage(canvas, place.left - bounds.left, place.top - first + top, place.width, place.height);
  }
  for (const cursor of view.querySelectorAll(".cursor.shown")) {
    const place = cursor.getBoundingClientRect();
    const x = place.left + place.width / 2 - bounds.left, y = place.top - first + top;
    pen.fillStyle = css("--ink");
    pen.fillRect(x - 1, y, 2, place.height);
    pen.font = "700 12px 'DejaVu Sans', sans-serif";
    pen.fillText(cursor.innerText, x + 4, y + 10);
  }
  for (const item of view.querySelectorAll(".legend span")) {
    const place = item.getBoundingClientRect();
    pen.fillStyle = getComputedStyle(item.querySelector("i")).borderTopColor;
    pen.font = "600 13px 'DejaVu Sans Mono', monospace";
    pen.fillText(`■ ${item.innerText.replace(/\s+/g, " ")}`, place.left - bounds.left, place.bottom - first + top - 6);
  }
  return image;
}
