"use strict";
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);

  const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const floats = (text) => new Float32Array(bytes(text).buffer);
  const doubles = (text) => new Float64Array(bytes(text).buffer);
  const color = (name) =>
    getComputedStyle(document.documentElement).getPropertyValue(name).trim();

  const LINE_COLORS = ["#ff6f3c", "#ffffff", "#56c8ff"];
  const CURVE_COLORS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"];
  // Beyond the colours, and the ink behind them, they return with other dashes and symbols.
  const DASHES = ["solid", "dot", "longdash", "dashdot"];
  const SYMBOLS = ["circle", "square", "triangle-up", "x"];
  // From the first place to the last, by way of one that is neither.
  const SHADES = [[0, 114, 178], [128, 120, 120], [213, 94, 0]];
  const WIDTHS = { thin: 1, gap: 5 };
  // Of curves that coincide, the first show beside the last.
  const boldWidth = (place) => 6.5 - 3 * place;
  // Curves of at most this many points show each of them.
  const MARKED_POINTS = 60;
  const FONT = '"DejaVu Sans", system-ui, sans-serif';
  // Share of the largest magnitude below which a signed log scale is linear.
  const LINEAR_SHARE = 1e-4;
  // Decades that a logarithmic axis of curves spans at most.
  const DECADES = 16;
  // Pixels a sample needs to be drawn by itself.
  const SAMPLE_PIXELS = 0.5;
  const NO_VALUE = 255;
  // Lesser over larger magnitude of the signs in a cell from which on it is drawn as both.
  const BOTH_SIGNS = 0.5;
  // Share of the scale up to which a cell is drawn as zero, whatever its signs.
  const NEAR_ZERO = 1 / 32;
  const isNearZero = (scale, size) => 2 * scale.place(size) - 1 < NEAR_ZERO;
  // A slow machine draws between the clicks of a double click.
  const CONFIG = { displayModeBar: false, responsive: true, doubleClick: false, doubleClickDelay: 600, showTips: false };

  const coarse = window.matchMedia("(pointer: coarse)");

  const palettes = { sequential: bytes(data.sequential), diverging: bytes(data.diverging) };
  const rgb = (palette, level) => `rgb(${palette.subarray(3 * level, 3 * level + 3).join(",")})`;
  const colorscale = (palette) =>
    Array.from({ length: 255 }, (_, level) => [level / 254, rgb(palette, level)]);

  const SUPERSCRIPTS = { "-": "⁻", 0: "⁰", 1: "¹", 2: "²", 3: "³", 4: "⁴", 5: "⁵", 6: "⁶", 7: "⁷", 8: "⁸", 9: "⁹" };
  const power = (n) => `10${String(n).replace(/./g, (c) => SUPERSCRIPTS[c])}`;
  // A label of values divided by 10^n: the power stands before the unit.
  const inPowersOfTen = (label, n) => {
    const at = label.endsWith("]") ? label.lastIndexOf(" [") : label.endsWith(")") ? label.lastIndexOf(" (") : -1;
    const [name, unit] = at < 0 ? [label, ""] : [label.slice(0, at), label.slice(at + 2, -1)];
    const scaled = unit.startsWith("1/") ? power(n) + unit.slice(1) : `${power(n)} ${unit}`.trim();
    return scaled.includes("(") ? `${name} [${scaled}]` : `${name} (${scaled})`;
  };
  const minus = (text) => text.replace(/-/g, "−");

  function show(value, digits = 5) {
    if (value === null || !Number.isFinite(value)) return "no value";
    const size = Math.abs(value);
    if (size === 0 || (size >= 1e-3 && size < 1e6)) {
      return minus(String(Number(value.toPrecision(digits))));
    }
    const [digitsOf, exponent] = value.toExponential(digits - 1).split("e");
    const mantissa = String(Number(digitsOf));
    return minus(mantissa === "1" ? power(Number(exponent)) : `${mantissa}·${power(Number(exponent))}`);
  }

  function shadeOf(place) {
    const n = Math.min(Math.floor(2 * place), 1);
    const between = SHADES[n].map((v, i) => v + (2 * place - n) * (SHADES[n + 1][i] - v));
    return `rgb(${between.map(Math.round).join(",")})`;
  }

  function roundTicks(low, high, count) {
    const rough = (high - low) / Math.max(count, 1);
    const base = 10 ** Math.floor(Math.log10(rough));
    const step = base * [1, 2, 5, 10].find((m) => m * base >= rough * (1 - 1e-9));
    const ticks = [];
    for (let n = Math.ceil(low / step - 1e-9); n * step <= high + 1e-9 * step; n++) {
      ticks.push(n * step);
    }
    return Number.isFinite(step) ? ticks : [];
  }

  // ---- Scales: value -> position, ticks, label. A value of NaN has no position.

  function linearScale(low, high) {
    const place = (v) => (v - low) / (high - low);
    return { place, ticks: roundTicks(low, high, 6), show: (v) => show(v, 3), label: "", lowest: null };
  }

  function logScale(low, high, smaller) {
    const [bottom, top] = [Math.log10(low), Math.log10(high)];
    const exponents = roundTicks(bottom, top, 8).filter(Number.isInteger);
    return {
      place: (v) => (v <= low ? 0 : (Math.log10(v) - bottom) / (top - bottom)),
      ticks: exponents.length > 1 ? exponents.map((e) => 10 ** e) : [low, high],
      show: (v) => (exponents.length > 1 ? power(Math.round(Math.log10(v))) : show(v, 3)),
      label: "",
      lowest: smaller ? low : null,
    };
  }

  function signedLogScale(limit) {
    const knee = 10 ** Math.round(Math.log10(limit * LINEAR_SHARE));
    const reach = Math.asinh(limit / knee);
    const sizes = [10, 100, 1e3, 1e4, 1e5].map((n) => n * knee).filter((v) => v <= limit);
    return {
      place: (v) => 0.5 + (0.5 * Math.asinh(v / knee)) / reach,
      ticks: [...sizes.map((s) => -s).reverse(), 0, ...sizes],
      show: (v) => show(v, 3),
      label: `, linear below ${show(knee)}`,
      lowest: null,
    };
  }

  // The scale of values, or of a `range` of sizes that maps share; a linear one about zero ends at `limit`.
  function scaleOf(values, { signed, range, limit }, log) {
    let [least, most] = range ?? [Infinity, 0];
    let smaller = false;
    for (const value of values) {
      if (!Number.isFinite(value)) continue;
      const size = signed ? Math.abs(value) : value;
      if (size > 0) {
        least = Math.min(least, size);
        most = Math.max(most, size);
      } else {
        smaller = true;
      }
    }
    if (most === 0) [least, most] = [0.1, 1];
    if (!(least < Infinity)) least = most;
    if (signed) return log ? signedLogScale(most) : linearScale(-(limit ?? most), limit ?? most);
    if (!log) return linearScale(0, most);
    const lowest = most * 10 ** -data.decades;
    const low = data.fixed ? lowest : Math.min(Math.max(least, lowest), most / 10);
    return logScale(low, most, smaller || least < low);
  }

  // ---- Look.

  const axisStyle = (title) => ({
    title: { text: title, standoff: 8, font: { size: title.length > 40 ? 11 : 13 } },
    gridcolor: color("--grid"),
    linecolor: color("--faint"),
    zerolinecolor: color("--grid"),
    showline: true,
    mirror: true,
    ticks: "outside",
    tickcolor: color("--faint"),
    exponentformat: "power",
    minexponent: 5,
    tickfont: { size: 11 },
    automargin: true,
  });

  const layoutOf = (changes) => ({
    paper_bgcolor: "rgba(0,0,0,0)",
    plot_bgcolor: "rgba(0,0,0,0)",
    font: { family: FONT, size: 12, color: color("--ink") },
    margin: { l: 70, r: 12, t: 30, b: 50 },
    // Where fingers scroll the page, buttons zoom.
    dragmode: coarse.matches ? false : "zoom",
    hoverlabel: { font: { family: FONT } },
    separators: ". ",
    ...changes,
  });

  const lineShape = (axis, value, style, dash, yref) => ({
    type: "line",
    xref: axis === "x" ? "x" : "x domain",
    yref: axis === "x" ? "y domain" : (yref ?? "y"),
    ...(axis === "x" ? { x0: value, x1: value, y0: 0, y1: 1 } : { x0: 0, x1: 1, y0: value, y1: value }),
    line: { color: style, width: 1, dash },
  });

  function save(name, content, type) {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([content], { type }));
    link.download = name;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  }

  async function savePng(plot, name) {
    const picture = await Plotly.toImage(plot, {
      format: "png",
      width: plot.clientWidth,
      height: plot.clientHeight,
      scale: 3,
    });
    save(`${name}.png`, bytes(picture.split(",")[1]), "image/png");
  }

  const quoted = (text) => `"${text.replaceAll('"', '""')}"`;

  // ---- Picks, shared by all pictures whose axes count the same.

  const picked = {};
  const views = [];
  const pick = (changes) => {
    Object.assign(picked, changes);
    for (const view of started()) {
      if (near.has(view.root)) view.follow();
      else behind.add(view);
    }
  };
  // Sections near the window, and views that follow the picks once they come near.
  const near = new Set();
  const behind = new Set();

  // ---- Curves: samples where they fit, else the least and the largest of each pixel.

  // Values with x in [low, high], thinned to `pixels`; x rises.
  function visible(x, values, low, high, pixels) {
    let [first, end] = [0, x.length];
    while (first + 1 < end && x[first + 1] < low) first++;
    while (end - 1 > first && x[end - 2] > high) end--;
    const per = Math.ceil((end - first) * SAMPLE_PIXELS / Math.max(pixels, 100));
    if (per <= 1) {
      return {
        x: Array.from(x.slice(first, end)),
        y: Array.from(values.slice(first, end), (v) => (Number.isFinite(v) ? v : null)),
        per,
      };
    }
    // Two points a block: its extremes at a quarter and at three quarters, in their order.
    const [xs, ys] = [[], []];
    const block = 2 * per;
    for (let start = first; start < end; start += block) {
      const stop = Math.min(start + block, end);
      xs.push(x[start + ((stop - start) >> 2)], x[start + ((3 * (stop - start)) >> 2)]);
      let [least, most] = [-1, -1];
      for (let i = start; i < stop; i++) {
        if (!Number.isFinite(values[i])) continue;
        if (least < 0 || values[i] < values[least]) least = i;
        if (most < 0 || values[i] > values[most]) most = i;
      }
      if (least < 0) ys.push(null, null);
      else ys.push(values[Math.min(least, most)], values[Math.max(least, most)]);
    }
    return { x: xs, y: ys, per: block };
  }

  // Least, largest and least positive value of series, their errors included.
  function boundsOf(series) {
    const bounds = { low: Infinity, high: -Infinity, positive: Infinity };
    for (const { values, errors } of series) {
      for (const [i, v] of values.entries()) {
        if (!Number.isFinite(v)) continue;
        const error = errors && Number.isFinite(errors[i]) ? errors[i] : 0;
        bounds.low = Math.min(bounds.low, v - error);
        bounds.high = Math.max(bounds.high, v + error);
        if (v > 0) bounds.positive = Math.min(bounds.positive, v);
      }
    }
    return bounds;
  }

  // A power of ten in whose units values are of moderate size: plots of 1e-300 have round ticks.
  function exponentOf({ low, high }) {
    const most = Math.max(Math.abs(low), Math.abs(high));
    const exponent = most > 0 && most < Infinity ? Math.floor(Math.log10(most)) : 0;
    return Math.abs(exponent) < 7 ? 0 : exponent;
  }

  // Multiplies by 10^-exponent, in two steps since that may be out of range.
  function unscaled(exponent) {
    const half = Math.trunc(-exponent / 2);
    const [a, b] = [10 ** half, 10 ** (-exponent - half)];
    return (v) => v * a * b;
  }

  // Whole decades, at least one, at most DECADES; at most eight are labelled.
  function logAxis({ high, positive }) {
    const top = Math.ceil(Math.log10(high) + 1e-9);
    const bottom = Math.max(Math.floor(Math.log10(positive) - 1e-9), top - DECADES);
    // Plotly enlarges the labels of logarithmic axes by a quarter.
    return { type: "log", range: [bottom, top], dtick: Math.ceil((top - bottom) / 8), tickfont: { size: 9 } };
  }

  // An axis of a few decades is labelled at 1, 2 and 5 in each.
  function logTicks(range) {
    if (!range || range[1] > 1e4 * range[0]) return { type: "log" };
    const first = Math.floor(Math.log10(range[0]));
    const last = Math.ceil(Math.log10(range[1]));
    const tickvals = Array.from({ length: last - first + 1 }, (_, n) => 10 ** (first + n))
      .flatMap((decade) => [decade, 2 * decade, 5 * decade]);
    return { type: "log", tickmode: "array", tickvals, ticktext: tickvals.map((v) => show(v, 2)) };
  }

  // From 0, unless the values vary little; constant ones stay clear of the frame.
  function linearAxis({ low, high }, exponent) {
    if (low === Infinity) return {};
    const moderate = unscaled(exponent);
    const [least, most] = [moderate(low), moderate(high)];
    if (least < most && (least > 0.6 * most && least > 0 || most < 0.6 * least && most < 0)) {
      const margin = 0.06 * (most - least);
      return { range: [least - margin, most + margin] };
    }
    const [from, to] = [Math.min(least, 0), Math.max(most, 0)];
    const margin = 0.04 * (to - from || 1);
    return { range: [from < 0 ? from - margin : from, to > 0 || from === to ? to + margin : to] };
  }

  class CurvePlot {
    // group: { title, xLabel, x, role, log, marks, cumulative, note, charts: [{ label, log, levels, series }] }
    // series: { label, values, x, look, color, shade, weight, errors, band }
    constructor(root, note, group, onPick) {
      Object.assign(this, { root, note, group, onPick });
      this.range = group?.shown ?? null;
      this.listening = false;
    }

    // From the first x to the last.
    whole() {
      const { x, charts, log } = this.group;
      let [low, high] = [Infinity, -Infinity];
      for (const along of [x, ...charts.flatMap((chart) => chart.series.map((s) => s.x ?? []))]) {
        for (const v of along) {
          if (log && !(v > 0)) continue;
          low = Math.min(low, v);
          high = Math.max(high, v);
        }
      }
      return low < high ? [low, high] : null;
    }

    // A range of values as plotly's axis has it; a copy, since plotly writes into it.
    onAxis(range) {
      return this.group.log ? range.map(Math.log10) : [...range];
    }

    draw() {
      const { root, group } = this;
      const { charts } = group;
      const gap = 0.3 / Math.max(charts.length, 1) ** 1.4;
      const each = (1 - gap * (charts.length - 1)) / charts.length;
      const whole = this.whole();
      const range = this.range ?? whole;
      this.traces = [];
      this.levels = [];
      const layout = layoutOf({
        hovermode: "x",
        // Points may be far apart: the nearest one is read.
        hoverdistance: -1,
        showlegend: true,
        margin: { l: 70, r: 12, t: group.cumulative ? 10 + 16 * (group.marks?.length ?? 0) : 34, b: 50 },
        title: group.title ? { text: group.title, font: { size: 12 }, x: 0.5, y: 0.99, yanchor: "top" } : undefined,
        xaxis: {
          ...axisStyle(group.xLabel),
          ...(group.log ? logTicks(range) : { type: "linear" }),
          anchor: charts.length > 1 ? `y${charts.length}` : "y",
          ...(range && { range: this.onAxis(range) }),
        },
      });
      charts.forEach((chart, n) => this.addChart(layout, chart, n, 1 - n * (each + gap), each));
      layout.shapes = this.shapes();
      layout.annotations = [...this.names(), ...this.levelNames()];
      const shown = this.sample();
      const traces = this.traces.map(({ trace }, n) => ({ ...trace, ...shown[n] }));
      Plotly.react(root, traces, layout, CONFIG);
      if (!this.listening) {
        this.listening = true;
        root.on("plotly_relayout", (change) => this.zoomed(change));
        root.on("plotly_doubleclick", () => this.show(null));
        root.on("plotly_click", ({ points: [point] }) => this.onPick?.(point.x));
      }
    }

    addChart(layout, chart, n, top, height) {
      const suffix = n === 0 ? "" : String(n + 1);
      const bounds = boundsOf(chart.series);
      const log = chart.log && bounds.positive < Infinity;
      const exponent = log ? 0 : exponentOf(bounds);
      const moderate = unscaled(exponent);
      const label = exponent === 0 ? chart.label : inPowersOfTen(chart.label, exponent);
      layout[`yaxis${suffix}`] = {
        ...axisStyle(label),
        domain: [top - height, top],
        ...(log ? logAxis(bounds) : linearAxis(bounds, exponent)),
      };
      // Names of places stand above the curves.
      const { range } = layout[`yaxis${suffix}`];
      if (this.group.marks?.length && !this.group.cumulative && !log && range) range[1] += 0.08 * (range[1] - range[0]);
      layout[`legend${suffix}`] = {
        ...(this.group.cumulative
          ? this.risesLate(chart)
            ? { x: 0.01, xanchor: "left", y: 0.98, yanchor: "top" }
            : { x: 0.99, xanchor: "right", y: 0.02, yanchor: "bottom" }
          : { orientation: "h", x: 1, xanchor: "right", y: top, yanchor: "bottom" }),
        bgcolor: "rgba(0,0,0,0)",
      };
      const single = chart.series.length === 1;
      chart.series.forEach((series, m) => {
        const { weight } = series;
        const colors = [...CURVE_COLORS, color("--ink")];
        const place = series.color ?? m;
        const round = Math.floor(place / colors.length) % DASHES.length;
        const style = weight === "gap" ? color("--ink")
          : typeof series.shade === "number" ? shadeOf(series.shade)
          : colors[place % colors.length];
        const isQuiet = weight === "thin" || weight === "gap";
        const x = series.x ?? this.group.x;
        const dots = series.look === "dots";
        this.traces.push({
          x,
          dots,
          values: exponent === 0 && !log
            ? series.values
            : Array.from(series.values, (v) => (log && !(v > 0) ? NaN : moderate(v))),
          trace: {
            type: "scatter", name: series.label, showlegend: !single && !isQuiet && series.label !== "",
            mode: dots ? "markers" : x.length <= MARKED_POINTS && series.look !== "dashed" && !weight ? "lines+markers" : "lines",
            yaxis: `y${suffix}`, xaxis: "x", legend: `legend${suffix}`,
            line: { color: style, width: weight === "bold" ? boldWidth(series.shade ?? 1) : WIDTHS[weight] ?? (this.group.cumulative ? 2.5 : 1.5), dash: series.look === "dashed" ? "dash" : DASHES[round] },
            marker: { color: style, size: dots ? 8 : 4, symbol: SYMBOLS[round] },
            ...(series.errors && { error_y: { type: "data", array: Array.from(series.errors, moderate), color: style } }),
            ...(series.band && { fill: "tonexty", fillcolor: "rgba(0,114,178,0.35)", line: { color: style, width: 1 } }),
            connectgaps: false,
            ...(isQuiet
              ? { hoverinfo: "skip" }
              : { hovertemplate: "%{y:.5~g}<extra>" + (single ? "" : series.label) + "</extra>" }),
          },
        });
      });
      for (const [at, label] of chart.levels) {
        if (!log || at > 0) this.levels.push({ at: moderate(at), label, log, yref: `y${suffix}` });
      }
    }

    // Whether a cumulative curve is still low in the right half of the axis, where names would stand.
    risesLate({ series }) {
      const curve = series.find(({ weight }) => weight === "bold");
      const range = this.onAxis(this.range ?? this.whole() ?? [0, 1]);
      const place = range[0] + 0.6 * (range[1] - range[0]);
      const at = this.group.x.findIndex((x) => this.onAxis([x, x])[0] >= place);
      return at >= 0 && curve !== undefined && curve.values[at] < 0.5;
    }

    // Marked levels, named places on x, and the picked value.
    shapes() {
      const { role, marks } = this.group;
      const faint = color("--faint");
      const upright = (at, dash) => ({ ...lineShape("x", at, faint, dash), yref: "paper" });
      const found = role ? picked[role] : undefined;
      return [
        ...this.levels.map(({ at, yref }) => lineShape("y", at, faint, "dash", yref)),
        ...(marks ?? []).map(([at]) => upright(at, "dot")),
        ...(found === undefined ? [] : [upright(found, "solid")]),
      ];
    }

    names() {
      const { marks, cumulative } = this.group;
      // Above the curves, each from its line on, as far left as its end needs.
      if (cumulative) {
        const range = this.onAxis(this.range ?? this.whole() ?? [0, 1]);
        const size = this.root.clientWidth < 520 ? 12 : 14;
        const width = this.root.clientWidth - 82;
        return marks.map(([at, text], n) => {
          const x = this.onAxis([at])[0];
          const left = ((x - range[0]) / (range[1] - range[0])) * width;
          return {
            x, y: 1, yref: "paper", yanchor: "bottom", yshift: 16 * (marks.length - 1 - n),
            xanchor: "left", xshift: Math.min(0, width - left - 0.68 * size * text.length), text, showarrow: false,
            font: { size, weight: "bold", color: color("--ink") },
          };
        });
      }
      const [low, high] = this.onAxis(this.range ?? this.whole() ?? [0, 1]);
      return (marks ?? []).map(([at, text]) => {
        const x = this.onAxis([at])[0];
        return {
          x, y: 1, yref: "paper", yanchor: "top", xanchor: 2 * x > low + high ? "right" : "left", text,
          showarrow: false, font: { size: 12, color: color("--ink") },
        };
      });
    }

    // Names of levels, at the right end of their lines.
    levelNames() {
      return this.levels.filter(({ label }) => label).map(({ at, label, log, yref }) => ({
        x: 1, xref: "paper", xanchor: "right", y: log ? Math.log10(at) : at, yref, yanchor: "bottom", text: label,
        showarrow: false, font: { size: 12, color: color("--ink") },
      }));
    }

    follow() {
      Plotly.relayout(this.root, { shapes: this.shapes() });
    }

    // Shows the middle part, or more, by this factor.
    zoomBy(factor) {
      const whole = this.whole();
      if (!whole) return;
      const [low, high] = this.onAxis(this.range ?? whole);
      const ends = this.onAxis(whole);
      const half = Math.min((high - low) * factor, ends[1] - ends[0]) / 2;
      const middle = Math.min(Math.max((low + high) / 2, ends[0] + half), ends[1] - half);
      this.show([middle - half, middle + half]);
    }

    // A range of the axis, or null for all of it.
    show(range) {
      this.range = range && (this.group.log ? range.map((v) => 10 ** v) : range);
      this.draw();
    }

    sample() {
      const range = this.range ?? this.whole() ?? [-Infinity, Infinity];
      const pixels = this.root.clientWidth - 82;
      const shown = this.traces.map(({ x, values, dots }) =>
        (dots ? { x: Array.from(x), y: Array.from(values), per: 1 } : visible(x, values, ...range, pixels)));
      const per = Math.max(1, ...shown.map((s) => s.per));
      if (this.note) {
        this.note.textContent = (per > 1
          ? `Drawn: least and largest of every ${per} points; zoom in for all of them.`
          : "") + (this.group.note ?? "");
      }
      return shown.map(({ x, y }) => ({ x, y }));
    }

    zoomed(change) {
      const low = change["xaxis.range[0]"] ?? change["xaxis.range"]?.[0];
      const high = change["xaxis.range[1]"] ?? change["xaxis.range"]?.[1];
      if (low === undefined) return;
      this.range = this.group.log ? [10 ** low, 10 ** high] : [low, high];
      const shown = this.sample();
      Plotly.restyle(this.root, { x: shown.map((s) => s.x), y: shown.map((s) => s.y) });
    }

    // One column for x and one for each series on it; a series with its own x brings two.
    csv() {
      const { xLabel, x, charts } = this.group;
      const columns = x.length > 0 ? [[xLabel, x]] : [];
      for (const { label, series } of charts) {
        for (const s of series) {
          if (s.x) columns.push([xLabel, s.x]);
          columns.push([s.label ? `${s.label}: ${label}` : label, s.values]);
          if (s.errors) columns.push([`standard error: ${label}`, s.errors]);
        }
      }
      const rows = [columns.map(([name]) => quoted(name)).join(",")];
      const length = Math.max(0, ...columns.map(([, values]) => values.length));
      for (let n = 0; n < length; n++) {
        rows.push(columns.map(([, values]) => (Number.isFinite(values[n]) ? values[n] : "")).join(","));
      }
      return rows.join("\n") + "\n";
    }
  }

  // ---- Heat maps.

  class MapView {
    constructor(map) {
      // The whole map, and the part that is shown at first, in finer cells.
      this.overview = this.level(map, map);
      this.home = map.detail ? this.level(map, map.detail) : this.overview;
      this.map = this.home;
      // One colour scale holds for both.
      const parts = new Set([this.overview.values, this.home.values]);
      this.values = Float32Array.from([...parts].flatMap((part) => Array.from(part)));
      this.lines = map.lines.map(({ name, x, y }) => ({ name, x: doubles(x), y: doubles(y) }));
      this.root = document.getElementById(map.id);
      this.picture = this.root.querySelector(".picture");
      this.readout = this.root.querySelector(".readout");
      this.log = !map.signed && !map.linear;
      this.along = map.along;
      this.isEmpty = map.rows === 0 || map.columns === 0;
      this.missing = this.map.values.some((v) => !Number.isFinite(v));
      this.curve = new CurvePlot(this.root.querySelector(".curve"), this.root.querySelector(".note"), null);
    }

    // A map with the cells, and the ends, of a part of it (or of all).
    level(map, part) {
      const axis = (name) => (part === map ? map[name] : { ...map[name], low: part[name][0], high: part[name][1] });
      const level = {
        ...map, ...part, x: axis("x"), y: axis("y"),
        values: floats(part.values),
        least: part.least ? floats(part.least) : null,
        largest: part.largest ? floats(part.largest) : null,
      };
      return { ...level, peak: this.findPeak(level) };
    }

    // The finest cells that the page holds of all that is in view.
    choose() {
      const isInside = (axis) => {
        const { low, high } = this.span(axis, this.home);
        const [from, to] = this.range(axis);
        const slack = 1e-6 * (high - low);
        return from >= low - slack && to <= high + slack;
      };
      this.map = isInside("x") && isInside("y") ? this.home : this.overview;
    }

    start() {
      if (coarse.matches) this.readout.textContent = "Tap to read and pick values; the buttons zoom.";
      if (!this.map.values.some(Number.isFinite)) this.readout.textContent = "This picture has no values.";
      this.draw();
      this.listen();
    }

    // The largest cell off marked columns: what is known beforehand, as a reference against itself, is not the answer.
    findPeak({ values, columns: count, x }) {
      const columns = Math.max(count, 1);
      const marked = x.marks.map((at) => Math.floor(((at - x.low) / (x.high - x.low)) * columns));
      let [best, at] = [-1, 0];
      values.forEach((v, n) => {
        if (Math.abs(v) > best && !marked.includes(n % columns)) [best, at] = [Math.abs(v), n];
      });
      return { row: Math.floor(at / columns), column: at % columns };
    }

    span(axis, level = this.map) {
      const { low, high } = level[axis];
      return low < high ? { low, high } : { low: (low ?? 0) - 0.5, high: (low ?? 0) + 0.5 };
    }

    count(axis) {
      return axis === "x" ? this.map.columns : this.map.rows;
    }

    // Cell of a coordinate; outside the map: the nearest one.
    index(axis, value) {
      const { low, high } = this.span(axis);
      const cell = Math.floor(((value - low) / (high - low)) * this.count(axis));
      return Math.min(Math.max(cell, 0), this.count(axis) - 1);
    }

    // Coordinate of a cell's middle.
    coordinate(axis, index) {
      const { low, high } = this.span(axis);
      return low + ((index + 0.5) / this.count(axis)) * (high - low);
    }

    // The same as text, with the digits that separate one cell from the next.
    read(axis, index) {
      const { low, high } = this.span(axis);
      const width = (high - low) / this.count(axis);
      const value = this.coordinate(axis, index);
      const digits = Math.ceil(Math.log10(Math.max(Math.abs(value), width) / width)) + 2;
      return show(value, Math.min(Math.max(digits, 2), 15));
    }

    value(row, column) {
      return this.map.values[row * this.map.columns + column];
    }

    cell() {
      const index = (axis, fallback) => {
        const value = picked[this.map[axis].role];
        return value === undefined ? fallback : this.index(axis, value);
      };
      return { row: index("y", this.map.peak.row), column: index("x", this.map.peak.column) };
    }

    pickCell(row, column) {
      const { rows, columns, x, y } = this.map;
      const clamp = (n, count) => Math.min(Math.max(n, 0), count - 1);
      const [i, j] = [clamp(row, rows), clamp(column, columns)];
      pick({ [x.role]: this.coordinate("x", j), [y.role]: this.coordinate("y", i) });
      this.describe(i, j);
    }

    describe(row, column) {
      const { x, y, label } = this.map;
      this.readout.textContent =
        `${x.label} = ${this.read("x", column)}, ${y.label} = ${this.read("y", row)}: ` +
        `${label} = ${show(this.value(row, column))}`;
    }

    // Cells of an axis that are in view, and how many of them a pixel would hold.
    inView(axis) {
      const pixels = axis === "x" ? this.picture.clientWidth - 170 : this.picture.clientHeight - 90;
      const [low, high] = this.range(axis);
      const first = this.index(axis, low);
      const end = Math.min(this.index(axis, high) + 1, this.count(axis));
      return { first, end, per: Math.max(1, Math.ceil((end - first) / Math.max(pixels, 100))) };
    }

    // Cell of largest magnitude among those drawn as one.
    strongest(row, column) {
      const { columns, values } = this.map;
      let best = row * columns + column;
      for (let i = row; i < Math.min(row + this.view.y.per, this.view.y.end); i++) {
        for (let j = column; j < Math.min(column + this.view.x.per, this.view.x.end); j++) {
          const v = values[i * columns + j];
          if (!(Math.abs(values[best]) >= Math.abs(v)) && Number.isFinite(v)) best = i * columns + j;
        }
      }
      return [Math.floor(best / columns), best % columns];
    }

    // Of cells drawn as one that hold both signs, the larger magnitude, else null. By their extremes
    // alone, fast oscillations would show waves that are not there.
    bothSigns(row, column) {
      const { columns, values, least, largest } = this.map;
      let [low, high] = [Infinity, -Infinity];
      for (let i = row; i < Math.min(row + this.view.y.per, this.view.y.end); i++) {
        for (let j = column; j < Math.min(column + this.view.x.per, this.view.x.end); j++) {
          low = Math.min(low, (least ?? values)[i * columns + j]);
          high = Math.max(high, (largest ?? values)[i * columns + j]);
        }
      }
      const size = Math.max(-low, high);
      return Math.min(-low, high) > BOTH_SIGNS * size ? size : null;
    }

    // What is in view, a value a pixel at most, and where its first cell is.
    heat(scale) {
      const { rows, columns, values } = this.map;
      this.view = rows * columns > 0
        ? { x: this.inView("x"), y: this.inView("y") }
        : { x: { first: 0, end: 0, per: 1 }, y: { first: 0, end: 0, per: 1 } };
      const { x, y } = this.view;
      const starts = ({ first, end, per }) => Array.from({ length: Math.ceil((end - first) / per) }, (_, n) => first + n * per);
      const single = x.per * y.per === 1;
      const z = starts(y).map((row) => starts(x).map((column) => {
        const [i, j] = single ? [row, column] : this.strongest(row, column);
        const v = values[i * columns + j];
        const size = this.map.signed ? this.bothSigns(row, column) : null;
        if (size !== null && isNearZero(scale, size)) return scale.place(0);
        return Number.isFinite(v) ? Math.min(Math.max(scale.place(v), 0), 1) : null;
      }));
      const along = (axis, count) => {
        const { low, high } = this.span(axis);
        const { first, per } = this.view[axis];
        const width = (high - low) / Math.max(count, 1);
        return { [`${axis}0`]: low + (first + per / 2) * width, [`d${axis}`]: per * width };
      };
      const grey = this.map.signed ? starts(y).map((row) => starts(x).map((column) => {
        const size = this.bothSigns(row, column);
        return size === null || isNearZero(scale, size) ? null : Math.min(2 * scale.place(size) - 1, 1);
      })) : [];
      const place = { ...along("x", columns), ...along("y", rows) };
      return [{ z, ...place }, { z: grey, ...place }];
    }

    draw() {
      this.choose();
      const { signed, label, x, y } = this.map;
      const palette = signed ? palettes.diverging : palettes.sequential;
      const scale = scaleOf(this.values, this.map, this.log);
      const narrow = this.picture.clientWidth < 520;
      // The label of the lower end, which is long, stays clear of the next.
      const clear = narrow ? 0.25 : 0.05;
      const ticks = scale.ticks.filter((v) => scale.lowest === null || scale.place(v) > clear);
      const tickvals = ticks.map(scale.place);
      const ticktext = ticks.map(scale.show);
      if (scale.lowest !== null) {
        tickvals.push(0);
        ticktext.push(`≤ ${show(scale.lowest, 2)}`);
      }
      const [colored, grey] = this.heat(scale);
      const trace = {
        type: "heatmap", ...colored, zmin: 0, zmax: 1, zsmooth: false, hoverinfo: "none",
        colorscale: colorscale(palette),
        colorbar: {
          title: { text: label + scale.label, side: narrow ? "bottom" : "right", font: { size: label.length > 50 ? 10 : 12 } },
          tickvals, ticktext, thickness: 14, outlinewidth: 1, outlinecolor: color("--faint"), ticks: "outside",
          ...(narrow ? { orientation: "h", y: -0.2, yanchor: "top" } : { len: 1 }),
        },
      };
      const layout = layoutOf({
        hovermode: "closest",
        plot_bgcolor: this.missing ? rgb(palettes.sequential, NO_VALUE) : color("--panel"),
        margin: { l: 70, r: 12, t: 20, b: 50 },
        xaxis: this.axis("x"),
        yaxis: this.axis("y"),
        shapes: this.shapes(),
      });
      layout.xaxis.showgrid = layout.yaxis.showgrid = false;
      layout.xaxis.zeroline = layout.yaxis.zeroline = false;
      const traces = [trace];
      if (grey.z.flat().some((v) => v !== null)) {
        traces.push({
          type: "heatmap", ...grey, zmin: 0, zmax: 1, zsmooth: false, hoverinfo: "skip", showscale: false,
          colorscale: [[0, "rgb(247,247,247)"], [1, "rgb(64,64,64)"]],
        });
      }
      traces.push(...this.overlay());
      for (const [name, other] of [["x", x.second], ["y", y.second]]) {
        if (!other) continue;
        layout[`${name}axis2`] = {
          ...this.axis(name), title: { text: other[0], standoff: 4 }, overlaying: name,
          side: name === "x" ? "top" : "right", range: this.range(name).map((v) => v * other[1]),
          showgrid: false, zeroline: false, fixedrange: true,
        };
        layout.margin[name === "x" ? "t" : "r"] = 60;
        traces.push({ type: "scatter", x: [null], y: [null], xaxis: name === "x" ? "x2" : "x", yaxis: name === "y" ? "y2" : "y", showlegend: false, hoverinfo: "skip" });
      }
      Plotly.react(this.picture, traces, layout, CONFIG);
      this.press();
      this.drawCurve();
    }

    // Lines over the map: bright dashes with a dark edge, one colour a name.
    overlay() {
      const { lines } = this;
      const names = [...new Set(lines.map((line) => line.name))];
      return lines.flatMap(({ name, x, y }) => {
        const gaps = Array.from(y, (v) => (Number.isFinite(v) ? v : null));
        const bright = LINE_COLORS[names.indexOf(name) % LINE_COLORS.length];
        return [["#222222", 3.5], [bright, 1.5]].map(([color, width]) => ({
          type: "scatter", mode: "lines", name, x: Array.from(x), y: gaps, showlegend: false, hoverinfo: "skip",
          line: { color, width, dash: "8px,6px" },
        }));
      });
    }

    range(axis) {
      if (this.zoom?.[axis]) return this.zoom[axis];
      const { low, high } = this.span(axis, this.home);
      return [low, high];
    }

    axis(name) {
      const { low, high } = this.span(name, this.overview);
      return { ...axisStyle(this.map[name].label), range: this.range(name), minallowed: low, maxallowed: high };
    }

    // Band edges, the line k = 0, and the picked cell.
    shapes() {
      const bright = this.map.signed ? "#222222" : "#ffffff";
      const shapes = [];
      for (const axis of ["x", "y"]) {
        const { marks, low, role } = this.map[axis];
        for (const mark of marks) {
          shapes.push(lineShape(axis, mark, bright, "dash"));
          if (role === "wavenumber" && low < 0) shapes.push(lineShape(axis, -mark, bright, "dash"));
        }
        if (role === "wavenumber" && low < 0) shapes.push(lineShape(axis, 0, bright, "dot"));
      }
      if (!this.isEmpty) {
        const { row, column } = this.cell();
        for (const [style, dash] of [["#000000", "solid"], ["#ffffff", "dash"]]) {
          shapes.push(lineShape("x", this.coordinate("x", column), style, dash));
          shapes.push(lineShape("y", this.coordinate("y", row), style, dash));
        }
      }
      return shapes;
    }

    press() {
      for (const button of this.root.querySelectorAll("[data-scale]")) {
        button.setAttribute("aria-pressed", String((button.dataset.scale === "log") === this.log));
      }
      for (const button of this.root.querySelectorAll("[data-along]")) {
        button.setAttribute("aria-pressed", String(button.dataset.along === this.along));
      }
    }

    follow() {
      Plotly.relayout(this.picture, { shapes: this.shapes() });
      this.press();
      this.drawCurve();
    }

    drawCurve() {
      if (this.isEmpty) return;
      const { x, y, label, signed, least, largest, columns, block, interval } = this.map;
      const { row, column } = this.cell();
      const upwards = this.along === "y";
      const length = this.count(this.along);
      const cut = (values) => Float64Array.from({ length }, (_, n) =>
        values[upwards ? n * columns + column : row * columns + n]);
      const fixed = upwards ? x : y;
      const at = upwards ? this.read("x", column) : this.read("y", row);
      const series = least
        ? [{ label: "least", values: cut(least), color: 0 }, { label: "largest", values: cut(largest), color: 0, band: true }]
        : [{ label: "value", values: cut(this.map.values) }];
      if (interval && upwards && !signed) {
        const value = series[series.length - 1].values;
        const ends = interval.map((factor) => value.map((v) => factor * v));
        series.push(
          { label: "95 % interval, lower end", values: ends[0], color: 5 },
          { label: "upper end", values: ends[1], color: 5, band: true },
        );
      }
      const { group } = this.curve;
      if (group && (group.along !== this.along || group.map !== this.map)) this.curve.range = null;
      this.curve.group = {
        title: `at ${fixed.label} = ${at}`,
        xLabel: (upwards ? y : x).label,
        x: Float64Array.from({ length }, (_, n) => this.coordinate(this.along, n)),
        charts: [{ label, log: this.log && !signed, levels: [], series }],
        note: block ? ` ${block}` : "",
        along: this.along,
        map: this.map,
      };
      this.curve.draw();
    }

    listen() {
      const { picture, map } = this;
      picture.on("plotly_hover", ({ points: [point] }) => {
        if (point.curveNumber === 0) this.describe(...this.cellOf(point));
      });
      picture.on("plotly_click", ({ points: [point] }) => {
        if (point.curveNumber === 0) this.pickCell(...this.cellOf(point));
      });
      picture.on("plotly_relayout", (change) => {
        if (!Object.keys(change).some((key) => key.includes("axis"))) return;
        const range = (name) => picture.layout[`${name}axis`].range.map(Number);
        this.zoom = { x: range("x"), y: range("y") };
        this.draw();
      });
      picture.on("plotly_doubleclick", () => this.reset());
      picture.addEventListener("keydown", (event) => this.key(event));
      const on = (mark, act) => {
        for (const button of this.root.querySelectorAll(mark)) {
          button.addEventListener("click", () => act(button));
        }
      };
      on("[data-reset]", () => this.showWhole());
      on("[data-home]", () => this.reset());
      on("[data-zoom]", (button) => this.zoomBy(Number(button.dataset.zoom)));
      on("[data-scale]", (button) => {
        this.log = button.dataset.scale === "log";
        this.draw();
      });
      on("[data-along]", (button) => {
        this.along = button.dataset.along;
        this.press();
        this.drawCurve();
      });
      on("[data-png]", () => savePng(picture, map.id));
      on("[data-csv]", () => save(`${map.id}.csv`, this.csv(), "text/csv"));
    }

    cellOf(point) {
      const { x, y } = this.view;
      const start = ({ first, per }, index) => first + per * Math.floor((index - first) / per);
      return this.strongest(start(y, this.index("y", point.y)), start(x, this.index("x", point.x)));
    }

    reset() {
      this.zoom = null;
      this.draw();
    }

    showWhole() {
      const all = (axis) => {
        const { low, high } = this.span(axis, this.overview);
        return [low, high];
      };
      this.zoom = { x: all("x"), y: all("y") };
      this.draw();
    }

    // Shrinks (or grows) the visible part about the picked cell.
    zoomBy(factor) {
      const { row, column } = this.cell();
      const range = (axis, index) => {
        const all = this.span(axis, this.overview);
        const now = this.range(axis);
        const middle = this.coordinate(axis, index);
        const half = Math.min((now[1] - now[0]) * factor, all.high - all.low) / 2;
        const low = Math.min(Math.max(middle - half, all.low), all.high - 2 * half);
        return [low, low + 2 * half];
      };
      this.zoom = { x: range("x", column), y: range("y", row) };
      this.draw();
    }

    key(event) {
      if (this.isEmpty || event.ctrlKey || event.metaKey || event.altKey) return;
      const { row, column } = this.cell();
      const step = event.shiftKey ? 10 : 1;
      const actions = {
        ArrowLeft: () => this.pickCell(row, column - step),
        ArrowRight: () => this.pickCell(row, column + step),
        ArrowUp: () => this.pickCell(row + step, column),
        ArrowDown: () => this.pickCell(row - step, column),
        "+": () => this.zoomBy(0.5),
        "-": () => this.zoomBy(2),
        0: () => this.reset(),
      };
      const action = actions[event.key];
      if (!action) return;
      event.preventDefault();
      action();
    }

    // The cells in view.
    csv() {
      const { x, y } = this.map;
      const [across, up] = [this.view.x, this.view.y];
      const columns = Array.from({ length: across.end - across.first }, (_, n) => across.first + n);
      const head = columns.map((n) => this.coordinate("x", n));
      const lines = [[quoted(`${y.label} \\ ${x.label}`), ...head].join(",")];
      for (let row = up.first; row < up.end; row++) {
        const cells = columns.map((n) => {
          const value = this.value(row, n);
          return Number.isFinite(value) ? value : "";
        });
        lines.push([this.coordinate("y", row), ...cells].join(","));
      }
      return lines.join("\n") + "\n";
    }
  }

  // ---- Groups of curves along one axis.

  class CurveView {
    constructor(group) {
      this.root = document.getElementById(group.id);
      const charts = group.charts.map((chart) => ({
        ...chart,
        series: chart.series.map((s) => ({
          ...s, values: doubles(s.values), x: s.x && doubles(s.x), errors: s.errors && doubles(s.errors),
        })),
      }));
      this.plot = new CurvePlot(this.root.querySelector(".curve"), this.root.querySelector(".note"), {
        ...group, xLabel: group.label, x: doubles(group.x), charts, title: null,
      }, group.role && ((x) => pick({ [group.role]: x })));
      if (!group.cumulative) {
        this.plot.root.style.height = `${charts.length > 1 ? 90 + 200 * charts.length : 400}px`;
      }
    }

    start() {
      const { plot, root } = this;
      const { id } = root;
      plot.draw();
      root.querySelector("[data-reset]").addEventListener("click", () => plot.show(null));
      root.querySelector("[data-home]")?.addEventListener("click", () => plot.show(plot.group.shown));
      for (const button of root.querySelectorAll("[data-zoom]")) {
        button.addEventListener("click", () => plot.zoomBy(Number(button.dataset.zoom)));
      }
      root.querySelector("[data-png]").addEventListener("click", () => savePng(plot.root, id));
      root.querySelector("[data-csv]").addEventListener("click", () =>
        save(`${id}.csv`, plot.csv(), "text/csv"));
    }

    draw() {
      this.plot.draw();
    }

    follow() {
      this.plot.follow();
    }
  }

  // ---- Pictures are drawn once they come near the window: the first at once.

  views.push(...data.pictures.map((picture) =>
    (picture.kind === "map" ? new MapView(picture) : new CurveView(picture))));

  const waiting = new Map(views.map((view) => [view.root, view]));
  const viewOf = new Map(waiting);
  const start = (root) => {
    const view = waiting.get(root);
    waiting.delete(root);
    view?.start();
  };
  const come = (root) => {
    near.add(root);
    start(root);
    if (behind.delete(viewOf.get(root))) viewOf.get(root).follow();
  };
  const observer = new IntersectionObserver((entries) => {
    for (const { isIntersecting, target } of entries) {
      if (isIntersecting) come(target);
      else near.delete(target);
    }
  }, { rootMargin: "600px" });
  if (views.length > 0) start(views[0].root);
  for (const root of viewOf.keys()) observer.observe(root);
  window.addEventListener("beforeprint", () => [...waiting.keys()].forEach(start));

  const started = () => views.filter((view) => !waiting.has(view.root));
  const redraw = () => started().forEach((view) => view.draw());
  for (const query of ["(prefers-color-scheme: dark)", "print"]) {
    window.matchMedia(query).addEventListener("change", redraw);
  }
  let width = document.body.clientWidth;
  new ResizeObserver(() => {
    if (document.body.clientWidth === width) return;
    width = document.body.clientWidth;
    requestAnimationFrame(redraw);
  }).observe(document.body);
  document.documentElement.dataset.ready = "true";
})();
