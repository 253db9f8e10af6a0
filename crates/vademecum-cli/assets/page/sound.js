// The switch "sound": strikes on the page ring in the ear, in real time, whatever the speed of the picture.
import { short } from "vademecum/chart";
import { find, say } from "vademecum/elements";
import { SECTION } from "vademecum/evaluator";
import { frequencies, HEARD, isHeard } from "vademecum/ring";
import { scaled } from "vademecum/vectors";

export class Sound {
  /** `bytes`: the evaluator's module and the file, for the worklet's own instance. */
  constructor(player, bytes) {
    Object.assign(this, { player, bytes, context: null, node: null, isOn: false });
    player.heard = {
      press: (point, force) => this.post("strike", { point, force: Array.from(force) }), rest: () => this.post("silence"), set: () => this.retune(),
    };
    find("sound").addEventListener("click", () => this.toggle());
  }

  /** Frequencies [Hz] that can be heard as the body is bound, lowest first. */
  get tones() {
    const { evaluator } = this.player;
    return frequencies(evaluator, SECTION, evaluator.options).filter((hertz) => isHeard(hertz)).sort((a, b) => a - b);
  }

  /** Why nothing can be heard; null if something can. */
  get silent() {
    const { evaluator, body } = this.player;
    const range = `an ear hears ${HEARD[0]} Hz to ${HEARD[1] / 1000} kHz`;
    if (body.loadTriangles === 0) return "No sound: nothing of this body can be struck.";
    if (!evaluator.has.diagonal) return "No sound: it needs a file with the diagonal structure, whose time step is free.";
    const { regionStiffness, regionDensity } = evaluator.options;
    if ([...regionStiffness, ...regionDensity].some((scale) => scale !== 1)) return "No sound while a region is scaled by itself: its tones are not in the file.";
    if (this.tones.length > 0) return null;
    const all = frequencies(evaluator, SECTION, evaluator.options);
    return `No sound: the modes of this body lie between ${short(Math.min(...all), "Hz")} and ${short(Math.max(...all), "Hz")}, ${range}.`;
  }

  /** What the worklet is to ring with: the options bound on the page, and the loudest strike. */
  get tuning() {
    const { evaluator, body } = this.player;
    const { point, normal, force } = body.flexible;
    return { options: { ...evaluator.options }, hertz: frequencies(evaluator, SECTION, evaluator.options), loud: { point, force: scaled(normal, -force) } };
  }

  async toggle() {
    const silent = this.isOn ? null : this.silent;
    if (silent) return say(silent);
    try {
      if (!this.context) await this.start();
    } catch (error) {
      return say(`No sound: ${error.message}`);
    }
    this.isOn = !this.isOn;
    // A machine without a loudspeaker never answers to these: nothing waits for it.
    if (this.isOn) this.context.resume();
    else this.context.suspend();
    find("sound").setAttribute("aria-pressed", String(this.isOn));
    if (!this.isOn) return say("");
    this.post("silence");
    this.post("tune", this.tuning);
    const { tones } = this;
    const { options: { alpha, beta } } = this.player.evaluator;
    const ratios = this.player.evaluator.section(SECTION.dampingRatios) ?? [];
    const still = alpha === 0 && beta === 0 && ratios.every((ratio) => ratio === 0) ? " The file has no damping: it rings until Rest." : "";
    say(`Sound: ${tones.length} tone${tones.length === 1 ? "" : "s"} from ${short(tones[0], "Hz")} (${note(tones[0])}). Strike the body: it rings in real time.${still}`);
  }

  async start() {
    this.context = new AudioContext();
    this.node = await ringer(this.context, this.bytes, this.tuning, []);
    // Hard strikes stay below what a loudspeaker can give.
    this.out = new DynamicsCompressorNode(this.context, { threshold: -4, knee: 0, ratio: 20, attack: 0.001, release: 0.1 });
    this.node.connect(this.out).connect(this.context.destination);
  }

  /** What rings, for a clip; nothing while the switch is off. */
  tracks() {
    if (!this.isOn) return [];
    const end = this.context.createMediaStreamDestination();
    this.out.connect(end);
    return end.stream.getTracks();
  }

  post(...message) {
    if (this.isOn) this.node.port.postMessage(message);
  }

  retune() {
    if (!this.isOn) return;
    const { silent } = this;
    if (silent) say(silent);
    this.post(...(silent ? ["silence"] : ["tune", this.tuning]));
  }

  /** Samples of `seconds` after strikes `{ point, force }`, as the switch would sound. */
  async render(seconds, strikes, rate = 48000) {
    const context = new OfflineAudioContext(1, Math.round(seconds * rate), rate);
    const node = await ringer(context, this.bytes, this.tuning, strikes);
    node.connect(context.destination);
    return (await context.startRendering()).getChannelData(0);
  }
}

/** The nearest note of a piano tuned to A4 = 440 Hz, and how far above or below it a tone lies, in hundredths of a semitone. */
export function note(hertz) {
  const exact = 69 + 12 * Math.log2(hertz / 440);
  const key = Math.round(exact);
  const cents = Math.round(100 * (exact - key));
  const name = ["C", "C♯", "D", "D♯", "E", "F", "F♯", "G", "G♯", "A", "A♯", "B"][((key % 12) + 12) % 12];
  return `${name}${Math.floor(key / 12) - 1}${cents === 0 ? "" : ` ${cents > 0 ? "+" : "−"} ${Math.abs(cents)} cents`}`;
}

/** A worklet that rings. */
export async function ringer(context, { wasm, file }, tuning, strikes) {
  await context.audioWorklet.addModule(worklet());
  return new AudioWorkletNode(context, "ringer", { numberOfInputs: 0, outputChannelCount: [1], processorOptions: { wasm, file, tuning, strikes } });
}

/** Address of the worklet's module. A worklet does not see the page's import map, so its imports are written out. */
function worklet() {
  const { imports } = JSON.parse(document.querySelector("script[type=importmap]").textContent);
  const [kind, code] = imports["vademecum/ringer"].split(",");
  const text = atob(code).replace(/"(vademecum\/(?:evaluator|ring))"/g, (_, name) => JSON.stringify(imports[name]));
  return `${kind},${btoa(text)}`;
}
