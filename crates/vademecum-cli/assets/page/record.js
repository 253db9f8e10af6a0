// A picture or a clip of the body as it is seen, with title, scale and colours, saved by the browser.
import { ramp } from "vademecum/colors";
import { find, say } from "vademecum/elements";

/** Kinds of clips, best first; a browser writes at least one. */
const KINDS = ["video/webm;codecs=vp9,opus", "video/webm", "video/mp4"];
const FRAMES = 30;
/** Pixels of a picture for each of the page. */
const FINE = 4;

export class Recorder {
  constructor(controls, sound) {
    Object.assign(this, { controls, sound, canvas: document.createElement("canvas"), pictures: [], clip: null });
    find("picture").addEventListener("click", async () => save(await this.picture(), "png"));
    find("clip").addEventListener("click", () => this.toggle());
  }

  /** The next frame that is drawn, as a PNG. */
  picture() {
    // Fine enough for print; clips keep their size.
    if (!this.clip) this.controls.renderer.finer = FINE;
    return new Promise((done) => this.pictures.push(done));
  }

  async toggle() {
    if (this.clip) return this.clip.stop();
    const kind = window.MediaRecorder && KINDS.find((name) => MediaRecorder.isTypeSupported(name));
    if (!kind) return say("This browser cannot record a clip.");
    this.compose();
    const tracks = [...this.canvas.captureStream(FRAMES).getTracks(), ...this.sound.tracks()];
    const pieces = [];
    this.clip = new MediaRecorder(new MediaStream(tracks), { mimeType: kind, videoBitsPerSecond: 8e6 });
    this.clip.addEventListener("dataavailable", ({ data }) => pieces.push(data));
    this.clip.addEventListener("stop", () => {
      tracks.forEach((track) => track.stop());
      this.clip = null;
      this.shown();
      save(new Blob(pieces, { type: kind }), kind.startsWith("video/webm") ? "webm" : "mp4");
    });
    this.clip.start(1000);
    this.shown();
  }

  shown() {
    find("clip").setAttribute("aria-pressed", String(this.clip !== null));
    find("clip").textContent = this.clip ? "End clip" : "Clip";
  }

  /** Called right after each frame was drawn, while the browser still has it. */
  frame() {
    if (!this.clip && this.pictures.length === 0) return;
    this.compose();
    for (const done of this.pictures.splice(0)) this.canvas.toBlob(done, "image/png");
    this.controls.renderer.finer = null;
  }

  /** Background, body, arrows, and the words that the page has beside them. */
  compose() {
    const [view, over] = [find("view"), find("over")];
    const { canvas, controls: { style } } = this;
    // Clips cannot change their size.
    if (!this.clip) [canvas.width, canvas.height] = [view.width, view.height];
    const [width, height] = [canvas.width, canvas.height];
    const unit = view.width / view.clientWidth;
    const context = canvas.getContext("2d");
    context.fillStyle = style.stage;
    context.fillRect(0, 0, width, height);
    context.drawImage(view, 0, 0, width, height);
    context.drawImage(over, 0, 0, width, height);
    const write = (text, x, y, align, size, color) => {
      Object.assign(context, { font: `${size * unit}px system-ui, sans-serif`, textAlign: align, fillStyle: color });
      context.fillText(text, x, y * unit);
    };
    write(document.title, 12 * unit, 24, "left", 15, style.ink);
    const said = (id) => find(id).textContent;
    const right = width - 12 * unit;
    const ends = said("high") ? `${said("low")} to ${said("high")}` : said("low");
    write(`${said("quantity")}: ${ends}`, right, 22, "right", 12, style.ink);
    write(`${said("true-scale")}, time ${said("time")}`, right, 52, "right", 12, style.soft);
    this.bar(context, right - 160 * unit, 28 * unit, 160 * unit, 8 * unit);
  }

  bar(context, x, y, width, height) {
    const colors = ramp(this.controls.component >= 0);
    const gradient = context.createLinearGradient(x, 0, x + width, 0);
    for (let i = 0; i < 256; i += 15) gradient.addColorStop(i / 255, `rgb(${colors.slice(4 * i, 4 * i + 3).join(" ")})`);
    context.fillStyle = gradient;
    context.fillRect(x, y, width, height);
  }
}

/** Hands a file to the visitor. */
function save(blob, ending) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = `${document.title.replace(/[^\p{L}\p{N}]+/gu, "-").replace(/^-+|-+$/g, "") || "body"}.${ending}`;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60000);
}
