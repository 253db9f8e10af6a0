// Compiled, not run: the types fit the way the package is used.
import { Body, Place, Refused } from "vademecum-eval";
import { World } from "vademecum-eval/world";

export async function use(bytes: ArrayBuffer): Promise<number> {
  const body = await Body.open(bytes, { precision: "double", parameters: { stiffness: 1 }, density: 2 });
  const place: Place = body.locate([0, 0, 0]);
  if (body.counts.loadNodes === 0) throw new Refused("nothing to press");
  body.push(place, [0, 0, -1]);
  body.setParameters({ stiffness: 2 });
  const status: "moving" | "at-rest" = body.step(10);
  const surface: Float32Array | Float64Array = body.surface("velocity");
  body.press({ radius: 1, speed: 1, centre: [0, 0, 0] });
  const [kinetic]: Float64Array = body.read(body.quantities[0].name, 0);
  const saved: Uint8Array = body.save();
  const how: "as-saved" | "carried" = body.restore(saved);
  // @ts-expect-error a probe has a name
  body.probe(0);
  // @ts-expect-error bodies are opened, not constructed
  new Body();
  return surface[0] + kinetic + how.length + body.probe("tip") + (status === "moving" ? body.energy : 0);
}

export async function fall(bytes: ArrayBuffer): Promise<number> {
  const world = await World.create({ step: 1e-3, gravity: [0, 0, -9.81] });
  const cube: number = world.add(await world.open(bytes), { position: [0, 0, 1], path: [[0, 0, 0, 0]] });
  const floor = world.addRigid({ nodes: [[0, 0, 0], [1, 0, 0], [0, 1, 0]], triangles: [[0, 1, 2]] });
  world.touch(cube, floor, { friction: 0.5, nodes: "first" });
  world.join("ball", { member: cube, port: "pin" }, { member: floor, at: [0, 0, 0] }, { breaksAt: 3 });
  // @ts-expect-error a port or a point
  world.join("ball", { member: cube }, { member: floor, at: [0, 0, 0] });
  world.pull(1, cube, { nodes: [0], weights: [1] }, { target: [0, 0, 0], stiffness: 1 });
  const { energy, pressed } = world.step(10);
  const nodes: Float32Array = world.surfaces("velocity").nodes;
  return energy + pressed + nodes[0] + world.touches[0].force[2] + (world.joints[0].broken ? 1 : 0);
}
