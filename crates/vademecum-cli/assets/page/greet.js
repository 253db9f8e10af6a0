// What a visitor meets first: the body is pushed aside and let go where it has come farthest, and a line says what to do.
import { scaled } from "vademecum/vectors";

/** The push is held until the body has come as far as it would rest, and then comes back by this share; at most for so many periods of the first mode. */
const BACK = 0.03, LONGEST = 1;

/** Plucks the body once, unless the visitor asked the browser for less motion; what the visitor does ends it. */
export class Greeting {
  constructor(player, controls) {
    Object.assign(this, { player, id: null });
    const { point, normal, force } = player.body.flexible;
    if (player.body.loadTriangles === 0 || matchMedia("(prefers-reduced-motion: reduce)").matches) return;
    this.id = player.press(point, scaled(normal, -force));
    Object.assign(this, { until: player.time + LONGEST / controls.firstFrequency(), seen: player.history.count, farthest: 0 });
    document.addEventListener("pointerdown", () => this.end(), { capture: true, once: true });
    document.addEventListener("keydown", () => this.end(), { capture: true, once: true });
  }

  /** Called each frame. */
  frame() {
    const { history, time } = this.player;
    const watched = history.columns[history.names.indexOf("watched")];
    for (; this.id !== null && this.seen < history.count; this.seen++) {
      const way = -history.at(watched, this.seen);
      this.farthest = Math.max(this.farthest, way);
      const back = this.farthest > this.player.body.flexible.moves && way < (1 - BACK) * this.farthest;
      if (back || time >= this.until) this.end();
    }
  }

  /** Lets go. */
  end() {
    if (this.id !== null) this.player.release(this.id);
    this.id = null;
  }
}
