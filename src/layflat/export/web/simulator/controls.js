// Sliders, choices and buttons of the page, made from the tables of options.

import { GAIN_OPTIONS, PLANT_OPTIONS, PROGRAMS, rangeOf, rounded, SPEEDS } from "./options.js";

const LAW_NAMES = { paper: "Paper", tracking: "Tracking" };

/** Returns a new element with attributes and children. */
function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [key, value] of Object.entries(attributes)) {
    if (key === "class") made.className = value;
    else if (key in made) made[key] = value;
    else made.setAttribute(key, value);
  }
  made.append(...children);
  return made;
}

/** Controls of the options; `change(key, value)` is called when one of them is moved. */
export class Controls {
  constructor(roots, change) {
    Object.assign(this, { roots, change, updates: [] });
  }

  /** Builds all controls anew for a machine and the options' present values. */
  build(entry, options) {
    this.updates = [];
    const { joints, laws } = entry.description;
    const ranged = (option) => ({ ...option, range: [option.min, option.max] });
    const targets = joints.map((joint, j) => {
      const key = `target${j + 1}`;
      const label = joints.length > 1 ? `Target of ${joint}` : "Target";
      return { key, label, unit: "°", digits: 0, step: 1, range: rangeOf(key, entry) };
    });
    const period = { key: "period", label: "Period", unit: "s", digits: 1, step: 0.5, range: rangeOf("period", entry) };
    const lawNames = Object.fromEntries(Object.keys(laws).map((law) => [law, LAW_NAMES[law] ?? law]));
    this.fill("motion", [this.choice("program", "Demand", PROGRAMS), ...targets.map((one) => this.slider(one)), this.slider(period)]);
    this.fill("plant", [...PLANT_OPTIONS.map((one) => this.slider(ranged(one))), this.toggle("noise", "Noise of the sensors")]);
    this.fill("control", [
      this.choice("law", "Control law", lawNames), ...(GAIN_OPTIONS[options.law] ?? []).map((one) => this.slider(ranged(one))),
    ]);
    this.fill("speed", [this.choice("speed", "Speed", Object.fromEntries(SPEEDS.map((one) => [one, one === 1 ? "1×" : `1/${1 / one}×`])))]);
    this.show(options);
  }

  fill(name, children) {
    this.roots[name].replaceChildren(...children);
  }

  /** Shows the options' present values. */
  show(options) {
    for (const update of this.updates) update(options);
  }

  slider({ key, label, unit, digits, step, range, logarithmic, hint }) {
    const [toSlider, toValue] = logarithmic ? [Math.log10, (x) => rounded(10 ** x)] : [Number, Number];
    const [min, max] = range.map(toSlider);
    const input = element("input", { type: "range", id: `option-${key}`, min, max, step: logarithmic ? (max - min) / 200 : step });
    const output = element("output", { htmlFor: input.id });
    input.addEventListener("input", () => {
      const value = toValue(input.valueAsNumber);
      this.change(key, logarithmic && Math.abs(input.valueAsNumber) < 0.02 ? 1 : value);
    });
    this.updates.push((options) => {
      const text = options[key].toFixed(digits).replace("-", "\u2212");
      input.value = toSlider(options[key]);
      output.textContent = logarithmic ? `${unit}\u2009${text}` : unit === "°" ? `${text}${unit}` : `${text} ${unit}`;
      input.setAttribute("aria-valuetext", output.textContent);
    });
    const about = hint ? [element("small", {}, hint)] : [];
    return element("div", { class: "slider" }, element("label", { htmlFor: input.id }, label), output, input, ...about);
  }

  choice(key, label, names) {
    const buttons = Object.entries(names).map(([word, name]) => {
      const input = element("input", { type: "radio", name: key, value: word, id: `option-${key}-${word}` });
      input.addEventListener("change", () => this.change(key, key === "speed" ? Number(word) : word));
      this.updates.push((options) => { input.checked = String(options[key]) === word; });
      return element("span", {}, input, element("label", { htmlFor: input.id }, name));
    });
    return element("fieldset", { class: "choice" }, element("legend", {}, label), ...buttons);
  }

  toggle(key, label) {
    const input = element("input", { type: "checkbox", id: `option-${key}` });
    input.addEventListener("change", () => this.change(key, input.checked ? 1 : 0));
    this.updates.push((options) => { input.checked = options[key] === 1; });
    return element("div", { class: "toggle" }, input, element("label", { htmlFor: input.id }, label));
  }
}
