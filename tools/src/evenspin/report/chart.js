// Every picture of this page that has its numbers beside it is drawn again with uPlot: cursor, zoom by dragging, double click
// for the whole. Without a script, and on paper, the SVG stands.
"use strict";
(() => {
  const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const digits = (value) => (value === null || value === undefined ? "" : String(Number(value.toPrecision(6))).replace("-", "−"));
  const dark = matchMedia("(prefers-color-scheme: dark)");

  // Bars as wide as they say, whatever stands beside them.
  const bars = (width) => (plot, series, first, last) => {
    const fill = new Path2D(), clip = new Path2D();
    const { left, top, width: wide, height } = plot.bbox;
    clip.rect(left, top, wide, height);
    for (let i = first; i <= last; i++) {
      const x = plot.data[0][i], y = plot.data[series][i];
      if (y === null || y === undefined) continue;
      const [from, to] = [x - width / 2, x + width / 2].map((end) => plot.valToPos(end, "x", true));
      const high = Math.min(plot.valToPos(y, "y", true), top + height);
      fill.rect(from, high, to - from, top + height - high);
    }
    return { fill, stroke: null, clip };
  };

  function series(line) {
    const isBars = line.kind === "bars";
    return {
      label: line.label, width: line.width * 1.2, dash: line.dashed ? [6, 4] : undefined,
      stroke: line.ink ? css("--ink") : line.colour, fill: isBars ? line.colour : undefined,
      paths: isBars ? bars(line.bar_width) : line.kind === "points" ? () => null : undefined,
      points: { show: line.kind === "points", size: 4 }, value: (_, value) => digits(value) || "-",
    };
  }

  function axis(label, whole) {
    return {
      label, incrs: whole ? [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000] : undefined, stroke: css("--soft"), grid: { stroke: css("--line"), width: 1 }, ticks: { stroke: css("--line"), width: 1 },
      values: (_, ticks) => ticks.map(digits), labelSize: 20, font: "12px system-ui", labelFont: "12px system-ui",
    };
  }

  function draw(panel, height, place) {
    const data = uPlot.join(panel.lines.map((line) => [line.x, line.y]));
    const ends = [data[0][0], data[0][data[0].length - 1]];
    const whole = (low, high) => panel.x_range && low <= ends[0] && high >= ends[1];
    const orders = panel.lines.every((line) => line.kind === "bars"); // bars stand at whole numbers
    const y = panel.log ? { distr: 3, log: 10 } : {};
    if (panel.y_range) y.range = panel.y_range;
    const options = {
      width: Math.max(200, place.clientWidth), height: Math.max(180, height), title: panel.title,
      scales: { x: { time: false, range: (_, low, high) => whole(low, high) ? panel.x_range : [low, high] }, y }, axes: [axis(panel.x, orders), axis(panel.y)],
      series: [{ label: panel.x, value: (_, value) => digits(value) || "-" }, ...panel.lines.map(series)],
      cursor: panel.group ? { sync: { key: panel.group } } : {},
    };
    return new uPlot(options, data, place);
  }

  let plots = [];
  function drawAll() {
    plots.forEach((each) => each.plot.destroy());
    plots = [];
    for (const source of document.querySelectorAll("script.chart")) {
      const chart = JSON.parse(source.textContent);
      const figure = source.parentElement;
      const live = figure.querySelector(".live");
      live.replaceChildren();
      const crowded = Math.max(...chart.panels.map((panel) => panel.lines.length)) > 3; // room for the legend
      live.style.setProperty("--columns", crowded ? Math.min(chart.columns, 2) : chart.columns);
      figure.classList.add("drawn");
      for (const panel of chart.panels) {
        const place = live.appendChild(document.createElement("div"));
        plots.push({ place, plot: draw(panel, chart.height, place) });
      }
    }
  }

  drawAll();
  dark.addEventListener("change", drawAll);
  let waiting = 0;
  addEventListener("resize", () => {
    cancelAnimationFrame(waiting);
    waiting = requestAnimationFrame(() => {
      for (const { place, plot } of plots) plot.setSize({ width: Math.max(200, place.clientWidth), height: plot.height });
    });
  });
})();
