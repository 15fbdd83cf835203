// The arm from above: links, hoses around their joints, the demand, and a pull.

import { pose, pulledPlace } from "./geometry.js";
import { radians } from "./options.js";

const JOINT_RADIUS = 0.062; // of a drawn joint, m
const HOSE_GAP = radians(16); // between a hose and the link that it pushes
const HOSE_END = radians(128); // of a hose on the far side, from the link at mid-stroke
const MAX_HOSE = 0.045; // width of a full hose, m
const MIN_HOSE = 0.008;
const MARGIN = 26; // px around what the arm reaches

/** Returns the canvas's context, sized for the screen's pixels, and its width and height. */
export function prepared(canvas) {
  const ratio = Math.min(window.devicePixelRatio || 1, 2);
  const { clientWidth: width, clientHeight: height } = canvas;
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  return { context, width, height };
}

/** Drawing of a simulation's arm on a canvas. */
export class Drawing {
  constructor(canvas) {
    this.canvas = canvas;
    this.view = { scale: 1, x: 0, y: 0 };
  }

  /** Returns the place of a point of the canvas (px), m. */
  place(px, py) {
    return [(px - this.view.x) / this.view.scale, (this.view.y - py) / this.view.scale];
  }

  draw(simulation, colors) {
    const { context, width, height } = prepared(this.canvas);
    this.fit(width, height, simulation.box);
    this.context = context;
    this.colors = colors;
    const arm = pose(simulation.geometry, simulation.angles);
    const target = pose(simulation.geometry, [...simulation.targets]);
    this.drawScale(height);
    simulation.entry.strokes.forEach((stroke, j) => this.drawStroke(simulation, arm, j, stroke));
    this.drawLinks(target, { color: colors.target, width: 2, dash: [5, 5] });
    this.drawBase(arm);
    simulation.outputs.forEach((output, j) => this.drawHoses(simulation, arm, output, j));
    this.drawLinks(arm, { color: colors.link, width: Math.max(0.03 * this.view.scale, 5) });
    arm.points.slice(0, -1).forEach((point, j) => this.drawJoint(point, colors.joints[j]));
    this.drawTip(arm, simulation.parameters.around.payload);
    this.drawTarget(target);
    if (simulation.pull) this.drawPull(arm, simulation.pull);
  }

  /** Chooses scale and centre so that the arm's whole range fits. */
  fit(width, height, [left, bottom, right, top]) {
    const scale = Math.min((width - 2 * MARGIN) / (right - left), (height - 2 * MARGIN) / (top - bottom));
    this.view = { scale, x: width / 2 - (scale * (left + right)) / 2, y: height / 2 + (scale * (bottom + top)) / 2 };
  }

  point([x, y]) {
    return [this.view.x + this.view.scale * x, this.view.y - this.view.scale * y];
  }

  drawScale(height) {
    const { context, view, colors } = this;
    context.strokeStyle = context.fillStyle = colors.quiet;
    context.lineWidth = 1;
    const length = 0.1 * view.scale;
    context.beginPath();
    context.moveTo(14.5, height - 18);
    context.lineTo(14.5, height - 14.5);
    context.lineTo(14.5 + length, height - 14.5);
    context.lineTo(14.5 + length, height - 18);
    context.stroke();
    this.text("100 mm", 14.5 + length + 6, height - 14);
  }

  text(text, x, y, align = "left") {
    this.context.font = `12px ${this.colors.font}`;
    this.context.textAlign = align;
    this.context.textBaseline = "middle";
    this.context.fillText(text, x, y);
  }

  /** Draws the working stroke of a joint as a sector around its link. */
  drawStroke({ geometry, angles }, arm, j, stroke) {
    const { context } = this;
    const middle = arm.directions[j] - angles[j];
    const [x, y] = this.point(arm.points[j]);
    const radius = 0.42 * geometry.lengths[j] * this.view.scale;
    context.beginPath();
    context.moveTo(x, y);
    context.arc(x, y, radius, -middle - stroke, -middle + stroke);
    context.closePath();
    context.fillStyle = this.colors.sector;
    context.fill();
  }

