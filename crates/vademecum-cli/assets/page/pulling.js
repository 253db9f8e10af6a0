// Pointers and keys on a page with a world: a press on a body holds it by a spring, beside it the view turns.
import { find, say } from "vademecum/elements";
import { SECTION } from "vademecum/evaluator";
import { add, cross, norm, scaled, sub } from "vademecum/vectors";

/** Frequency [Hz] of a body on the spring of a hand, and the damping ratio there. */
const SWING = 2.5, RATIO = 0.7;
/** A held body follows the hand by this share of its way where it gives way by itself. */
const FOLLOWS = 0.5;

/** A direction of a body of this quaternion in space, and back. */
export function toSpace(d, [w, ...v]) {
  const twice = scaled(cross(v, d), 2);
  return add(add(d, scaled(twice, w)), cross(v, twice));
}

export const toBody = (d, [w, x, y, z]) => toSpace(d, [w, -x, -y, -z]);

export class Pulling {
  constructor(canvas, world, camera) {
    Object.assign(this, { canvas, world, camera, held: new Map(), turned: -Infinity, last: null, next: 1 });
    const on = (name, act) => canvas.addEventListener(name, act, { passive: false });
    on("pointerdown", (event) => this.down(event));
    on("pointermove", (event) => this.move(event));
    for (const name of ["pointerup", "pointercancel", "lostpointercapture"]) on(name, (event) => this.lift(event.pointerId));
    on("contextmenu", (event) => event.preventDefault());
    on("wheel", (event) => {
      event.preventDefault();
      this.remember();
      camera.closer(Math.exp(-event.deltaY * 0.0015));
    });
    document.addEventListener("keydown", (event) => {
      canvas.classList.add("keys");
      this.key(event);
    });
  }

  /** Keeps the view for "undo": once for a row of turns of the wheel or strokes of a key. */
  remember() {
    const now = performance.now();
    if (now - this.turned > 600) this.camera.remember();
    this.turned = now;
  }

  where(event) {
    const box = this.canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }

  down(event) {
    event.preventDefault();
    this.canvas.classList.remove("keys");
    this.canvas.focus({ preventScroll: true });
    this.canvas.setPointerCapture(event.pointerId);
    const at = this.where(event);
    const plain = event.button === 0 && !event.shiftKey;
    const hit = plain ? this.world.crowd.pick(this.camera.ray(...at)) : null;
    if (hit && this.grip(hit)) {
      this.held.set(event.pointerId, { kind: "pull", at, ...this.grab(hit) });
      return;
    }
    if (hit) say(hit.kind === 0 ? "This part was not made pushable when the body was built." : "");
    if (this.held.size === 0) this.camera.remember();
    this.held.set(event.pointerId, { kind: plain ? "orbit" : "pan", at });
  }

  /** What a hand holds of what was met; null of what cannot be pulled. */
  grip({ member, kind, place, at }) {
    const { stage } = this.world;
    if (kind === 1) return place;
    if (kind !== -1 || stage.mass(member) === 0) return null;
    const { position, rotation } = stage.poses()[member];
    return toBody(sub(at, position), rotation);
  }

  /** Lays a hand on what was met; its number, and where it is. */
  grab(hit) {
    const id = this.next++;
    this.last = hit.member;
    this.world.stage.pull(id, hit.member, this.grip(hit), { target: hit.at, ...this.spring(hit) });
    say("");
    return { id, target: hit.at };
  }

  /** Stiffness and damping of a hand. */
  spring({ member, place }) {
    const { stage, stiffness } = this.world;
    const mass = stage.mass(member);
    if (mass > 0) {
      const omega = 2 * Math.PI * SWING * Math.sqrt(stiffness);
      return { stiffness: mass * omega ** 2, damping: 2 * RATIO * mass * omega };
    }
    const compliance = this.compliance(member, place);
    return { stiffness: compliance > 0 ? (stiffness * FOLLOWS) / (1 - FOLLOWS) / compliance : 1, damping: 0 };
  }

