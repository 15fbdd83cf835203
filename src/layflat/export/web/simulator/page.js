// The page: loads a machine, runs it in time with the screen, and keeps its state in the address.

import { Controls } from "./controls.js";
import { Drawing } from "./drawing.js";
import { anglesAt, nearestLink, pose } from "./geometry.js";
import { fragmentOf, defaultOptions, degrees, machineOf, optionsOf } from "./options.js";
import { Plot } from "./plot.js";
import { Simulation } from "./simulation.js";

const TARGET_RADIUS = 24; // px within which a pointer takes the target
const MINUS = "\u2212";

class Page {
  constructor(machines, modules) {
    Object.assign(this, { machines, modules, compiled: new Map(), isRunning: true, last: 0, frames: 0 });
    const find = (id) => document.getElementById(id);
    this.find = find;
    this.drawing = new Drawing(find("drawing"));
    this.plot = new Plot(find("plot"));
    const roots = { motion: find("motion"), plant: find("plant"), control: find("control"), speed: find("speed") };
    this.controls = new Controls(roots, (key, value) => this.change(key, value));
    this.connect();
  }

  connect() {
    const { find } = this;
    const menu = find("machine");
    for (const { description } of this.machines) menu.append(new Option(description.title, description.name));
    menu.closest("label").hidden = this.machines.length < 2;
    menu.addEventListener("change", () => this.load(`#machine=${menu.value}`));
    find("run").addEventListener("click", () => this.setRunning(!this.isRunning));
    find("reset").addEventListener("click", () => this.simulation.reset());
    find("defaults").addEventListener("click", () => this.load(`#machine=${menu.value}`));
    find("share").addEventListener("click", () => this.share());
    find("theme").addEventListener("click", () => this.changeTheme());
    addEventListener("hashchange", () => { if (location.hash !== this.address) this.load(location.hash); });
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.readColors());
    const canvas = find("drawing");
    canvas.addEventListener("pointerdown", (event) => this.grasp(event));
    canvas.addEventListener("pointermove", (event) => this.drag(event));
    for (const type of ["pointerup", "pointercancel"]) canvas.addEventListener(type, () => this.release());
  }

  /** Loads the machine and the options of an address. */
  async load(fragment) {
    const entry = this.machines.find(({ description }) => description.name === machineOf(fragment)) ?? this.machines[0];
    if (!this.compiled.has(entry.module)) this.compiled.set(entry.module, compiled(this.modules[entry.module]));
    const simulation = await Simulation.load(entry, await this.compiled.get(entry.module));
    this.defaults = defaultOptions(entry, simulation.parameters);
    this.options = optionsOf(fragment, entry, this.defaults);
    simulation.apply(this.options);
    simulation.reset();
    this.simulation = simulation;
    this.controls.build(entry, this.options);
    this.find("machine").value = entry.description.name;
    this.find("view").textContent = simulation.geometry.isUpright ? "Seen from the side." : "Seen from above.";
    this.buildReadings();
    this.writeAddress();
    this.readColors();
    this.failed("");
  }

  change(key, value) {
    this.options[key] = value;
    this.simulation.apply(this.options);
    if (key === "law") this.controls.build(this.simulation.entry, this.options);
    else this.controls.show(this.options);
    this.writeAddress();
  }

  writeAddress() {
    this.address = fragmentOf(this.simulation.machine.name, this.options, this.defaults);
    clearTimeout(this.writing); // browsers refuse many changes of an address in a second
    this.writing = setTimeout(() => location.replace(this.address), 150);
  }

  setRunning(isRunning) {
    this.isRunning = isRunning;
    this.find("run").textContent = isRunning ? "Pause" : "Run";
  }

  async share() {
    const link = `${location.href.split("#")[0]}${this.address}`;
    const button = this.find("share");
    try {
      await navigator.clipboard.writeText(link);
      button.textContent = "Link copied";
    } catch {
      prompt("Link to this state", link);
    }
    setTimeout(() => { button.textContent = "Copy link"; }, 1500);
  }

  changeTheme() {
    const root = document.documentElement;
    const now = root.dataset.theme || (matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light");
    root.dataset.theme = now === "dark" ? "light" : "dark";
    this.readColors();
  }

  readColors() {
    const style = getComputedStyle(document.documentElement);
    const color = (name) => style.getPropertyValue(`--${name}`).trim();
    const names = ["text", "quiet", "grid", "axis", "panel", "link", "base", "sector", "payload", "target", "halo", "pull"];
    this.colors = Object.fromEntries(names.map((name) => [name, color(name)]));
    Object.assign(this.colors, {
      hoseA: color("hose-a"), hoseB: color("hose-b"), joints: [color("joint-1"), color("joint-2")],
      font: getComputedStyle(document.body).fontFamily,
    });
  }

  buildReadings() {
    const rows = this.simulation.machine.joints.map((joint) => {
      const row = document.createElement("tr");
      row.append(Object.assign(document.createElement("th"), { textContent: joint, scope: "row" }));
      for (let i = 0; i < 5; i++) row.append(document.createElement("td"));
      return row;
    });
    this.find("readings").replaceChildren(...rows);
    this.cells = rows.map((row) => [...row.querySelectorAll("td")]);
  }

  showReadings() {
    const { outputs, targets, parameters, plant, time } = this.simulation;
    const gauge = (pressure) => (pressure - parameters.around.ambient_pressure) / 1e5;
    outputs.forEach((output, j) => {
      const values = [
        [degrees(output.angle), 1], [degrees(targets[j] - output.angle), 1], [gauge(output.pressure_a), 2],
        [gauge(output.pressure_b), 2], [plant.inputs[j].voltage, 2],
      ];
      values.forEach(([value, digits], i) => {
        this.cells[j][i].textContent = value.toFixed(digits).replace(/^-(?=0\.0*$)/, "").replace("-", MINUS);
      });
    });
    this.find("time").textContent = `${time.toFixed(1)} s`;
  }

  /** Draws a frame at a time of the clock, ms, and asks for the next one. */
  frame(now) {
    const elapsed = (now - this.last) / 1000;
    this.last = now;
    if (this.simulation) {
      try {
        if (this.isRunning) this.simulation.advance(elapsed);
      } catch (error) {
        this.failed(`${error.message}. The machine starts again.`);
        this.simulation.reset();
      }
      this.drawing.draw(this.simulation, this.colors);
      this.plot.draw(this.simulation, this.colors);
      if (this.frames++ % 6 === 0) this.showReadings();
    }
    requestAnimationFrame((next) => this.frame(next));
  }

  failed(message) {
    this.find("failed").textContent = message;
    this.find("failed").hidden = !message;
  }

  grasp(event) {
    const { simulation } = this;
    const place = this.pointer(event);
    const target = pose(simulation.geometry, [...simulation.targets]).points.at(-1);
    const away = Math.hypot(place[0] - target[0], place[1] - target[1]) * this.drawing.view.scale;
    const arm = pose(simulation.geometry, simulation.angles);
    const near = nearestLink(arm, place);
    event.currentTarget.setPointerCapture(event.pointerId);
    this.isOnTarget = away < TARGET_RADIUS || near.distance * this.drawing.view.scale > TARGET_RADIUS;
    if (!this.isOnTarget) simulation.pull = { ...near, to: place };
    this.isGrasped = true;
    this.drag(event);
  }

  drag(event) {
    if (!this.isGrasped) return;
    const { simulation, options } = this;
    const place = this.pointer(event);
    if (simulation.pull) {
      simulation.pull.to = place;
    } else if (this.isOnTarget) {
      options.program = "hand";
      const angles = anglesAt(simulation.geometry, simulation.entry.strokes, place, [...simulation.targets]);
      angles.forEach((angle, j) => { options[`target${j + 1}`] = Math.round(degrees(angle)); });
      this.change("program", "hand");
    }
  }

  release() {
    this.isGrasped = false;
    this.simulation.pull = null;
  }

  pointer(event) {
    const box = event.currentTarget.getBoundingClientRect();
    return this.drawing.place(event.clientX - box.left, event.clientY - box.top);
  }
}

/** Returns the compiled module of a text in base64. */
function compiled(text) {
  return WebAssembly.compile(Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0)));
}

/** Starts the page with its machines and their modules. */
export async function start(machines, modules) {
  const page = new Page(machines, modules);
  globalThis.simulator = page; // for those who look from the console
  page.setRunning(!matchMedia("(prefers-reduced-motion: reduce)").matches);
  try {
    await page.load(location.hash);
    page.frame(performance.now());
  } catch (error) {
    page.failed(`The simulation does not start: ${error.message}. It needs a browser with WebAssembly SIMD, of 2023 or later.`);
  }
}
