// What every place of the tests does with a world: in Node and on a page the same numbers must come out, bit for bit.

/** A floor of two triangles, rigid. */
export const FLOOR = { nodes: [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], triangles: [[0, 1, 2], [0, 2, 3]] };

/** Two soft cubes over a floor. */
export async function cubes(World, bytes, options = {}) {
  const world = await World.create({ step: 1e-3, gravity: [0, 0, -9.81], contacts: 128, ...options });
  const file = await world.open(bytes);
  const [below, above] = [0.002, 0.05].map((z) => world.add(file, { position: [0, 0, z] }));
  const floor = world.addRigid(FLOOR);
  world.touch(below, floor, { friction: 0.5, restitution: 0.2, nodes: "first" });
  world.touch(above, below, { friction: 0.5, restitution: 0.2 });
  return { world, file, below, above, floor };
}

/** All numbers of a fall, as the hexadecimal digits of their bits. */
export async function fall(World, bytes) {
  const { world, above } = await cubes(World, bytes);
  const numbers = [];
  for (let turn = 0; turn < 20; turn++) {
    if (turn === 10) world.pull(1, above, { nodes: [0], weights: [1] }, { target: [0.1, 0, 0.2], stiffness: 50, damping: 1 });
    const { energy, potential, pressed, deepest } = world.step(10);
    numbers.push(energy, potential, pressed, deepest, ...world.poses.flatMap(({ position, rotation }) => [...position, ...rotation]));
    numbers.push(...world.touches.flatMap(({ place, force }) => [...place, ...force]));
  }
  numbers.push(...world.surfaces().nodes, ...world.surfaces("velocity").field, ...world.save());
  return Array.from(new BigUint64Array(new Float64Array(numbers).buffer), (bits) => bits.toString(16)).join(" ");
}
