// A natural mode that swings by itself, drawn in place of the march. The march stands still meanwhile, and a push ends the picture.
import { gradient } from "vademecum/colors";
import { element, find } from "vademecum/elements";
import { SECTION } from "vademecum/evaluator";

/** A swing takes so long [s], whatever the frequency is. */
const PERIOD = 1.5;
/** The largest displacement is drawn as this share of the body's size. */
const DRAWN = 0.07;

export class Modes {
  constructor(page) {
    Object.assign(this, { page, number: -1, phase: 0 });
    for (const [k, { hertz }] of page.modes.entries()) {
      const option = element("option", `mode ${k + 1}: ${Number(hertz.toPrecision(4))} Hz`);
      option.value = String(k);
      find("mode").append(option);
    }
    find("mode").addEventListener("input", () => this.show(Number(find("mode").value)));
  }

  /** Shows a mode by its number from 0; −1: the march again. */
  show(number) {
    const { body, evaluator, controls } = this.page;
    Object.assign(this, { number, phase: 0 });
    find("mode").value = String(number);
    find("true-scale").hidden = number >= 0;
    if (number < 0) return controls.read();
    // `B e_k`: a column of the basis, of which each component of a node has a row.
    const { modes } = evaluator.counts;
    const basis = evaluator.section(SECTION.surfaceBasis);
    const column = Float64Array.from({ length: body.rest.length }, (_, i) => basis[i * modes + number]);
    let largest = 0;
    for (let i = 0; i < column.length; i += 3) largest = Math.max(largest, Math.hypot(column[i], column[i + 1], column[i + 2]));
    this.shape = largest > 0 ? column.map((x) => x / largest) : column;
  }

  /** What a frame draws, `{ displacement, field }`, the one in metres as drawn, the other from 0 to 1; null while the march is shown. */
  frame(seconds) {
    const { body, player, greeting } = this.page;
    if (this.number >= 0) greeting.end();
    if (this.number >= 0 && (player.contacts.size > 0 || player.tool)) this.show(-1);
    if (this.number < 0) return null;
    if (!player.paused) this.phase = (this.phase + seconds / PERIOD) % 1;
    const swing = Math.sin(2 * Math.PI * this.phase);
    this.legend();
    return { displacement: this.shape.map((x) => DRAWN * body.size * swing * x), field: this.shape.map((x) => swing * x) };
  }

  /** Says what is shown, where the controls say it of the march. */
  legend() {
    const { evaluator: { options }, modes } = this.page;
    const whole = Math.sqrt(options.stiffness / options.density) * modes[this.number].hertz;
    find("low").textContent = "0";
    find("high").textContent = "largest";
    find("quantity").textContent = `mode ${this.number + 1}, ${Number(whole.toPrecision(4))} Hz`;
    find("ramp").style.background = gradient(false);
  }
}
