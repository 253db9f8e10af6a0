// What a visitor meets first: the body is pulled aside and let go, and a line says what to do.
import { scaled } from "vademecum/vectors";

/** How long the first pull is held, in periods of the first mode: until the body has come farthest. */
const HELD = 0.5;

/** Plucks the body once, unless the visitor asked the browser for less motion; what the visitor does ends it. */
export class Greeting {
  constructor(player, controls) {
    Object.assign(this, { player, id: null });
    const { point, normal, force } = player.body.flexible;
    if (player.body.loadTriangles === 0 || matchMedia("(prefers-reduced-motion: reduce)").matches) return;
    this.id = player.press(point, scaled(normal, -force));
    this.until = player.time + HELD / controls.firstFrequency();
    document.addEventListener("pointerdown", () => this.end(), { capture: true, once: true });
    document.addEventListener("keydown", () => this.end(), { capture: true, once: true });
  }

  /** Called each frame. */
  frame() {
    if (this.id !== null && this.player.time >= this.until) this.end();
  }

  /** Lets go. */
  end() {
    if (this.id !== null) this.player.release(this.id);
    this.id = null;
  }
}
