// Options of the page: their ranges, units and defaults, and their texts in the page's address.

const FACTOR = { unit: "×", digits: 2, logarithmic: true };

/** Sliders of the plant; `base` makes the default of a machine. */
export const PLANT_OPTIONS = [
  { key: "supply", label: "Supply pressure (gauge)", unit: "bar", digits: 1, min: 1, max: 8, step: 0.1,
    base: ({ parameters }) => (parameters.around.supply_pressure - parameters.around.ambient_pressure) / 1e5 },
  { key: "valve", label: "Valve size", ...FACTOR, min: 0.1, max: 20, base: () => 1 },
  { key: "brake", label: "Brake torque", ...FACTOR, min: 0.1, max: 10, base: () => 1 },
  { key: "payload", label: "Payload at the tip", unit: "kg", digits: 1, min: 0, max: 6, step: 0.1,
    base: ({ parameters }) => parameters.around.payload },
];

const PAPER_GAINS = [
  { key: "error", label: "Error gain", ...FACTOR, min: 0.1, max: 10, base: () => 1, hint: "volts per error of the angle" },
  { key: "pressure", label: "Pressure gain", ...FACTOR, min: 0.1, max: 10, base: () => 1,
    hint: "volts per differential pressure: damping" },
  { key: "integral", label: "Integral gain", ...FACTOR, min: 0.1, max: 10, base: () => 1,
    hint: "short-term integral, close to the demand" },
];

const TRACKING_GAINS = [
  { key: "stiffness", label: "Feedback of the angle", ...FACTOR, min: 0.1, max: 10, base: () => 1,
    hint: "acceleration per error of the angle" },
  { key: "damping", label: "Feedback of the velocity", ...FACTOR, min: 0.1, max: 10, base: () => 1,
    hint: "acceleration per error of the velocity" },
];

/** Sliders of each control law's gains. */
export const GAIN_OPTIONS = { paper: PAPER_GAINS, tracking: TRACKING_GAINS };

/** Demands over time. */
export const PROGRAMS = { hand: "By hand", steps: "Steps", sine: "Sine" };
export const SPEEDS = [1, 0.5, 0.25, 0.1];

/** Returns the options that a machine begins with. */
export function defaultOptions(entry, parameters) {
  const { joints, laws } = entry.description;
  const options = { law: Object.keys(laws)[0], program: "steps", period: 4, speed: 1, noise: 1 };
  joints.forEach((_, j) => { options[`target${j + 1}`] = Math.round(0.6 * degrees(entry.strokes[j])) * (j % 2 ? -1 : 1); });
  for (const { key, base } of [...PLANT_OPTIONS, ...PAPER_GAINS, ...TRACKING_GAINS]) options[key] = rounded(base({ parameters }));
  return options;
}

/** Returns the address's fragment of a machine with options: its name, and what differs from the defaults. */
export function fragmentOf(name, options, defaults) {
  const words = new URLSearchParams({ machine: name });
  for (const key of Object.keys(defaults)) if (options[key] !== defaults[key]) words.set(key, options[key]);
  return `#${words}`;
}

/** Returns the machine's name that an address asks for, "" for none. */
export function machineOf(fragment) {
  return new URLSearchParams(fragment.replace(/^#/, "")).get("machine") ?? "";
}

/** Returns the options of an address over the defaults; words that are no value of an option are left out. */
export function optionsOf(fragment, entry, defaults) {
  const words = new URLSearchParams(fragment.replace(/^#/, ""));
  const options = { ...defaults };
  for (const key of Object.keys(defaults)) {
    const text = words.get(key);
    if (text === null) continue;
    const allowed = allowedWords(key, entry);
    if (allowed) options[key] = allowed.find((word) => String(word) === text) ?? defaults[key];
    else options[key] = clampedTo(rangeOf(key, entry), Number(text), defaults[key]);
  }
  return options;
}

function allowedWords(key, entry) {
  if (key === "law") return Object.keys(entry.description.laws);
  if (key === "program") return Object.keys(PROGRAMS);
  return { speed: SPEEDS, noise: [0, 1] }[key];
}

/** Returns the range of a number: [min, max]. */
export function rangeOf(key, entry) {
  if (key === "period") return [1, 12];
  if (key.startsWith("target")) {
    const limit = Math.floor(degrees(entry.strokes[Number(key.slice(6)) - 1]));
    return [-limit, limit];
  }
  const option = [...PLANT_OPTIONS, ...PAPER_GAINS, ...TRACKING_GAINS].find((one) => one.key === key);
  return [option.min, option.max];
}

function clampedTo([min, max], value, otherwise) {
  return Number.isFinite(value) ? Math.min(Math.max(value, min), max) : otherwise;
}

export function degrees(radians) {
  return (radians * 180) / Math.PI;
}

export function radians(angle) {
  return (angle * Math.PI) / 180;
}

/** Returns a number with four digits, short in an address. */
export function rounded(value) {
  return Number(value.toPrecision(4));
}
