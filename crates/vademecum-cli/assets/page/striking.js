// The switch "sound" on a page with a world: members that are struck ring, each in an audio worklet of its own.
import { find, say } from "vademecum/elements";
import { SECTION } from "vademecum/evaluator";
import { toBody } from "vademecum/pulling";
import { frequencies, isHeard } from "vademecum/ring";
import { ringer } from "vademecum/sound";

/** Members that ring at most; the lowest tone that is worth a worklet [Hz]; the speed of a place [m/s] that is as loud as it gets. */
const MOST = 24, LOWEST = 60, SPEED = 1;

export class Striking {
  /** `files`: the bytes of each file; `wasm`: the evaluator's module, for the worklets. */
  constructor(stage, scene, files, wasm) {
    Object.assign(this, { stage, scene, files, wasm, context: null, nodes: new Map(), isOn: false });
    find("sound").addEventListener("click", () => this.toggle());
  }

  /** Members that ring, with the frequencies of their modes [Hz]. */
  get ringing() {
    const of = this.files.map((_, file) => frequencies({ section: (kind) => this.stage.section(file, kind) }, SECTION, {}));
    const heard = this.scene.members.flatMap(({ file }, member) => (file !== null && of[file].some((f) => f >= LOWEST && isHeard(f)) ? [{ member, file, hertz: of[file] }] : []));
    return heard.slice(0, MOST);
  }

  async toggle() {
    try {
      if (!this.context) await this.start();
    } catch (error) {
      return say(`No sound: ${error.message}`);
    }
    if (this.nodes.size === 0) return say("No sound: no body here has a tone that an ear hears.");
    this.isOn = !this.isOn;
    // A machine without a loudspeaker never answers to these: nothing waits for it.
    if (this.isOn) this.context.resume();
    else this.context.suspend();
    find("sound").setAttribute("aria-pressed", String(this.isOn));
    say(this.isOn ? `Sound: ${this.nodes.size} ${this.nodes.size === 1 ? "body rings" : "bodies ring"} where they are struck.` : "");
  }

  async start() {
    this.context = new AudioContext();
    this.out = new DynamicsCompressorNode(this.context, { threshold: -6, knee: 6, ratio: 12, attack: 0.001, release: 0.1 });
    this.out.connect(this.context.destination);
    for (const { member, file, hertz } of this.ringing) {
      const node = await ringer(this.context, { wasm: this.wasm, file: this.files[file] }, tuning(hertz), []);
      node.connect(this.out);
      this.nodes.set(member, node);
    }
  }

  /** Sends strikes to the members that ring. */
  hear(strikes) {
    if (!this.isOn || strikes.length === 0) return;
    const poses = this.stage.poses();
    for (const { member, impulse, place } of strikes) {
      this.nodes.get(member)?.port.postMessage(["strike", strike(impulse, place, poses[member].rotation, this.context.sampleRate)]);
    }
  }

  /** What rings, for a clip; nothing while the switch is off. */
  tracks() {
    if (!this.isOn) return [];
    const end = this.context.createMediaStreamDestination();
    this.out.connect(end);
    return end.stream.getTracks();
  }

  silence() {
    if (this.isOn) for (const node of this.nodes.values()) node.port.postMessage(["silence"]);
  }

  /** Samples of `seconds` after an impulse in the body [N s] on a member, as the switch would sound. */
  async render(seconds, member, impulse, place, rate = 48000) {
    const { file, hertz } = this.ringing.find((one) => one.member === member);
    const context = new OfflineAudioContext(1, Math.round(seconds * rate), rate);
    const struck = strike(impulse, place, [1, 0, 0, 0], rate);
    const node = await ringer(context, { wasm: this.wasm, file: this.files[file] }, tuning(hertz), [struck]);
    node.connect(context.destination);
    return (await context.startRendering()).getChannelData(0);
  }
}

const tuning = (hertz) => ({ options: {}, hertz, loud: { point: { nodes: [0], weights: [1] }, force: [0, 0, 1e-6] }, speed: SPEED });

/** An impulse in space as a force over one sample, in the body. */
const strike = (impulse, point, rotation, rate) => ({ point, force: toBody(impulse, rotation).map((x) => x * rate) });
