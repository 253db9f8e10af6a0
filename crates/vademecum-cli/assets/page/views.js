// Which way the body stands, and the buttons that turn it.
import { find } from "vademecum/elements";

/** A body this many times longer than it is thick lies where only one of its ends is held. */
const SLENDER = 3;
/** Supports within this share of a side from its lower end carry the body. */
const FOOT = 0.15;

/** The axis (0, 1, 2) that points upwards: against gravity where the problem in the file has it, away from the ground that the body stands on, else z. */
export function upward(body, problem) {
  const gravity = /^\s*acceleration\s*=\s*\[([^\]]*)\]/m.exec(problem);
  const parts = gravity ? gravity[1].split(",").map((part) => Math.abs(Number(part))) : [];
  const most = Math.max(...parts);
  if (parts.length === 3 && most > 0) return parts.indexOf(most);
  const { low, high } = body.box;
  const sides = [0, 1, 2].map((axis) => high[axis] - low[axis]);
  const standsOn = (axis) => {
    const others = Math.max(...sides.filter((_, other) => other !== axis));
    if (body.held.length === 0 || sides[axis] > SLENDER * others) return false;
    return body.held.every((node) => body.rest[3 * node + axis] <= low[axis] + FOOT * sides[axis]);
  };
  return [2, 1].find(standsOn) ?? 2;
}

/** Buttons of the view, beside what pointers do with it. */
export function viewButtons(camera) {
  const on = (id, act) => find(id).addEventListener("click", act);
  const shown = () => ["x", "y", "z"].forEach((name, axis) => find(`up-${name}`).setAttribute("aria-pressed", String(camera.up === axis)));
  ["x", "y", "z"].forEach((name, axis) => {
    on(`up-${name}`, () => {
      camera.stand(axis);
      shown();
    });
    on(`from-${name}`, () => camera.lookFrom(axis));
  });
  on("home", () => camera.reset());
  on("undo", () => {
    camera.undo();
    shown();
  });
  shown();
  return shown;
}
