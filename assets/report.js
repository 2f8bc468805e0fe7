"use strict";
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);

  const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const floats = (text) => new Float32Array(bytes(text).buffer);
  const doubles = (text) => new Float64Array(bytes(text).buffer);
  const color = (name) =>
    getComputedStyle(document.documentElement).getPropertyValue(name).trim();

  const palettes = { sequential: bytes(data.sequential), diverging: bytes(data.diverging) };
  const NO_VALUE = 255;
  const CURVE_COLORS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7"];
  const FONT = '13px "DejaVu Sans", system-ui, sans-serif';

  // Share of the largest magnitude below which a signed log scale is linear.
  const LINEAR_SHARE = 1e-4;

  function show(value) {
    if (!Number.isFinite(value)) return "no value";
    const size = Math.abs(value);
    if (size !== 0 && (size < 1e-3 || size >= 1e6)) return value.toExponential(3);
    return String(Number(value.toPrecision(6)));
  }

  // A coordinate: every digit that counts, in the shorter notation.
  function showAt(value) {
    const rounded = Number(value.toPrecision(12));
    const [plain, raised] = [String(rounded), rounded.toExponential()];
    return plain.length <= 6 || plain.length <= raised.length ? plain : raised;
  }

  function roundTicks(low, high, count) {
    const rough = (high - low) / Math.max(count, 1);
    const power = 10 ** Math.floor(Math.log10(rough));
    const step = power * [1, 2, 5, 10].find((m) => m * power >= rough * (1 - 1e-9));
    const ticks = [];
    for (let n = Math.ceil(low / step - 1e-9); n * step <= high + 1e-9 * step; n++) {
      ticks.push(n * step);
    }
    return Number.isFinite(step) ? ticks : [];
  }

  // ---- Colour scales: value -> 0..1 and back, undefined for no value.

  function linearScale(low, high, label) {
    const place = (v) => (v - low) / (high - low);
    return { place, ticks: () => roundTicks(low, high, 6), label, lowest: null };
  }

  function logScale(low, high, smaller) {
    const [bottom, top] = [Math.log10(low), Math.log10(high)];
    const ticks = () =>
      roundTicks(bottom, top, 8).filter(Number.isInteger).map((e) => 10 ** e);
    return {
      place: (v) => (v <= low ? 0 : (Math.log10(v) - bottom) / (top - bottom)),
      ticks,
      label: `log scale over ${Number((top - bottom).toFixed(1))} decades`,
      lowest: smaller ? low : null,
    };
  }

  // The power of ten about which a signed log scale turns linear.
  const kneeOf = (limit) => 10 ** Math.round(Math.log10(limit * LINEAR_SHARE));

  function signedLogScale(limit) {
    const knee = kneeOf(limit);
    const reach = Math.asinh(limit / knee);
    const sizes = [10, 100, 1e3, 1e4, 1e5].map((n) => n * knee).filter((v) => v <= limit);
    return {
      place: (v) => 0.5 + (0.5 * Math.asinh(v / knee)) / reach,
      ticks: () => [...sizes.map((s) => -s), 0, ...sizes],
      label: `log scale of both signs, linear below ${show(knee)}`,
      lowest: null,
    };
  }

  function scaleOf(map, log) {
    let [least, most, smaller] = [Infinity, 0, false];
    for (const value of map.values) {
      if (!Number.isFinite(value)) continue;
      const size = map.signed ? Math.abs(value) : value;
      if (size > 0) {
        least = Math.min(least, size);
        most = Math.max(most, size);
      } else {
        smaller = true;
      }
    }
    if (most === 0) [least, most] = [0.1, 1];
    if (map.signed) {
      return log ? signedLogScale(most) : linearScale(-most, most, "linear scale");
    }
    if (!log) return linearScale(0, most, "linear scale");
    const low = Math.min(Math.max(least, most * 10 ** -data.decades), most / 10);
    return logScale(low, most, smaller || least < low);
  }

  // ---- Picks, shared by all pictures whose axes count the same.

  const picked = {};
  const views = [];
  const pick = (changes) => {
    Object.assign(picked, changes);
    for (const view of views) view.follow();
  };

  // ---- Curves.

  function axisStyle(label, size) {
    return {
      label,
      size,
      labelSize: 24,
      font: FONT,
      labelFont: FONT.replace("13px", label.length > 48 ? "10px" : "13px"),
      stroke: () => color("--ink"),
      grid: { stroke: () => color("--grid"), width: 1 },
      ticks: { stroke: () => color("--grid"), width: 1 },
    };
  }

  function drawMark(mark) {
    return (plot) => {
      if (mark === null || mark < plot.scales.y.min || mark > plot.scales.y.max) return;
      const y = Math.round(plot.valToPos(mark, "y", true));
      const { ctx, bbox } = plot;
      ctx.save();
      ctx.strokeStyle = color("--faint");
      ctx.setLineDash([8, 6]);
      ctx.beginPath();
      ctx.moveTo(bbox.left, y);
      ctx.lineTo(bbox.left + bbox.width, y);
      ctx.stroke();
      ctx.restore();
    };
  }

  // chart: { title, xLabel, yLabel, x, series: [{ label, values }], log, signed, mark, sync }
  function plotCurves(root, chart, height) {
    const positive = chart.series.some((s) => s.values.some((v) => v > 0));
    const log = chart.log && (chart.signed || positive);
    const hide = (v) => !Number.isFinite(v) || (log && !chart.signed && v <= 0);
    const columns = chart.series.map((s) => Array.from(s.values, (v) => (hide(v) ? null : v)));
    const largest = columns.flat().reduce((most, v) => Math.max(most, Math.abs(v ?? 0)), 0);
    const y = {};
    if (log && chart.signed) Object.assign(y, { distr: 4, asinh: kneeOf(largest || 1) });
    else if (log) y.distr = 3;
    const value = (_, v) => (v === null || v === undefined ? "–" : show(v));
    const options = {
      title: chart.title,
      width: Math.max(root.clientWidth, 200),
      height,
      scales: { x: { time: false }, y },
      cursor: { sync: chart.sync ? { key: chart.sync } : undefined },
      series: [
        { label: chart.xLabel, value: (_, v) => (v === null || v === undefined ? "–" : showAt(v)) },
        ...chart.series.map((s, n) => ({
          label: s.label,
          stroke: CURVE_COLORS[n],
          width: 1.6,
          value,
          points: { show: chart.x.length < 3 },
        })),
      ],
      axes: [axisStyle(chart.xLabel, 44), axisStyle(chart.yLabel, 88)],
      hooks: { draw: [drawMark(chart.mark ?? null)] },
    };
    options.axes[1].values = (_, ticks) => ticks.map((v) => (v === null ? "" : showAt(v)));
    root.replaceChildren();
    return new uPlot(options, [Array.from(chart.x), ...columns], root);
  }

  // ---- Heat maps.

  class MapView {
    constructor(map) {
      this.map = { ...map, values: floats(map.values) };
      this.root = document.getElementById(map.id);
      this.canvas = this.root.querySelector("canvas");
      this.readout = this.root.querySelector(".readout");
      this.curve = this.root.querySelector(".curve");
      this.log = !map.signed;
      this.along = map.along;
      this.missing = this.map.values.some((v) => !Number.isFinite(v));
      this.peak = this.findPeak();
      this.showAll();
      this.listen();
      this.paint();
    }

    findPeak() {
      let [best, at] = [-1, 0];
      this.map.values.forEach((v, n) => {
        if (Math.abs(v) > best) [best, at] = [Math.abs(v), n];
      });
      return { row: Math.floor(at / this.map.columns), column: at % this.map.columns };
    }

    span(axis, count) {
      const { low, high } = this.map[axis];
      return low < high ? { low, high } : { low: (low ?? 0) - 0.5, high: (low ?? 0) + 0.5, count };
    }

    showAll() {
      this.zoom = { x: this.span("x"), y: this.span("y") };
    }

    // Cell of a coordinate; outside the map: the nearest one.
    index(axis, value) {
      const { low, high } = this.span(axis);
      const count = axis === "x" ? this.map.columns : this.map.rows;
      const cell = Math.floor(((value - low) / (high - low)) * count);
      return Math.min(Math.max(cell, 0), count - 1);
    }

    // Coordinate of a cell's middle.
    coordinate(axis, index) {
      const { low, high } = this.span(axis);
      const count = axis === "x" ? this.map.columns : this.map.rows;
      return low + ((index + 0.5) / count) * (high - low);
    }

    // The same as text, with the digits that tell one cell from the next.
    read(axis, index) {
      const { low, high } = this.span(axis);
      const width = (high - low) / (axis === "x" ? this.map.columns : this.map.rows);
      const digits = Math.min(Math.max(1 - Math.floor(Math.log10(width)), 0), 100);
      return String(Number(this.coordinate(axis, index).toFixed(digits)));
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
      const at = `${x.label} = ${this.read("x", column)}, ` +
        `${y.label} = ${this.read("y", row)}`;
      this.readout.textContent = `${at}: ${label} = ${show(this.value(row, column))}`;
    }

    // Colours the whole map once, cell by cell.
    paint() {
      const { rows, columns, values, signed } = this.map;
      this.scale = scaleOf(this.map, this.log);
      this.picture = null;
      if (rows > 0 && columns > 0) {
        const palette = signed ? palettes.diverging : palettes.sequential;
        const image = new ImageData(columns, rows);
        for (let row = 0; row < rows; row++) {
          for (let column = 0; column < columns; column++) {
            const value = values[row * columns + column];
            const share = Math.min(Math.max(this.scale.place(value), 0), 1);
            const level = Number.isFinite(value) ? Math.round(share * 254) : NO_VALUE;
            const at = 4 * ((rows - 1 - row) * columns + column);
            image.data.set(palette.subarray(3 * level, 3 * level + 3), at);
            image.data[at + 3] = 255;
          }
        }
        this.picture = document.createElement("canvas");
        [this.picture.width, this.picture.height] = [columns, rows];
        this.picture.getContext("2d").putImageData(image, 0, 0);
      }
      for (const button of this.root.querySelectorAll("[data-scale]")) {
        button.setAttribute("aria-pressed", String((button.dataset.scale === "log") === this.log));
      }
      this.follow();
    }

    area() {
      const top = this.map.x.second ? 52 : 12;
      const right = this.map.y.second ? 175 : 125;
      const { clientWidth: width, clientHeight: height } = this.canvas;
      return { left: 74, top, right: Math.max(width - right, 100), bottom: height - 50, width };
    }

    toPixel(axis, value) {
      const { left, top, right, bottom } = this.area();
      const { low, high } = this.zoom[axis];
      const share = (value - low) / (high - low);
      return axis === "x" ? left + share * (right - left) : bottom - share * (bottom - top);
    }

    fromPixel(axis, pixel) {
      const { left, top, right, bottom } = this.area();
      const { low, high } = this.zoom[axis];
      const share = axis === "x" ? (pixel - left) / (right - left) : (bottom - pixel) / (bottom - top);
      return low + Math.min(Math.max(share, 0), 1) * (high - low);
    }

    draw() {
      const ratio = window.devicePixelRatio || 1;
      const { clientWidth, clientHeight } = this.canvas;
      this.canvas.width = Math.round(clientWidth * ratio);
      this.canvas.height = Math.round(clientHeight * ratio);
      const ctx = this.canvas.getContext("2d");
      ctx.scale(ratio, ratio);
      ctx.font = FONT;
      ctx.fillStyle = ctx.strokeStyle = color("--ink");
      this.drawPicture(ctx);
      this.drawAxes(ctx);
      this.drawMarks(ctx);
      this.drawBar(ctx);
    }

    drawPicture(ctx) {
      const { left, top, right, bottom } = this.area();
      if (this.picture) {
        const share = (axis, v) => {
          const { low, high } = this.span(axis);
          return (v - low) / (high - low);
        };
        const { x, y } = this.zoom;
        const { columns, rows } = this.map;
        const sx = share("x", x.low) * columns;
        const sy = (1 - share("y", y.high)) * rows;
        const sw = share("x", x.high) * columns - sx;
        const sh = (1 - share("y", y.low)) * rows - sy;
        ctx.imageSmoothingEnabled = false;
        ctx.drawImage(this.picture, sx, sy, sw, sh, left, top, right - left, bottom - top);
      }
      ctx.strokeRect(left + 0.5, top + 0.5, right - left, bottom - top);
    }

    drawAxes(ctx) {
      const { left, top, right, bottom } = this.area();
      const { x, y } = this.map;
      const middle = { x: (left + right) / 2, y: (top + bottom) / 2 };
      const across = (second) => {
        const factor = second ? second[1] : 1;
        const edge = second ? top : bottom;
        const way = second ? -1 : 1;
        const { low, high } = this.zoom.x;
        ctx.textAlign = "center";
        ctx.textBaseline = "middle";
        for (const v of roundTicks(low * factor, high * factor, (right - left) / 90)) {
          const at = this.toPixel("x", v / factor);
          line(ctx, at, edge, at, edge + 5 * way);
          ctx.fillText(showAt(v), at, edge + 14 * way);
        }
        ctx.fillText(second ? second[0] : x.label, middle.x, edge + 36 * way);
      };
      const up = (second) => {
        const factor = second ? second[1] : 1;
        const edge = second ? right : left;
        const way = second ? 1 : -1;
        const { low, high } = this.zoom.y;
        ctx.textAlign = second ? "left" : "right";
        ctx.textBaseline = "middle";
        for (const v of roundTicks(low * factor, high * factor, (bottom - top) / 55)) {
          const at = this.toPixel("y", v / factor);
          line(ctx, edge, at, edge + 5 * way, at);
          ctx.fillText(showAt(v), edge + 8 * way, at, 50);
        }
        upright(ctx, second ? second[0] : y.label, edge + (second ? 50 : -62), middle.y);
      };
      across(null);
      up(null);
      if (x.second) across(x.second);
      if (y.second) up(y.second);
    }

    // Band edges, the line k = 0, the picked cell and a rectangle being dragged.
    drawMarks(ctx) {
      const { left, top, right, bottom } = this.area();
      ctx.save();
      ctx.beginPath();
      ctx.rect(left, top, right - left, bottom - top);
      ctx.clip();
      const { signed } = this.map;
      const bright = signed ? "#222222" : "#ffffff";
      const across = (axis, value, style, dash) => {
        ctx.setLineDash(dash);
        ctx.strokeStyle = style;
        const at = this.toPixel(axis, value);
        if (axis === "x") line(ctx, at, top, at, bottom);
        else line(ctx, left, at, right, at);
      };
      for (const axis of ["x", "y"]) {
        const { mark, low, role } = this.map[axis];
        if (mark !== null) across(axis, mark, bright, [8, 6]);
        if (mark !== null && low < 0) across(axis, -mark, bright, [8, 6]);
        if (role === "wavenumber" && low < 0) across(axis, 0, bright, [2, 3]);
      }
      if (this.picture) {
        const { row, column } = this.cell();
        for (const [style, dash] of [["#000000", []], ["#ffffff", [4, 4]]]) {
          across("x", this.coordinate("x", column), style, dash);
          across("y", this.coordinate("y", row), style, dash);
        }
      }
      if (this.drag?.moved) {
        const { from, to } = this.drag;
        ctx.fillStyle = "rgb(128 128 128 / 35%)";
        ctx.fillRect(from.x, from.y, to.x - from.x, to.y - from.y);
      }
      ctx.restore();
    }

    drawBar(ctx) {
      const { top, bottom, width } = this.area();
      const foot = this.missing ? bottom - 24 : bottom;
      const [left, wide] = [width - 110, 16];
      const palette = this.map.signed ? palettes.diverging : palettes.sequential;
      const step = (foot - top) / 255;
      for (let level = 0; level < 255; level++) {
        const [r, g, b] = palette.subarray(3 * level, 3 * level + 3);
        ctx.fillStyle = `rgb(${r} ${g} ${b})`;
        ctx.fillRect(left, foot - (level + 1) * step, wide, step + 0.5);
      }
      ctx.fillStyle = ctx.strokeStyle = color("--ink");
      ctx.strokeRect(left + 0.5, top + 0.5, wide, foot - top);
      ctx.textAlign = "left";
      ctx.textBaseline = "middle";
      const { lowest } = this.scale;
      const write = (text, share) => {
        const y = foot - share * (foot - top);
        line(ctx, left + wide, y, left + wide + 4, y);
        ctx.fillText(text, left + wide + 7, y);
      };
      for (const value of this.scale.ticks()) {
        const share = this.scale.place(value);
        if (share >= 0 && share <= 1 && (lowest === null || share > 0.04)) {
          write(showAt(Number(value.toPrecision(3))), share);
        }
      }
      if (lowest !== null) write(`≤ ${lowest.toExponential(0)}`, 0);
      if (this.missing) {
        ctx.fillStyle = `rgb(${palettes.sequential.subarray(3 * NO_VALUE, 3 * NO_VALUE + 3).join(" ")})`;
        ctx.fillRect(left, bottom - 14, wide, 14);
        ctx.strokeRect(left + 0.5, bottom - 13.5, wide, 14);
        ctx.fillStyle = color("--ink");
        ctx.fillText("no value", left + wide + 7, bottom - 6);
      }
      const label = `${this.map.label}, ${this.scale.label}`;
      upright(ctx, label, width - 10, (top + bottom) / 2, bottom - top + 20);
    }

    follow() {
      this.draw();
      this.drawCurve();
      for (const button of this.root.querySelectorAll("[data-along]")) {
        button.setAttribute("aria-pressed", String(button.dataset.along === this.along));
      }
    }

    drawCurve() {
      const { rows, columns, x, y, label, signed } = this.map;
      if (!this.picture) return;
      const { row, column } = this.cell();
      const upwards = this.along === "y";
      const count = upwards ? rows : columns;
      const values = Float32Array.from({ length: count }, (_, n) =>
        upwards ? this.value(n, column) : this.value(row, n));
      const fixed = upwards ? x : y;
      const at = upwards ? this.read("x", column) : this.read("y", row);
      this.plot?.destroy();
      this.plot = plotCurves(this.curve, {
        title: `at ${fixed.label} = ${at}`,
        xLabel: (upwards ? y : x).label,
        yLabel: label,
        x: Array.from({ length: count }, (_, n) => this.coordinate(this.along, n)),
        series: [{ label: "value", values }],
        log: this.log,
        signed,
      }, 400);
    }

    listen() {
      const { canvas } = this;
      const point = (event) => ({ x: event.offsetX, y: event.offsetY });
      const cellAt = ({ x, y }) => [
        this.index("y", this.fromPixel("y", y)),
        this.index("x", this.fromPixel("x", x)),
      ];
      canvas.addEventListener("pointerdown", (event) => {
        if (event.button !== 0) return;
        canvas.setPointerCapture(event.pointerId);
        this.drag = { from: point(event), to: point(event), moved: false };
      });
      canvas.addEventListener("pointermove", (event) => {
        if (!this.picture) return;
        const to = point(event);
        this.describe(...cellAt(to));
        if (!this.drag) return;
        const { from } = this.drag;
        this.drag.to = to;
        this.drag.moved ||= Math.hypot(to.x - from.x, to.y - from.y) > 5;
        this.draw();
      });
      canvas.addEventListener("pointerup", () => {
        const { drag } = this;
        this.drag = null;
        if (!drag || !this.picture) return;
        if (!drag.moved) this.pickCell(...cellAt(drag.from));
        else this.zoomTo(drag.from, drag.to);
      });
      canvas.addEventListener("pointercancel", () => {
        this.drag = null;
        this.draw();
      });
      canvas.addEventListener("dblclick", () => this.reset());
      canvas.addEventListener("keydown", (event) => this.key(event));
      this.root.querySelector("[data-reset]").addEventListener("click", () => this.reset());
      for (const button of this.root.querySelectorAll("[data-scale]")) {
        button.addEventListener("click", () => {
          this.log = button.dataset.scale === "log";
          this.paint();
        });
      }
      for (const button of this.root.querySelectorAll("[data-along]")) {
        button.addEventListener("click", () => {
          this.along = button.dataset.along;
          this.follow();
        });
      }
    }

    reset() {
      this.showAll();
      this.draw();
    }

    zoomTo(a, b) {
      const range = (axis) => {
        const ends = [this.fromPixel(axis, a[axis]), this.fromPixel(axis, b[axis])];
        const [low, high] = [Math.min(...ends), Math.max(...ends)];
        return Math.abs(a[axis] - b[axis]) > 5 ? { low, high } : this.zoom[axis];
      };
      this.zoom = { x: range("x"), y: range("y") };
      this.draw();
    }

    // Shrinks (or grows) the part shown about the picked cell.
    zoomBy(factor) {
      const { row, column } = this.cell();
      const range = (axis, index) => {
        const [all, now] = [this.span(axis), this.zoom[axis]];
        const middle = this.coordinate(axis, index);
        const half = Math.min((now.high - now.low) * factor, all.high - all.low) / 2;
        const low = Math.min(Math.max(middle - half, all.low), all.high - 2 * half);
        return { low, high: low + 2 * half };
      };
      this.zoom = { x: range("x", column), y: range("y", row) };
      this.draw();
    }

    key(event) {
      if (!this.picture || event.ctrlKey || event.metaKey || event.altKey) return;
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
  }

  function line(ctx, x0, y0, x1, y1) {
    ctx.beginPath();
    ctx.moveTo(x0, y0);
    ctx.lineTo(x1, y1);
    ctx.stroke();
  }

  function upright(ctx, text, x, y, room) {
    ctx.save();
    ctx.translate(x, y);
    ctx.rotate(-Math.PI / 2);
    ctx.textAlign = "center";
    ctx.textBaseline = "middle";
    ctx.fillText(text, 0, 0, room);
    ctx.restore();
  }

  // ---- Curves along x, along t and along frequency.

  class CurveView {
    constructor(group) {
      this.group = group;
      this.x = doubles(group.x);
      this.charts = group.charts.map((chart) => ({
        ...chart,
        series: chart.series.map((s) => ({ ...s, values: floats(s.values) })),
      }));
      this.roots = document.getElementById(group.id).querySelectorAll(".curve");
      this.plots = [];
      this.draw();
    }

    draw() {
      for (const plot of this.plots) plot.destroy();
      const { id, label, role } = this.group;
      this.plots = this.charts.map((chart, n) => {
        const plot = plotCurves(this.roots[n], {
          xLabel: label,
          yLabel: chart.label,
          x: this.x,
          series: chart.series,
          log: chart.log,
          mark: chart.mark,
          sync: id,
        }, n === 0 ? 300 : 230);
        plot.over.addEventListener("click", () => {
          if (plot.cursor.left >= 0 && plot.select.width < 5) {
            pick({ [role]: plot.posToVal(plot.cursor.left, "x") });
          }
        });
        return plot;
      });
    }

    follow() {}
  }

  const curves = data.curves.map((group) => new CurveView(group));
  views.push(...data.maps.map((map) => new MapView(map)));

  const redraw = () => {
    for (const view of views) view.follow();
    for (const view of curves) view.draw();
  };
  for (const query of ["(prefers-color-scheme: dark)", "print"]) {
    window.matchMedia(query).addEventListener("change", redraw);
  }
  let width = document.body.clientWidth;
  new ResizeObserver(() => {
    if (document.body.clientWidth === width) return;
    width = document.body.clientWidth;
    requestAnimationFrame(redraw);
  }).observe(document.body);
})();