  /** Static compliance of a place [m/N] by the modes of its file, in the mean over the directions. */
  compliance(member, { nodes, weights }) {
    const { stage } = this.world;
    const { file } = stage.members[member];
    const [basis, lambda] = [SECTION.surfaceBasis, SECTION.eigenvalues].map((kind) => stage.section(file, kind));
    if (!basis || !lambda) return 0;
    const { modes } = stage.files[file];
    let sum = 0;
    for (let c = 0; c < 3; c++) {
      for (let k = 0; k < modes; k++) {
        const along = nodes.reduce((all, node, i) => all + weights[i] * basis[(3 * node + c) * modes + k], 0);
        if (lambda[k] > 0) sum += along ** 2 / lambda[k];
      }
    }
    return sum / 3;
  }

  move(event) {
    const at = this.where(event);
    const hand = this.held.get(event.pointerId);
    if (!hand) {
      if (event.pointerType !== "mouse") return;
      const hit = this.world.crowd.pick(this.camera.ray(...at));
      this.canvas.classList.toggle("press", hit !== null && this.grip(hit) !== null);
      return;
    }
    const [dx, dy] = [at[0] - hand.at[0], at[1] - hand.at[1]];
    hand.at = at;
    if (hand.kind === "pull") {
      hand.target = add(hand.target, this.camera.inPlane(hand.target, dx, dy));
      this.world.stage.movePull(hand.id, hand.target);
    } else if (hand.kind === "pan") this.camera.pan(dx, dy);
    else this.turn(hand, dx, dy);
  }

  /** Turns with one finger; two fingers beside the bodies zoom and pan. */
  turn(hand, dx, dy) {
    const [other] = [...this.held.values()].filter((one) => one !== hand && one.kind === "orbit");
    if (!other) return this.camera.orbit(dx, dy);
    const gap = (at) => Math.hypot(at[0] - other.at[0], at[1] - other.at[1]) || 1;
    this.camera.closer(gap(hand.at) / gap([hand.at[0] - dx, hand.at[1] - dy]));
    this.camera.pan(dx / 2, dy / 2);
  }

  lift(pointer) {
    const hand = this.held.get(pointer);
    this.held.delete(pointer);
    if (hand?.kind === "pull") this.world.stage.release(hand.id);
  }

  /** Throws the body that was pulled last, or the first that moves, so high as the bodies are large, at the gravity there is. */
  throw() {
    const { stage, crowd, camera, gravity } = this.world;
    const member = this.last !== null && stage.mass(this.last) > 0 ? this.last : crowd.seen.find((one) => stage.mass(one) > 0);
    if (member === undefined) return say("Nothing here moves freely.");
    const strength = norm(gravity);
    const up = strength > 0 ? scaled(gravity, -1 / strength) : [0, 1, 2].map((axis) => (axis === camera.up ? 1 : 0));
    const speed = Math.sqrt(1.2 * (strength || 9.81) * crowd.size);
    const across = [up[1], up[2], up[0]];
    stage.throw(member, scaled(up, speed), scaled(across, (2 * Math.PI * 9.81) / (2 * speed + 9.81)));
  }

  key(event) {
    if (event.target.closest?.("input, select, summary, button") || event.ctrlKey || event.metaKey || event.altKey) return;
    const { camera, world } = this;
    const turn = { ArrowLeft: [-20, 0], ArrowRight: [20, 0], ArrowUp: [0, -20], ArrowDown: [0, 20] }[event.key];
    const closer = (factor) => () => {
      this.remember();
      camera.closer(factor);
    };
    const acts = {
      " ": () => world.pause(!world.paused), ".": () => find("step").click(), "0": () => find("rest").click(), t: () => this.throw(),
      r: () => find("home").click(), u: () => find("undo").click(), w: () => find("wire").click(), "?": () => find("help").click(),
      "+": closer(1.15), "=": closer(1.15), "-": closer(1 / 1.15),
    };
    if (turn && document.activeElement !== this.canvas) return;
    const act = turn ? () => {
      this.remember();
      camera.orbit(...turn);
    } : acts[event.key];
    if (!act) return;
    event.preventDefault();
    act();
  }
}
