"use strict";
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);

  const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const floats = (text) => new Float32Array(bytes(text).buffer);
  const doubles = (text) => new Float64Array(bytes(text).buffer);
  const color = (name) =>
    getComputedStyle(document.documentElement).getPropertyValue(name).trim();

  const CURVE_COLORS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7"];
  const FONT = '"DejaVu Sans", system-ui, sans-serif';
  // Share of the largest magnitude below which a signed log scale is linear.
  const LINEAR_SHARE = 1e-4;
  // Decades that a logarithmic axis of curves spans at most.
  const DECADES = 16;
  // Pixels a sample needs to be drawn by itself.
  const SAMPLE_PIXELS = 0.5;
  const NO_VALUE = 255;
  const CONFIG = { displayModeBar: false, responsive: true, doubleClick: "reset" };

  const palettes = { sequential: bytes(data.sequential), diverging: bytes(data.diverging) };
  const rgb = (palette, level) => `rgb(${palette.subarray(3 * level, 3 * level + 3).join(",")})`;
  const colorscale = (palette) =>
    Array.from({ length: 255 }, (_, level) => [level / 254, rgb(palette, level)]);

  const SUPERSCRIPTS = { "-": "⁻", 0: "⁰", 1: "¹", 2: "²", 3: "³", 4: "⁴", 5: "⁵", 6: "⁶", 7: "⁷", 8: "⁸", 9: "⁹" };
  const power = (n) => `10${String(n).replace(/./g, (c) => SUPERSCRIPTS[c])}`;
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

  function scaleOf(values, signed, log) {
    let [least, most, smaller] = [Infinity, 0, false];
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
    if (signed) return log ? signedLogScale(most) : linearScale(-most, most);
    if (!log) return linearScale(0, most);
    const low = Math.min(Math.max(least, most * 10 ** -data.decades), most / 10);
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
    minexponent: 3,
    tickfont: { size: 11 },
    automargin: true,
  });

  const layoutOf = (changes) => ({
    paper_bgcolor: "rgba(0,0,0,0)",
    plot_bgcolor: "rgba(0,0,0,0)",
    font: { family: FONT, size: 12, color: color("--ink") },
    margin: { l: 70, r: 12, t: 30, b: 50 },
    dragmode: "zoom",
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
    for (const view of started()) view.follow();
  };

  // ---- Curves: samples where they fit, else the least and the largest of each pixel.

  // Samples of `series` with x in [low, high], thinned to `pixels`.
  function visible(x, series, low, high, pixels) {
    let [first, end] = [0, x.length];
    while (first + 1 < end && x[first + 1] < low) first++;
    while (end - 1 > first && x[end - 2] > high) end--;
    const count = end - first;
    const per = Math.ceil(count * SAMPLE_PIXELS / Math.max(pixels, 100));
    if (per <= 1) {
      return {
        x: Array.from(x.slice(first, end)),
        y: series.map((values) => Array.from(values.slice(first, end), (v) => (Number.isFinite(v) ? v : null))),
        per,
      };
    }
    // Two points a block: its extremes at a quarter and at three quarters, in their order.
    const xs = [];
    const ys = series.map(() => []);
    const block = 2 * per;
    for (let start = first; start < end; start += block) {
      const stop = Math.min(start + block, end);
      xs.push(x[start + ((stop - start) >> 2)], x[start + ((3 * (stop - start)) >> 2)]);
      series.forEach((values, n) => {
        let [least, most] = [-1, -1];
        for (let i = start; i < stop; i++) {
          if (!Number.isFinite(values[i])) continue;
          if (least < 0 || values[i] < values[least]) least = i;
          if (most < 0 || values[i] > values[most]) most = i;
        }
        if (least < 0) ys[n].push(null, null);
        else ys[n].push(values[Math.min(least, most)], values[Math.max(least, most)]);
      });
    }
    return { x: xs, y: ys, per: block };
  }

  // Least, largest and least positive value of series.
  function boundsOf(series) {
    const bounds = { low: Infinity, high: -Infinity, positive: Infinity };
    for (const { values } of series) {
      for (const v of values) {
        if (!Number.isFinite(v)) continue;
        bounds.low = Math.min(bounds.low, v);
        bounds.high = Math.max(bounds.high, v);
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

  // Whole decades, at least one, at most DECADES; at most eight are labelled.
  function logAxis({ high, positive }) {
    const top = Math.ceil(Math.log10(high) + 1e-9);
    const bottom = Math.max(Math.floor(Math.log10(positive) - 1e-9), top - DECADES);
    return { type: "log", range: [bottom, top], dtick: Math.ceil((top - bottom) / 8) };
  }

  // From 0, unless the values vary little; constant ones stay clear of the frame.
  function linearAxis({ low, high }, exponent) {
    if (low === Infinity) return {};
    const [a, b] = [10 ** Math.trunc(-exponent / 2), 10 ** (-exponent - Math.trunc(-exponent / 2))];
    const [from, to] = [Math.min(low * a * b, 0), Math.max(high * a * b, 0)];
    const margin = 0.04 * (to - from || 1);
    return { range: [from < 0 ? from - margin : from, to > 0 || from === to ? to + margin : to] };
  }

  class CurvePlot {
    // group: { name, xLabel, x, mark, charts: [{ label, log, mark, series: [{ label, values, band }] }] }
    constructor(root, note, group, onPick) {
      Object.assign(this, { root, note, group, onPick });
      this.range = null;
      this.listening = false;
    }

    draw() {
      const { root, group } = this;
      const { charts, x } = group;
      const gap = 0.3 / Math.max(charts.length, 1) ** 1.4;
      const each = (1 - gap * (charts.length - 1)) / charts.length;
      const points = x.length < 3 ? "lines+markers" : "lines";
      this.traces = [];
      const layout = layoutOf({
        hovermode: "x",
        showlegend: true,
        shapes: [],
        margin: { l: 70, r: 12, t: 34, b: 50 },
        title: group.title ? { text: group.title, font: { size: 12 }, x: 0.5, y: 0.99, yanchor: "top" } : undefined,
        xaxis: {
          ...axisStyle(group.xLabel),
          anchor: charts.length > 1 ? `y${charts.length}` : "y",
          ...(this.range ? { range: this.range } : x.length > 1 ? { range: [x[0], x[x.length - 1]] } : {}),
        },
      });
      charts.forEach((chart, n) => {
        const suffix = n === 0 ? "" : String(n + 1);
        const top = 1 - n * (each + gap);
        const bounds = boundsOf(chart.series);
        const log = chart.log && bounds.positive < Infinity;
        const exponent = log ? 0 : exponentOf(bounds);
        const label = exponent === 0 ? chart.label : `${chart.label} / ${power(exponent)}`;
        layout[`yaxis${suffix}`] = {
          ...axisStyle(label),
          domain: [top - each, top],
          ...(log ? logAxis(bounds) : linearAxis(bounds, exponent)),
        };
        layout[`legend${suffix}`] = {
          orientation: "h", x: 1, xanchor: "right", y: top, yanchor: "bottom",
          bgcolor: "rgba(0,0,0,0)",
        };
        const single = chart.series.length === 1;
        chart.series.forEach((series, m) => {
          // In two steps, since 10^-exponent may be out of range.
          const [a, b] = [10 ** Math.trunc(-exponent / 2), 10 ** (-exponent - Math.trunc(-exponent / 2))];
          const values = exponent === 0 && !log
            ? series.values
            : Array.from(series.values, (v) => (log && !(v > 0) ? NaN : v * a * b));
          this.traces.push({
            values,
            trace: {
              type: "scatter", mode: points, name: series.label, showlegend: !single,
              yaxis: `y${suffix}`, xaxis: "x", legend: `legend${suffix}`,
              line: { color: CURVE_COLORS[m], width: 1.5 }, connectgaps: false,
              ...(series.band && { fill: "tonexty", fillcolor: "rgba(0,114,178,0.35)", line: { color: CURVE_COLORS[0], width: 1 } }),
              hovertemplate: "%{y:.5~g}<extra>" + (single ? "" : series.label) + "</extra>",
            },
          });
        });
        if (chart.mark !== null && chart.mark !== undefined) {
          layout.shapes.push(lineShape("y", chart.mark * 10 ** -exponent, color("--faint"), "dash", `y${suffix}`));
        }
      });
      const found = this.picked();
      if (found !== undefined) layout.shapes.push(lineShape("x", found, color("--faint"), "solid"));
      for (const shape of layout.shapes) if (shape.xref === "x" && shape.yref === "y domain") shape.yref = "paper";
      const shown = this.sample();
      Plotly.react(root, this.traces.map(({ trace }, n) => ({ ...trace, x: shown.x, y: shown.y[n] })), layout, CONFIG);
      if (!this.listening) {
        this.listening = true;
        root.on("plotly_relayout", (change) => this.zoomed(change));
        root.on("plotly_click", ({ points: [point] }) => this.onPick?.(point.x));
      }
    }

    picked() {
      return this.group.role === undefined ? undefined : picked[this.group.role];
    }

    sample() {
      const { x } = this.group;
      const [low, high] = this.range ?? [x[0], x[x.length - 1]];
      const shown = visible(x, this.traces.map((t) => t.values), low, high, this.root.clientWidth - 82);
      if (this.note) {
        this.note.textContent = (shown.per > 1
          ? `Drawn: least and largest of every ${shown.per} points; zoom in for all of them.`
          : "Drawn: every point.") + (this.group.note ?? "");
      }
      return shown;
    }

    zoomed(change) {
      const low = change["xaxis.range[0]"] ?? change["xaxis.range"]?.[0];
      const high = change["xaxis.range[1]"] ?? change["xaxis.range"]?.[1];
      if (low === undefined && !change["xaxis.autorange"]) return;
      this.range = low === undefined ? null : [low, high];
      const shown = this.sample();
      Plotly.restyle(this.root, { x: this.traces.map(() => shown.x), y: shown.y });
    }

    csv() {
      const { xLabel, x, charts } = this.group;
      const series = charts.flatMap((chart) =>
        chart.series.map((s) => ({ name: s.label ? `${s.label}: ${chart.label}` : chart.label, values: s.values })));
      const rows = [[xLabel, ...series.map((s) => s.name)].map(quoted).join(",")];
      for (let n = 0; n < x.length; n++) {
        rows.push([x[n], ...series.map((s) => (Number.isFinite(s.values[n]) ? s.values[n] : ""))].join(","));
      }
      return rows.join("\n") + "\n";
    }
  }

  // ---- Heat maps.

  class MapView {
    constructor(map) {
      this.map = {
        ...map,
        values: floats(map.values),
        least: map.least ? floats(map.least) : null,
        largest: map.largest ? floats(map.largest) : null,
      };
      this.root = document.getElementById(map.id);
      this.picture = this.root.querySelector(".picture");
      this.readout = this.root.querySelector(".readout");
      this.log = !map.signed;
      this.along = map.along;
      this.isEmpty = map.rows === 0 || map.columns === 0;
      this.missing = this.map.values.some((v) => !Number.isFinite(v));
      this.peak = this.findPeak();
      this.curve = new CurvePlot(this.root.querySelector(".curve"), this.root.querySelector(".note"), null);
    }

    start() {
      if (!this.map.values.some(Number.isFinite)) this.readout.textContent = "This picture has no values.";
      this.draw();
      this.listen();
    }

    findPeak() {
      let [best, at] = [-1, 0];
      this.map.values.forEach((v, n) => {
        if (Math.abs(v) > best) [best, at] = [Math.abs(v), n];
      });
      const columns = Math.max(this.map.columns, 1);
      return { row: Math.floor(at / columns), column: at % columns };
    }

    span(axis) {
      const { low, high } = this.map[axis];
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
      return { row: index("y", this.peak.row), column: index("x", this.peak.column) };
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

    draw() {
      const { rows, columns, values, signed, label, x, y } = this.map;
      const palette = signed ? palettes.diverging : palettes.sequential;
      const scale = scaleOf(values, signed, this.log);
      const z = Array.from({ length: rows }, (_, row) =>
        Array.from(values.subarray(row * columns, (row + 1) * columns), (v) =>
          (Number.isFinite(v) ? Math.min(Math.max(scale.place(v), 0), 1) : null)));
      const narrow = this.picture.clientWidth < 520;
      const ticks = scale.ticks.filter((v) => scale.lowest === null || scale.place(v) > 0.05);
      const tickvals = ticks.map(scale.place);
      const ticktext = ticks.map(scale.show);
      if (scale.lowest !== null) {
        tickvals.push(0);
        ticktext.push(`≤ ${show(scale.lowest, 2)}`);
      }
      const trace = {
        type: "heatmap", z, zmin: 0, zmax: 1, zsmooth: false, hoverinfo: "none",
        x0: this.coordinate("x", 0), dx: (this.span("x").high - this.span("x").low) / Math.max(columns, 1),
        y0: this.coordinate("y", 0), dy: (this.span("y").high - this.span("y").low) / Math.max(rows, 1),
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
      for (const [name, other] of [["x", x.second], ["y", y.second]]) {
        if (!other) continue;
        layout[`${name}axis2`] = {
          ...this.axis(name), title: { text: other[0], standoff: 4 }, overlaying: name,
          side: name === "x" ? "top" : "right", range: this.range(name).map((v) => v * other[1]),
          showgrid: false, zeroline: false,
        };
        layout.margin[name === "x" ? "t" : "r"] = 60;
        traces.push({ type: "scatter", x: [null], y: [null], xaxis: name === "x" ? "x2" : "x", yaxis: name === "y" ? "y2" : "y", showlegend: false, hoverinfo: "skip" });
      }
      Plotly.react(this.picture, traces, layout, CONFIG);
      this.press();
      this.drawCurve();
    }

    range(axis) {
      if (this.zoom?.[axis]) return this.zoom[axis];
      const { low, high } = this.span(axis);
      return [low, high];
    }

    axis(name) {
      const { low, high } = this.span(name);
      return { ...axisStyle(this.map[name].label), range: this.range(name), minallowed: low, maxallowed: high };
    }

    // Band edges, the line k = 0, and the picked cell.
    shapes() {
      const bright = this.map.signed ? "#222222" : "#ffffff";
      const shapes = [];
      for (const axis of ["x", "y"]) {
        const { mark, low, role } = this.map[axis];
        if (mark !== null) shapes.push(lineShape(axis, mark, bright, "dash"));
        if (mark !== null && low < 0) shapes.push(lineShape(axis, -mark, bright, "dash"));
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
      const { x, y, label, signed, least, largest, columns, block } = this.map;
      const { row, column } = this.cell();
      const upwards = this.along === "y";
      const length = this.count(this.along);
      const cut = (values) => Float64Array.from({ length }, (_, n) =>
        values[upwards ? n * columns + column : row * columns + n]);
      const fixed = upwards ? x : y;
      const at = upwards ? this.read("x", column) : this.read("y", row);
      const series = least
        ? [{ label: "least", values: cut(least) }, { label: "largest", values: cut(largest), band: true }]
        : [{ label: "value", values: cut(this.map.values) }];
      if (this.curve.group && this.curve.group.along !== this.along) this.curve.range = null;
      this.curve.group = {
        title: `at ${fixed.label} = ${at}`,
        xLabel: (upwards ? y : x).label,
        x: Float64Array.from({ length }, (_, n) => this.coordinate(this.along, n)),
        charts: [{ label, log: this.log && !signed, mark: null, series }],
        note: block ? ` ${block}` : "",
        along: this.along,
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
        const seconds = {};
        for (const name of ["x", "y"]) {
          const { second } = map[name];
          if (second && !Object.keys(change).some((key) => key.startsWith(`${name}axis2`))) {
            seconds[`${name}axis2.range`] = this.zoom[name].map((v) => v * second[1]);
          }
        }
        if (Object.keys(seconds).length > 0) Plotly.relayout(picture, seconds);
      });
      picture.addEventListener("keydown", (event) => this.key(event));
      const on = (mark, act) => {
        for (const button of this.root.querySelectorAll(mark)) {
          button.addEventListener("click", () => act(button));
        }
      };
      on("[data-reset]", () => this.reset());
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
      return [this.index("y", point.y), this.index("x", point.x)];
    }

    zoomTo(x, y) {
      Plotly.relayout(this.picture, { "xaxis.range": x, "yaxis.range": y });
    }

    reset() {
      this.zoom = null;
      this.zoomTo(this.range("x"), this.range("y"));
      this.zoom = null;
    }

    // Shrinks (or grows) the visible part about the picked cell.
    zoomBy(factor) {
      const { row, column } = this.cell();
      const range = (axis, index) => {
        const all = this.span(axis);
        const now = this.range(axis);
        const middle = this.coordinate(axis, index);
        const half = Math.min((now[1] - now[0]) * factor, all.high - all.low) / 2;
        const low = Math.min(Math.max(middle - half, all.low), all.high - 2 * half);
        return [low, low + 2 * half];
      };
      this.zoomTo(range("x", column), range("y", row));
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

    csv() {
      const { rows, columns, x, y } = this.map;
      const head = Array.from({ length: columns }, (_, n) => this.coordinate("x", n));
      const lines = [[quoted(`${y.label} \\ ${x.label}`), ...head].join(",")];
      for (let row = 0; row < rows; row++) {
        const cells = Array.from({ length: columns }, (_, n) => {
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
        series: chart.series.map((s) => ({ ...s, values: doubles(s.values) })),
      }));
      this.plot = new CurvePlot(this.root.querySelector(".curve"), this.root.querySelector(".note"), {
        xLabel: group.label, x: doubles(group.x), role: group.role, charts, note: group.note,
      }, (x) => pick({ [group.role]: x }));
      this.plot.root.style.height = `${90 + 200 * charts.length}px`;
    }

    start() {
      const { plot, root } = this;
      const { id } = root;
      plot.draw();
      root.querySelector("[data-png]").addEventListener("click", () => savePng(plot.root, id));
      root.querySelector("[data-csv]").addEventListener("click", () =>
        save(`${id}.csv`, plot.csv(), "text/csv"));
    }

    draw() {
      this.plot.draw();
    }

    follow() {
      this.plot.draw();
    }
  }

  // ---- Pictures are drawn once they come near the window: the first at once.

  views.push(...data.maps.map((map) => new MapView(map)));
  views.push(...data.curves.map((group) => new CurveView(group)));

  const waiting = new Map(views.map((view) => [view.root, view]));
  const start = (root) => {
    const view = waiting.get(root);
    if (!view) return;
    waiting.delete(root);
    observer.unobserve(root);
    view.start();
  };
  const observer = new IntersectionObserver((entries) => {
    for (const { isIntersecting, target } of entries) if (isIntersecting) start(target);
  }, { rootMargin: "600px" });
  if (views.length > 0) start(views[0].root);
  for (const root of waiting.keys()) observer.observe(root);
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
