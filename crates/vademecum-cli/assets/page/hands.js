// Pointers and keys: a press on the loadable surface is a contact, beside it the view turns. Every finger is its own contact.
import { add, AXES, scaled } from "vademecum/vectors";
import { find, say } from "vademecum/elements";

export class Hands {
  constructor(canvas, player, camera, controls) {
    Object.assign(this, { canvas, player, camera, controls, held: new Map(), turned: -Infinity });
    const on = (name, act) => canvas.addEventListener(name, act, { passive: false });
    on("pointerdown", (event) => this.down(event));
    on("pointermove", (event) => this.move(event));
    for (const name of ["pointerup", "pointercancel", "lostpointercapture"]) on(name, (event) => this.up(event));
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
    document.addEventListener("keyup", (event) => event.key === "Enter" && this.lift("Enter"));
    canvas.addEventListener("blur", () => this.lift("Enter"));
  }

  /** Keeps the view for "undo": once for a row of turns of the wheel or strokes of a key. */
  remember() {
    const now = performance.now();
    if (now - this.turned > 600) this.camera.remember();
    this.turned = now;
  }

  place(event) {
    const box = this.canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }

  pick(at) {
    return this.player.body.pick(this.camera.ray(...at));
  }

  down(event) {
    event.preventDefault();
    this.canvas.classList.remove("keys");
    this.canvas.focus({ preventScroll: true });
    this.canvas.setPointerCapture(event.pointerId);
    const at = this.place(event);
    const hit = event.button === 0 && !event.shiftKey ? this.pick(at) : null;
    if (hit) say(hit.loadable ? "" : this.refused());
    if (hit?.loadable && this.controls.sphere && !this.player.tool) {
      this.lay(event.pointerId, at, hit.point, hit.normal);
    } else if (hit?.loadable) {
      const normal = hit.normal;
      const contact = { kind: "contact", start: at, at, point: hit.point, normal };
      contact.id = this.player.press(hit.point, this.force(contact));
      this.held.set(event.pointerId, contact);
      if (event.pointerType !== "mouse" && navigator.vibrate) navigator.vibrate(8);
    } else {
      const pan = event.button !== 0 || event.shiftKey;
      this.camera.remember();
      this.held.set(event.pointerId, { kind: pan ? "pan" : "orbit", at });
    }
  }

  /** Why a press moves nothing. */
  refused() {
    if (this.player.body.loadTriangles === 0) return "This file has no loadable surface: nothing of it can be pushed.";
    return "This part was not made pushable when the body was built. Press where there are no stripes.";
  }

  move(event) {
    const at = this.place(event);
    const hand = this.held.get(event.pointerId);
    if (!hand) {
      if (event.pointerType === "mouse") this.canvas.classList.toggle("press", this.pick(at)?.loadable === true);
      return;
    }
    const [dx, dy] = [at[0] - hand.at[0], at[1] - hand.at[1]];
    if (hand.kind === "contact") this.slide(hand, at);
    else if (hand.kind === "tool") this.drag(at);
    else if (hand.kind === "pan") this.camera.pan(dx, dy);
    else this.turn(hand, dx, dy);
    hand.at = at;
  }

  /** Turns with one finger; two fingers beside the body zoom and pan. */
  turn(hand, dx, dy) {
    const others = [...this.held.values()].filter((other) => other !== hand && other.kind === "orbit");
    if (others.length === 0) {
      this.camera.orbit(dx, dy);
      return;
    }
    const [other] = others;
    const gap = (at) => Math.hypot(at[0] - other.at[0], at[1] - other.at[1]) || 1;
    this.camera.closer(gap([hand.at[0] + dx, hand.at[1] + dy]) / gap(hand.at));
    this.camera.pan(dx / 2, dy / 2);
  }

  /** A dragged contact pulls from where it was put; the others slide over the surface with the pointer. */
  slide(contact, at) {
    contact.at = at;
    if (find("direction").value !== "drag") {
      const hit = this.pick(at);
      if (hit?.loadable) Object.assign(contact, { point: hit.point, normal: hit.normal });
    }
    this.player.move(contact.id, contact.point, this.force(contact));
  }

