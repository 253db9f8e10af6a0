// Elements of the page: found, and made.

export const find = (id) => document.getElementById(id);

/** Says what the visitor should know now, in the line over the body; "" takes it away. */
export function say(text) {
  find("hint").textContent = text;
  find("hint").classList.toggle("gone", text === "");
}

export function element(name, text) {
  const made = document.createElement(name);
  made.textContent = text;
  return made;
}

/** A labelled slider with an output before it. */
export function range(parent, id, label, low, high, value) {
  const [wrap, output, input] = ["label", "output", "input"].map((name) => document.createElement(name));
  Object.assign(input, { id, type: "range", min: String(low), max: String(high), step: "any" });
  input.value = String(value);
  // An output can be labelled too and comes first.
  wrap.htmlFor = id;
  wrap.append(label, " ", output, input);
  parent.append(wrap);
  return input;
}
