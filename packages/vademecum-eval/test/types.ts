// Compiled, not run: the types fit the way the package is used.
import { Body, Place, Refused } from "vademecum-eval";

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