  /** Lays the sphere down where it just touches; from there it goes as deep as is set. */
  lay(name, at, point, normal) {
    const { radius, friction } = this.controls.sphere;
    const { player } = this;
    const moved = add(player.body.place(point, player.body.rest), player.evaluator.point(point));
    const centre = add(moved, scaled(normal, 1.02 * radius));
    // Harder than that no hand pushes, and the model would not describe it.
    const most = 30 * player.body.flexible.force;
    player.hold({ radius, friction, speed: this.controls.toolSpeed, most, centre, target: this.below(point, normal), point });
    this.held.set(name, { kind: "tool", at });
  }

  /** Where the sphere goes: as deep as is set under the place of the body at rest, which does not run away from it. */
  below(point, normal) {
    const { radius, depth } = this.controls.sphere;
    return add(this.player.body.place(point, this.player.body.rest), scaled(normal, radius - depth));
  }

  /** The sphere goes over the body with the pointer, and stays where it is beside it. */
  drag(at) {
    const hit = this.pick(at);
    if (hit?.loadable && this.controls.sphere) this.player.moveTool(this.below(hit.point, hit.normal), hit.point);
  }

  up(event) {
    this.lift(event.pointerId);
  }

  lift(name) {
    const hand = this.held.get(name);
    if (!hand) return;
    this.held.delete(name);
    if (hand.kind === "contact") {
      // What was pulled aside sounds when it is let go.
      if (find("direction").value === "drag") this.player.heard.press(hand.point, this.force(hand));
      this.player.release(hand.id);
    }
    if (hand.kind === "tool") this.player.lift();
  }

  /** Force [N] of a contact for the chosen direction and size. */
  force({ point, normal, start, at }) {
    const size = this.controls.force;
    const direction = find("direction").value;
    if (direction === "normal") return scaled(normal, -size);
    // Forces of space go to a body in the air in its own frame.
    const told = (force) => (this.player.flight?.flying ? this.player.flight.toBody(force) : force);
    if (direction !== "drag") return told(scaled(AXES[direction[1]], direction[0] === "-" ? -size : size));
    const pull = this.camera.inPlane(this.player.body.place(point), at[0] - start[0], at[1] - start[1]);
    // A drag over a tenth of the body pulls with the chosen size.
    return told(scaled(pull, (10 * size) / this.player.body.size));
  }

  key(event) {
    if (event.target.closest?.("input, select, summary, button") || event.ctrlKey || event.metaKey || event.altKey) return;
    const { camera, controls, player } = this;
    const turn = { ArrowLeft: [-20, 0], ArrowRight: [20, 0], ArrowUp: [0, -20], ArrowDown: [0, 20] }[event.key];
    const acts = {
      " ": () => controls.pause(!player.paused), ".": () => find("step").click(), "0": () => controls.rest(), r: () => find("home").click(), u: () => find("undo").click(),
      w: () => find("wire").click(), "?": () => find("help").click(), "+": () => this.closer(1.15), "=": () => this.closer(1.15), "-": () => this.closer(1 / 1.15),
      Enter: () => this.pushByKey(event),
    };
    const turns = () => {
      if (document.activeElement !== this.canvas) return;
      this.remember();
      camera.orbit(...turn);
    };
    const act = turn ? turns : acts[event.key];
    if (!act) return;
    if (!turn || document.activeElement === this.canvas) event.preventDefault();
    act();
  }

  closer(factor) {
    this.remember();
    this.camera.closer(factor);
  }

  /** Enter holds a push at the point that gives way most. */
  pushByKey(event) {
    if (event.repeat || document.activeElement !== this.canvas || this.player.body.loadTriangles === 0) return;
    const { point, normal } = this.player.body.flexible;
    const at = this.camera.pixel(this.player.body.place(point)) ?? [0, 0];
    if (this.controls.sphere) {
      if (!this.player.tool) this.lay("Enter", at, point, normal);
      return;
    }
    const contact = { kind: "contact", start: at, at: [at[0], at[1] + 40], point, normal };
    contact.id = this.player.press(point, this.force(contact));
    this.held.set("Enter", contact);
    say("");
  }
}
