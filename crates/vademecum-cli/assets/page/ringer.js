// The audio worklet: a module of the evaluator of its own beside the page's, stepped once for each sample.
import { Evaluator } from "vademecum/evaluator";
import { Ring } from "vademecum/ring";

// Worklets have no decoder of text; what the evaluator says there is plain.
globalThis.TextDecoder ??= class {
  decode(bytes) {
    return Array.from(bytes, (byte) => String.fromCharCode(byte)).join("");
  }
};

class Ringer extends AudioWorkletProcessor {
  constructor({ processorOptions: { wasm, file, tuning, strikes } }) {
    super();
    const { exports } = new WebAssembly.Instance(new WebAssembly.Module(wasm), {});
    this.ring = new Ring(new Evaluator(exports, file), sampleRate, tuning);
    for (const strike of strikes) this.ring.strike(strike);
    const acts = { strike: (strike) => this.ring.strike(strike), tune: (tuning) => this.ring.tune(tuning), silence: () => this.ring.silence() };
    this.port.onmessage = ({ data: [act, what] }) => acts[act](what);
  }

  process(_, [[samples]]) {
    this.ring.render(samples);
    return true;
  }
}

registerProcessor("ringer", Ringer);
