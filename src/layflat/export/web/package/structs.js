// Structs in a module's memory as objects: every field by its name, nested structs and arrays as in C.

const BYTES = 8; // of every number

/** Memory of a module, which the structs are placed in, one behind the other. */
export class Heap {
  constructor(memory, start) {
    this.memory = memory;
    this.end = start;
    this.refresh();
  }

  refresh() {
    this.numbers = new Float64Array(this.memory.buffer);
    this.integers = new BigInt64Array(this.memory.buffer);
  }

  /** Returns the index, in numbers, of a new place for `count` numbers. */
  allocate(count) {
    const index = this.end / BYTES;
    this.end += count * BYTES;
    const missing = this.end - this.memory.buffer.byteLength;
    if (missing > 0) this.memory.grow(Math.ceil(missing / 65536));
    this.refresh();
    return index;
  }
}

/** Classes of a table of structs: {name: [[field, type, count], ...]}; count 0 is a single item. */
export class StructTable {
  constructor(structs) {
    this.structs = structs;
    this.classes = new Map();
  }

  /** Returns the number of numbers in an item of a type. */
  size(type) {
    if (type === "real" || type === "integer") return 1;
    return this.structs[type].reduce((sum, [, inner, count]) => sum + this.size(inner) * (count || 1), 0);
  }

  /** Returns the object, or the array of objects, at an index of the heap. */
  view(heap, type, index, count = 0) {
    if (type === "real") return new Row(heap, index, count);
    const size = this.size(type);
    if (count) return Object.freeze(Array.from({ length: count }, (_, i) => this.view(heap, type, index + i * size)));
    if (!this.classes.has(type)) this.classes.set(type, this.makeClass(type));
    return new (this.classes.get(type))(heap, index);
  }

  makeClass(type) {
    const table = this;
    const nested = [];
    class View extends Struct {
      constructor(heap, index) {
        super(heap, index, table.size(type));
        for (const [name, inner, count, offset] of nested) {
          Object.defineProperty(this, name, { value: table.view(heap, inner, index + offset, count), enumerable: true });
        }
        Object.freeze(this);
      }
    }
    let offset = 0;
    for (const [name, inner, count] of this.structs[type]) {
      if (inner === "integer") defineInteger(View.prototype, name, offset);
      else if (inner === "real" && !count) defineNumber(View.prototype, name, offset);
      else nested.push([name, inner, count, offset]);
      offset += this.size(inner) * (count || 1);
    }
    return View;
  }
}

const PLACE = Symbol("place"); // beside the fields, whose names are the machine's

/** Struct in memory: `length` numbers from `index` on. */
class Struct {
  constructor(heap, index, length) {
    Object.defineProperty(this, PLACE, { value: { heap, index, length } });
  }
}

/** Returns the index of a struct's first number in the heap. */
export function indexOf(struct) {
  return struct[PLACE].index;
}

/** Returns the address of a struct, or of the first of an array of them, in the module's memory. */
export function addressOf(struct) {
  return BYTES * (struct[PLACE] ?? struct[0][PLACE]).index;
}

/** Returns a copy of a struct's numbers, which `restore` takes back. */
export function save(struct) {
  const { heap, index, length } = struct[PLACE];
  return heap.numbers.slice(index, index + length);
}

/** Sets a struct's numbers to those of `save`. */
export function restore(struct, numbers) {
  const { heap, index, length } = struct[PLACE];
  if (numbers.length !== length) throw new RangeError(`the struct has ${length} numbers, not ${numbers.length}`);
  heap.numbers.set(numbers, index);
}

function defineNumber(prototype, name, offset) {
  Object.defineProperty(prototype, name, {
    get() { const { heap, index } = this[PLACE]; return heap.numbers[index + offset]; },
    set(value) { const { heap, index } = this[PLACE]; heap.numbers[index + offset] = value; },
    enumerable: true,
  });
}

function defineInteger(prototype, name, offset) {
  Object.defineProperty(prototype, name, {
    get() { const { heap, index } = this[PLACE]; return Number(heap.integers[index + offset]); },
    set(value) { const { heap, index } = this[PLACE]; heap.integers[index + offset] = BigInt(value); },
    enumerable: true,
  });
}

/** Array of numbers in memory. */
class Row extends Struct {
  constructor(heap, index, length) {
    super(heap, index, length);
    for (let i = 0; i < length; i++) defineNumber(this, i, i);
    Object.defineProperty(this, "length", { value: length });
    Object.freeze(this);
  }

  set(values) {
    if (values.length !== this.length) throw new RangeError(`set takes ${this.length} numbers, not ${values.length}`);
    for (let i = 0; i < this.length; i++) this[i] = values[i];
  }

  *[Symbol.iterator]() {
    for (let i = 0; i < this.length; i++) yield this[i];
  }
}
