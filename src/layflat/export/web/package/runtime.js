// A machine's plant and control laws in WebAssembly.

import { addressOf, Heap, indexOf, restore, save, StructTable } from "./structs.js";

// Numbers of a joint in a command (fractions of brake, dither, supply), and before these among the inputs of a plant.
const SHARES = 3, INPUTS_BEFORE_SHARES = 4;

/**
 * Returns the machine of a description (see machine.js) with an instance of its module.
 * `source`: a compiled module, its bytes, or a response with them.
 */
export async function instantiate(description, source) {
  const module = source instanceof WebAssembly.Module ? source : await WebAssembly.compile(await bytesOf(source));
  return new Machine(description, await WebAssembly.instantiate(module, {}));
}

async function bytesOf(source) {
  const response = await source;
  return typeof Response !== "undefined" && response instanceof Response ? response.arrayBuffer() : response;
}

/** Machine: makes plants and controllers, whose memory lasts as long as the machine. */
export class Machine {
  constructor(description, instance) {
    const { name, title, joints, cycle, steps } = description;
    Object.assign(this, { name, title, joints, cycle, steps, laws: Object.keys(description.laws) });
    this.description = description;
    this.functions = instance.exports;
    this.heap = new Heap(instance.exports.memory, instance.exports.__heap_base.value);
  }

  /** Returns a new plant at rest at zero angles. */
  plant() {
    return new Plant(this);
  }

  /** Returns a new controller of one of `laws`; the first is the machine's own. */
  controller(law = this.laws[0]) {
    if (!this.laws.includes(law)) throw new RangeError(`${this.name} has no law "${law}"; it has ${this.laws.join(", ")}`);
    return new Controller(this, law);
  }

  /** Places the structs of a part's arguments in memory; returns them by their names. */
  place(part, names) {
    const table = new StructTable(part.structs);
    return names.map((name) => {
      const [type, rows] = part.arguments[name];
      const index = this.heap.allocate(table.size(type) * (rows || 1));
      return table.view(this.heap, type, index, rows);
    });
  }
}

/** Plant: arm, joints, hoses and valves; it is advanced by its caller. */
export class Plant {
  constructor(machine) {
    const part = machine.description.plant;
    this.machine = machine;
    [this.parameters, this.state, this.inputs, this.outputs, this.noise, this.readings, this.restAngles, this.restPressures] =
      machine.place(part, ["parameters", "state", "inputs", "outputs", "noise", "sensed", "angles", "pressures"]);
    const { plant_rest, plant_advance, plant_sample } = machine.functions;
    const at = (names) => names.map((name) => addressOf(this[name]));
    const [parameters, state, angles, pressures] = at(["parameters", "state", "restAngles", "restPressures"]);
    const [inputs, outputs, noise, readings] = at(["inputs", "outputs", "noise", "readings"]);
    const places = this.inputs.map((input) => indexOf(input));
    const { heap, steps: stepsOfCycle } = machine;
    this.calls = {
      rest: () => plant_rest(parameters, angles, pressures, state),
      advance: (steps, isNewCycle) => plant_advance(parameters, state, inputs, outputs, steps, isNewCycle ? 1 : 0),
      sample: () => plant_sample(parameters, state, noise, readings),
      drive: (command) => places.forEach((place, j) => {
        const shares = command + places.length + SHARES * j;
        heap.numbers[place] = heap.numbers[command + j];
        heap.numbers.copyWithin(place + INPUTS_BEFORE_SHARES, shares, shares + SHARES);
      }),
    };
    this.cycleSteps = stepsOfCycle;
    restore(this.parameters, part.parameters);
    this.rest();
  }

  /**
   * Sets the state to rest: angles (rad), and absolute pressures of hoses A and B (Pa; default: those that hold the
   * arm), a number a joint each. Valves are centred, and nothing loads the joints.
   */
  rest(angles = this.machine.joints.map(() => 0), pressuresA = angles.map(() => NaN), pressuresB = angles.map(() => NaN)) {
    this.restAngles.angle.set(angles);
    this.restPressures.pressure_a.set(pressuresA);
    this.restPressures.pressure_b.set(pressuresB);
    for (const [j, joint] of this.parameters.joints.entries()) {
      this.inputs[j].voltage = joint.valve.centre_voltage;
      this.inputs[j].load = this.inputs[j].hole_a = this.inputs[j].hole_b = 0;
      this.inputs[j].brake = this.inputs[j].dither = this.inputs[j].supply = 1;
    }
    this.calls.rest();
    this.calls.advance(0, false);
  }

  /** Sets voltages, and fractions of brake, dither and supply, to a controller's command; they hold until the next call. */
  drive(command) {
    this.calls.drive(indexOf(command));
  }

  /** Advances by steps of `cycle / steps` s, by default a control cycle; fills `outputs`. */
  advance(steps = this.cycleSteps, isNewCycle = true) {
    if (!Number.isInteger(steps) || steps < 0) throw new RangeError(`advance takes a whole number of steps, not ${steps}`);
    const diverged = this.calls.advance(steps, isNewCycle);
    if (diverged >= 0) {
      throw new Error(`${this.machine.name}: the state of joint ${this.machine.joints[diverged]} became invalid; ` +
        "give finite and plausible inputs and parameters, and set the plant to rest");
    }
  }

  /** Reads the sensors into `readings`, with the standard normal samples in `noise`, and returns these. */
  sample() {
    this.calls.sample();
    return this.readings;
  }
}

/** Control law with its settings and memory. */
export class Controller {
  constructor(machine, law) {
    const part = machine.description.laws[law];
    Object.assign(this, { machine, law, isAwake: false });
    [this.settings, this.memory, this.demand, this.command, this.report] =
      machine.place(part, ["settings", "memory", "demand", "command", "report"]);
    const { [`${part.prefix}_wake`]: wake, [`${part.prefix}_step`]: step } = machine.functions;
    const [settings, memory, demand, command, report] =
      [this.settings, this.memory, this.demand, this.command, this.report].map(addressOf);
    this.calls = {
      wake: (readings) => wake(settings, readings, memory),
      step: (readings, elapsed) => step(settings, memory, readings, demand, elapsed, memory, command, report),
    };
    restore(this.settings, part.settings);
  }

  /** Initialises the memory at readings of sensors, and sets the demand to their angles. */
  wake(readings) {
    this.calls.wake(addressOf(readings));
    restore(this.demand, save(this.demand).fill(0));
    this.demand.angle.set(readings.angle);
    this.isAwake = true;
  }

  /** Steps the law by a control cycle (s since the last one) at readings; returns `command`. */
  step(readings, elapsed = this.machine.cycle) {
    if (!this.isAwake) throw new Error("wake the controller at readings before its first step");
    this.calls.step(addressOf(readings), elapsed);
    return this.command;
  }
}
