// A machine that runs in real time: plant and controller with the page's options, and the record of the last seconds.

import { instantiate } from "./runtime.js";
import { restore } from "./structs.js";
import { armGeometry, pose, reachedBox, torquesOf } from "./geometry.js";
import { degrees, radians } from "./options.js";

const RECORDED = 10; // s
const MAX_LAG = 0.1; // s of a frame; a page in the background does not catch up
const SPRING = 150; // of a pull at the arm, N/m
const MAX_PULL = 30; // N

/** Ring of samples of one control cycle each: rows of numbers. */
class Record {
  constructor(size, columns) {
    this.size = size;
    this.columns = columns;
    this.rows = new Float32Array(size * columns);
    this.count = 0;
  }

  row() {
    const start = (this.count++ % this.size) * this.columns;
    return this.rows.subarray(start, start + this.columns);
  }

  get length() {
    return Math.min(this.count, this.size);
  }

  /** Returns a number of the sample that is `age` samples old. */
  at(age, column) {
    return this.rows[((this.count - 1 - age) % this.size) * this.columns + column];
  }
}

/** Columns of a joint in the record. */
export const COLUMNS = { angle: 0, demand: 1, pressureA: 2, pressureB: 3, voltage: 4, count: 5 };

export class Simulation {
  static async load(entry, module, options) {
    return new Simulation(entry, await instantiate(entry.description, module), options);
  }

  constructor(entry, machine) {
    Object.assign(this, { entry, machine, plant: machine.plant(), controllers: {}, time: 0, debt: 0, pull: null });
    for (const law of machine.laws) this.controllers[law] = machine.controller(law);
    this.parameters = this.plant.parameters;
    this.geometry = armGeometry(entry, this.parameters);
    this.box = reachedBox(this.geometry, entry.strokes);
    this.described = entry.description.plant.parameters;
    this.record = new Record(Math.round(RECORDED / machine.cycle), COLUMNS.count * machine.joints.length);
    this.targets = new Float64Array(machine.joints.length);
    this.outputs = this.plant.outputs;
  }

  get seconds() {
    return RECORDED;
  }

  /** Angles of the joints, rad. */
  get angles() {
    return this.outputs.map((one) => one.angle);
  }

  /** Sets the machine to rest in mid-stroke, and its controller awake. */
  reset() {
    this.plant.rest();
    this.time = this.debt = this.record.count = 0;
    this.pull = null;
    this.controller.wake(this.plant.sample());
  }

  /** Takes over options: parameters of the plant, gains of the law, demands. */
  apply(options) {
    const { parameters } = this;
    restore(parameters, this.described);
    parameters.around.supply_pressure = parameters.around.ambient_pressure + 1e5 * options.supply;
    parameters.around.payload = options.payload;
    for (const joint of parameters.joints) {
      joint.valve.conductance *= options.valve;
      joint.valve.leakage *= options.valve;
      joint.brake_torque *= options.brake;
    }
    const controller = this.controllers[options.law];
    restore(controller.settings, this.entry.description.laws[options.law].settings);
    for (const joint of controller.settings.joints ?? []) scalePaperGains(joint, options);
    for (const feedback of controller.settings.feedback ?? []) {
      feedback.stiffness *= options.stiffness;
      feedback.damping *= options.damping;
    }
    if (controller !== this.controller) {
      this.controller = controller;
      controller.wake(this.plant.sample());
    }
    this.options = { ...options };
  }

  /** Advances by a time of the wall clock, s. */
  advance(elapsed) {
    const { cycle } = this.machine;
    this.debt += Math.min(elapsed, MAX_LAG) * this.options.speed;
    for (; this.debt >= cycle; this.debt -= cycle) this.step();
  }

  step() {
    const { plant, controller } = this;
    this.setDemand();
    this.setPull();
    for (const noise of plant.noise) {
      noise.angle = this.options.noise * normalSample();
      noise.pressure = this.options.noise * normalSample();
    }
    const command = controller.step(plant.sample());
    plant.drive(command);
    plant.advance();
    this.time += this.machine.cycle;
    this.write(command);
  }

  setDemand() {
    const { program, period } = this.options;
    const phase = this.time / period;
    const share = program === "hand" ? 1 : program === "sine" ? Math.sin(2 * Math.PI * phase) : phase % 1 < 0.5 ? 1 : -1;
    const rate = program === "sine" ? (2 * Math.PI) / period : 0;
    const { angle, velocity, acceleration } = this.controller.demand;
    for (let j = 0; j < this.targets.length; j++) {
      const target = radians(this.options[`target${j + 1}`]);
      this.targets[j] = angle[j] = share * target;
      velocity[j] = rate * Math.cos(2 * Math.PI * phase) * target;
      acceleration[j] = -rate * rate * angle[j];
    }
  }

  /** Sets the joints' load to the pull of a spring from a place on the arm to the pointer; see `pull`. */
  setPull() {
    for (const input of this.plant.inputs) input.load = 0;
    if (!this.pull) return;
    const arm = pose(this.geometry, this.angles);
    const place = pulledPlace(arm, this.pull);
    const [x, y] = [this.pull.to[0] - place[0], this.pull.to[1] - place[1]];
    const distance = Math.hypot(x, y);
    this.pull.force = Math.min(SPRING * distance, MAX_PULL);
    const share = distance > 0 ? this.pull.force / distance : 0;
    torquesOf(arm, this.pull.link, place, [share * x, share * y]).forEach((torque, j) => { this.plant.inputs[j].load = torque; });
  }

  write(command) {
    const row = this.record.row();
    const ambient = this.parameters.around.ambient_pressure;
    for (let j = 0; j < this.outputs.length; j++) {
      const output = this.outputs[j];
      const start = j * COLUMNS.count;
      row[start + COLUMNS.angle] = degrees(output.angle);
      row[start + COLUMNS.demand] = degrees(this.targets[j]);
      row[start + COLUMNS.pressureA] = (output.pressure_a - ambient) / 1e5;
      row[start + COLUMNS.pressureB] = (output.pressure_b - ambient) / 1e5;
      row[start + COLUMNS.voltage] = command.voltage[j];
    }
  }
}

/** Returns the place at which a pull acts. */
export function pulledPlace({ points }, { link, fraction }) {
  const [[ax, ay], [bx, by]] = [points[link], points[link + 1]];
  return [ax + fraction * (bx - ax), ay + fraction * (by - ay)];
}

function scalePaperGains(gains, options) {
  for (const phase of [gains.far, gains.near, gains.close]) {
    phase.error_gain *= options.error;
    phase.pressure_gain *= options.pressure;
  }
  gains.integral_gain *= options.integral;
}

/** Returns a standard normal sample, by Box and Muller. */
function normalSample() {
  return Math.sqrt(-2 * Math.log(1 - Math.random())) * Math.cos(2 * Math.PI * Math.random());
}
