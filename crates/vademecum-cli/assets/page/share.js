// A link that leads back to what is seen: camera, settings and parameters, in the part of the address that no server sees.
import { find, say } from "vademecum/elements";

/** Settings that a link carries. */
const settings = () => [...document.querySelectorAll("aside input[id], aside select[id], #span")];
const read = (setting) => (setting.type === "checkbox" ? String(setting.checked) : setting.value);
/** Six digits show no difference. */
const brief = (text) => (text !== "" && Number.isFinite(Number(text)) ? String(Number(Number(text).toPrecision(6))) : text);

export class Share {
  /** `turned` is called when a link has turned the view. */
  constructor(camera, turned) {
    Object.assign(this, { camera, turned });
    this.start = new Map(settings().map((setting) => [setting.id, read(setting)]));
    this.pose = this.view();
    find("link").addEventListener("click", () => this.offer());
    window.addEventListener("hashchange", () => this.follow());
    this.follow();
  }

  /** The camera in a word: axis that is up, angles, zoom, the point it looks at. */
  view() {
    const { up, yaw, pitch, zoom, target } = this.camera.pose;
    return [up, yaw, pitch, zoom, ...target].map((x) => brief(String(x))).join(",");
  }

  /** What differs from the page as it opens, as a fragment. */
  fragment() {
    const said = new URLSearchParams();
    if (this.view() !== this.pose) said.set("view", this.view());
    for (const setting of settings()) {
      if (read(setting) !== this.start.get(setting.id)) said.set(setting.id, brief(read(setting)));
    }
    return `#${said}`;
  }

  async offer() {
    const address = location.href.split("#")[0] + this.fragment();
    history.replaceState(null, "", address);
    const copied = await navigator.clipboard?.writeText(address).then(() => true, () => false);
    say(`The address of this page now leads back to what you see${copied ? ", and was copied" : ""}.`);
  }

  /** Puts the page to what its address says; what does not fit is left out. */
  follow() {
    const said = new URLSearchParams(location.hash.slice(1));
    const numbers = said.get("view")?.split(",").map(Number) ?? [];
    if (numbers.length === 7 && numbers.every(Number.isFinite) && [0, 1, 2].includes(numbers[0]) && numbers[3] > 0) {
      const [up, yaw, pitch, zoom, ...target] = numbers;
      this.camera.remember();
      this.camera.pose = { up, yaw, pitch, zoom: Math.min(100, Math.max(0.1, zoom)), target };
      this.turned();
    }
    for (const setting of settings()) {
      if (said.has(setting.id)) put(setting, said.get(setting.id));
    }
  }
}

function put(setting, value) {
  if (setting.type === "checkbox") setting.checked = value === "true";
  else if (setting.tagName === "SELECT") {
    const option = [...setting.options].find((one) => one.value === value && !one.disabled);
    if (!option) return;
    setting.value = value;
  } else if (value !== "" && Number.isFinite(Number(value))) setting.value = value;
  else return;
  for (const name of ["input", "change"]) setting.dispatchEvent(new Event(name, { bubbles: true }));
}