  drawLinks({ points }, { color, width, dash = [] }) {
    const { context } = this;
    context.strokeStyle = color;
    context.lineWidth = width;
    context.lineCap = context.lineJoin = "round";
    context.setLineDash(dash);
    context.beginPath();
    points.forEach((point, i) => context[i ? "lineTo" : "moveTo"](...this.point(point)));
    context.stroke();
    context.setLineDash([]);
  }

  drawBase(arm) {
    const { context, view } = this;
    const [x, y] = this.point(arm.points[0]);
    context.fillStyle = this.colors.base;
    context.beginPath();
    context.roundRect(x - 0.1 * view.scale, y - 0.03 * view.scale, 0.2 * view.scale, 0.15 * view.scale, 0.015 * view.scale);
    context.fill();
  }

  /** Draws the hoses of a joint: each from its fixed end to the link, as wide as its pressure. */
  drawHoses(simulation, arm, output, j) {
    const { around } = simulation.parameters;
    const full = around.supply_pressure - around.ambient_pressure;
    const middle = arm.directions[j] - simulation.angles[j];
    const hoses = [
      [output.pressure_a, middle - HOSE_END, arm.directions[j] - HOSE_GAP, this.colors.hoseA],
      [output.pressure_b, arm.directions[j] + HOSE_GAP, middle + HOSE_END, this.colors.hoseB],
    ];
    for (const [pressure, from, to, color] of hoses) {
      const share = Math.min(Math.max((pressure - around.ambient_pressure) / full, 0), 1);
      this.drawArc(arm.points[j], from, to, MIN_HOSE + share * (MAX_HOSE - MIN_HOSE), color);
    }
  }

  drawArc(center, from, to, width, color) {
    const { context, view } = this;
    const [x, y] = this.point(center);
    context.beginPath();
    context.arc(x, y, (JOINT_RADIUS + width / 2) * view.scale, -to, -from);
    context.strokeStyle = color;
    context.lineCap = "round";
    context.lineWidth = width * view.scale;
    context.stroke();
  }

  drawJoint(point, color) {
    const [x, y] = this.point(point);
    this.disk(x, y, JOINT_RADIUS * this.view.scale, this.colors.panel, color, 3);
    this.disk(x, y, 0.2 * JOINT_RADIUS * this.view.scale, color);
  }

  drawTip({ points }, payload) {
    const [x, y] = this.point(points.at(-1));
    this.disk(x, y, (0.02 + 0.016 * Math.sqrt(payload)) * this.view.scale, this.colors.payload, this.colors.link, 1.5);
  }

  drawTarget({ points }) {
    const [x, y] = this.point(points.at(-1));
    this.disk(x, y, 15, this.colors.halo, this.colors.target, 2.5);
    this.disk(x, y, 2.5, this.colors.target);
  }

  disk(x, y, radius, fill, stroke = "", width = 0) {
    const { context } = this;
    context.beginPath();
    context.arc(x, y, radius, 0, 2 * Math.PI);
    context.fillStyle = fill;
    context.fill();
    if (!stroke) return;
    context.strokeStyle = stroke;
    context.lineWidth = width;
    context.stroke();
  }

  drawPull(arm, pull) {
    const { context } = this;
    const [ax, ay] = this.point(pulledPlace(arm, pull));
    const [bx, by] = this.point(pull.to);
    context.strokeStyle = context.fillStyle = this.colors.pull;
    context.lineWidth = 2.5;
    context.beginPath();
    context.moveTo(ax, ay);
    context.lineTo(bx, by);
    context.stroke();
    const direction = Math.atan2(by - ay, bx - ax);
    context.beginPath();
    context.moveTo(bx + 7 * Math.cos(direction), by + 7 * Math.sin(direction));
    for (const side of [2.5, -2.5]) context.lineTo(bx + 8 * Math.cos(direction + side), by + 8 * Math.sin(direction + side));
    context.fill();
    this.text(`${(pull.force ?? 0).toFixed(0)} N`, bx + 12, by - 12);
  }
}
