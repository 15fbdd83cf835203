// Curves of the last seconds: angles and demands, pressures of the hoses, voltages of the valves.

import { prepared } from "./drawing.js";
import { degrees } from "./options.js";
import { COLUMNS } from "./simulation.js";

const LEFT = 46; // px around an axis
const RIGHT = 10;
const TOP = 24;
const BOTTOM = 8;
const TIME_AXIS = 22;
const STEPS = [1, 2, 3, 5, 10]; // of ticks, times a power of ten
const WIDTHS = [2.4, 1.1]; // px of curves in turn, by which they differ without colour
const ANGLE_STEPS = [1, 1.5, 3, 4.5, 9, 10];

/** Plot of a simulation's record on a canvas, one axis above the other. */
export class Plot {
  constructor(canvas) {
    this.canvas = canvas;
  }

  draw(simulation, colors) {
    const { context, width, height } = prepared(this.canvas);
    Object.assign(this, { context, colors, simulation, left: LEFT, right: width - RIGHT });
    const axes = this.axes();
    const each = (height - TIME_AXIS) / axes.length;
    axes.forEach((axis, i) => this.drawAxis(axis, i * each + TOP, (i + 1) * each - BOTTOM));
    this.drawTimes(height - TIME_AXIS, height);
  }

  /** Returns the axes: title, range and curves of each; a curve has a column of the record, and a color. */
  axes() {
    const { simulation, colors } = this;
    const { joints } = simulation.machine;
    const { parameters } = simulation;
    const names = joints.length > 1 ? joints : ["angle"];
    const stroke = Math.max(...simulation.entry.strokes.map(degrees));
    const supply = (parameters.around.supply_pressure - parameters.around.ambient_pressure) / 1e5;
    const { centre_voltage: centre, volts_to_full: span } = parameters.joints[0].valve;
    const column = (j, key) => j * COLUMNS.count + COLUMNS[key];
    return [
      { title: "Angle, deg", range: [-1.15 * stroke, 1.15 * stroke], steps: ANGLE_STEPS, curves: [
        ...joints.map((_, j) => ({ column: column(j, "demand"), color: colors.target, dash: [4, 3] })),
        ...joints.map((_, j) => ({ column: column(j, "angle"), color: colors.joints[j], name: names[j], width: WIDTHS[j % 2] })),
      ], extra: { name: "demand", color: colors.target, isDashed: true, width: 2 } },
      ...joints.map((joint, j) => ({
        title: joints.length > 1 ? `Pressure of ${joint}, bar` : "Pressure, bar", range: [0, supply * 1.05], curves: [
          { column: column(j, "pressureA"), color: colors.hoseA, name: "hose A", width: WIDTHS[0] },
          { column: column(j, "pressureB"), color: colors.hoseB, name: "hose B", width: WIDTHS[1] },
        ],
      })),
      { title: "Valve voltage, V", range: [centre - 1.08 * span, centre + 1.08 * span], curves:
        joints.map((_, j) => ({ column: column(j, "voltage"), color: colors.joints[j], name: joints.length > 1 ? joints[j] : "", width: WIDTHS[j % 2] })) },
    ];
  }

  drawAxis({ title, range, steps, curves, extra }, top, bottom) {
    const { context, colors, left, right } = this;
    const y = (value) => bottom - ((value - range[0]) / (range[1] - range[0])) * (bottom - top);
    context.font = `12px ${colors.font}`;
    context.textBaseline = "middle";
    context.textAlign = "right";
    context.lineWidth = 1;
    for (const tick of ticks(range, (bottom - top) / 32, steps)) {
      context.strokeStyle = tick === 0 ? colors.axis : colors.grid;
      context.beginPath();
      context.moveTo(left, Math.round(y(tick)) + 0.5);
      context.lineTo(right, Math.round(y(tick)) + 0.5);
      context.stroke();
      context.fillStyle = colors.quiet;
      context.fillText(String(tick).replace("-", "\u2212"), left - 7, y(tick));
    }
    context.textAlign = "left";
    context.fillStyle = colors.text;
    context.font = `600 12px ${colors.font}`;
    context.fillText(title, left, top - 12);
    this.drawLegend([...curves.filter(({ name }) => name), ...(extra ? [extra] : [])], top - 12);
    context.save();
    context.beginPath();
    context.rect(left, top - 2, right - left, bottom - top + 4);
    context.clip();
    for (const curve of curves) this.drawCurve(curve, y);
    context.restore();
  }

  drawLegend(items, y) {
    const { context, colors } = this;
    let x = this.right;
    context.font = `12px ${colors.font}`;
    context.textAlign = "right";
    for (const { name, color, isDashed, width } of [...items].reverse()) {
      context.fillStyle = colors.text;
      context.fillText(name, x, y);
      x -= context.measureText(name).width + 5;
      context.fillStyle = color;
      if (isDashed) for (const dash of [14, 6]) context.fillRect(x - dash, y - 1, 5, 2);
      else context.fillRect(x - 14, y - width / 2, 13, width);
      x -= 26;
    }
  }

  /** Draws a curve; where samples are denser than the screen's points, the least and the greatest of each point. */
  drawCurve({ column, color, dash = [], width = 1.5 }, y) {
    const { context, left, right, simulation } = this;
    const { record } = simulation;
    if (record.length < 2) return;
    const step = (right - left) / (record.size - 1);
    const group = Math.max(Math.round(1 / step), 1);
    context.strokeStyle = color;
    context.lineWidth = width;
    context.lineJoin = "round";
    context.setLineDash(dash);
    context.beginPath();
    const offset = record.count % group; // so that groups do not change as the curve moves
    for (let age = record.length - 1; age >= 0; ) {
      const x = right - age * step;
      let [lower, upper] = [Infinity, -Infinity];
      do {
        const value = record.at(age--, column);
        if (value < lower) lower = value;
        if (value > upper) upper = value;
      } while (age >= 0 && (age + 1 - offset) % group !== 0);
      context.lineTo(x, y(lower));
      if (upper > lower) context.lineTo(x, y(upper));
    }
    context.stroke();
    context.setLineDash([]);
  }

  drawTimes(top, bottom) {
    const { context, colors, left, right, simulation } = this;
    context.font = `12px ${colors.font}`;
    context.fillStyle = colors.quiet;
    context.strokeStyle = colors.grid;
    const { seconds, time } = simulation;
    const step = right - left < 420 ? 2 : 1;
    for (let mark = Math.ceil((time - seconds) / step) * step; mark <= time; mark += step) {
      const x = right - ((time - mark) / seconds) * (right - left);
      if (mark < 0 || x < left) continue;
      context.beginPath();
      context.moveTo(x, top - 4);
      context.lineTo(x, top);
      context.stroke();
      if (x > right - 58) continue;
      context.textAlign = "center";
      context.fillText(String(mark), x, (top + bottom) / 2);
    }
    context.textAlign = "right";
    context.fillText("time, s", right, (top + bottom) / 2);
  }
}

/** Returns round numbers in a range, at most `max` and at least two. */
export function ticks([lower, upper], max, steps = STEPS) {
  const raw = (upper - lower) / Math.max(max, 2);
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = steps.map((one) => one * power).find((one) => one >= raw);
  const result = [];
  for (let i = Math.ceil(lower / step); i * step <= upper; i++) result.push(Number((i * step).toPrecision(6)));
  return result;
}
