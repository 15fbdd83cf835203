// node trace.mjs FOLDER INPUTS: a machine in closed loop; prints the file with what its joints did, and times.
// INPUTS: {law, demand, noise: file of [cycle][joint][2] doubles}.

import { readFile, writeFile } from "node:fs/promises";
import { pathToFileURL } from "node:url";

const [folder, inputs, out] = process.argv.slice(2);
const { load } = await import(pathToFileURL(`${folder}/index.js`));
const { law, demand, noise: noiseFile } = JSON.parse(await readFile(inputs));
const bytes = await readFile(noiseFile);
const noise = new Float64Array(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
const machine = await load();
const plant = machine.plant();
const controller = machine.controller(law);
const joints = machine.joints.length;
const cycles = noise.length / (2 * joints);
controller.wake(plant.sample());
controller.demand.angle.set(demand);
const rows = [];
for (let k = 0; k < cycles; k++) {
  plant.noise.forEach((one, j) => {
    one.angle = noise[2 * (k * joints + j)];
    one.pressure = noise[2 * (k * joints + j) + 1];
  });
  const command = controller.step(plant.sample());
  plant.drive(command);
  plant.advance();
  plant.outputs.forEach((one, j) => {
    const { brake, dither, supply } = command.shares[j];
    rows.push(one.angle, one.velocity, one.pressure_a, one.pressure_b, command.voltage[j], brake, dither, supply);
  });
}
await writeFile(out, new Uint8Array(Float64Array.from(rows).buffer));
console.log(JSON.stringify({ cycles, joints: machine.joints, step: plant.state.step, steps: machine.steps }));
