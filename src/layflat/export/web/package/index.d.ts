declare const place: unique symbol;

/** Struct in the module's memory: its fields read and write that memory. */
export interface Struct {
  readonly [place]: unknown;
}

/** Returns a copy of a struct's numbers, which `restore` takes back. */
export function save(struct: Struct): Float64Array;
/** Sets a struct's numbers to those of `save`. */
export function restore(struct: Struct, numbers: ArrayLike<number>): void;

/** Array of numbers in the module's memory. */
export interface Row extends Struct, Iterable<number> {
  readonly length: number;
  [index: number]: number;
  set(values: ArrayLike<number>): void;
}

/** Structs of the control laws. */
export interface Laws {
@LAWS@
}

/** Plant: arm, joints, hoses and valves; it is advanced by its caller. */
export interface Plant {
  readonly machine: Machine;
@PLANT@
  /**
   * Sets the state to rest: angles (rad), and absolute pressures of hoses A and B (Pa; default: those that hold the
   * arm), a number a joint each.
   */
  rest(angles?: ArrayLike<number>, pressuresA?: ArrayLike<number>, pressuresB?: ArrayLike<number>): void;
  /** Sets voltages, and fractions of brake, dither and supply, to a controller's command; they hold until the next call. */
  drive(command: Laws[keyof Laws]["command"]): void;
  /** Advances by steps of `cycle / steps` s, by default a control cycle; fills `outputs`. */
  advance(steps?: number, isNewCycle?: boolean): void;
  /** Reads the sensors into `readings`, with the standard normal samples in `noise`, and returns these. */
  sample(): Plant["readings"];
}

/** Control law with its settings and memory. */
export interface Controller<L extends keyof Laws> {
  readonly machine: Machine;
  readonly law: L;
  readonly settings: Laws[L]["settings"];
  readonly memory: Laws[L]["memory"];
  readonly demand: Laws[L]["demand"];
  readonly command: Laws[L]["command"];
  readonly report: Laws[L]["report"];
  /** Initialises the memory at readings of sensors, and sets the demand to their angles. */
  wake(readings: Plant["readings"]): void;
  /** Steps the law by a control cycle (s since the last one) at readings; returns `command`. */
  step(readings: Plant["readings"], elapsed?: number): Laws[L]["command"];
}

/** Machine: makes plants and controllers, whose memory lasts as long as the machine. */
export interface Machine {
  readonly name: string;
  readonly title: string;
  /** names of the joints, from base to tip */
  readonly joints: readonly string[];
  /** control cycle, s */
  readonly cycle: number;
  /** steps of the plant in a control cycle */
  readonly steps: number;
  readonly laws: readonly (keyof Laws)[];
  /** Returns a new plant at rest at zero angles. */
  plant(): Plant;
  /** Returns a new controller of one of `laws`. */
  controller<L extends keyof Laws>(law: L): Controller<L>;
  /** Returns a new controller of the machine's own law, the first of `laws`. */
  controller(): Controller<keyof Laws>;
}

export type Source = WebAssembly.Module | BufferSource | Response;

/** Loads the machine; `source` is its module, by default the file beside this one. */
export function load(source?: Source | Promise<Source>): Promise<Machine>;

@STRUCTS@
