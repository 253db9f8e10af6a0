// Strip charts on a 2-D canvas: each pixel column shows the range of the records that fall into it.

/** A number with three digits and an SI prefix, which only a unit takes that begins with a letter: 0.457 1/s. */
export function short(x, unit = "") {
  if (x === 0 || !Number.isFinite(x)) return `${x} ${unit}`.trim();
  if (!/^\p{L}/u.test(unit)) return `${Number(x.toPrecision(3))} ${unit}`.trim();
  const prefixes = ["p", "n", "µ", "m", "", "k", "M", "G", "T"];
  const place = Math.min(4, Math.max(-4, Math.floor(Math.log10(Math.abs(x)) / 3 + 1e-9)));
  if (Math.abs(x) < 1e-12) return `${Number(x.toPrecision(3))} ${unit}`.trim();
  return `${Number((x / 1000 ** place).toPrecision(3))} ${prefixes[place + 4]}${unit}`;
}

/** Draws columns of a history over the last `span` seconds; records within ±`nothing` are a body at rest. */
export function drawStrip(canvas, history, { columns, names, unit, span, now, positive, nothing }, style) {
  const [context, width, height] = prepare(canvas);
  const left = 64, right = 6, top = 8, bottom = 18;
  const [w, h] = [width - left - right, height - top - bottom];
  const first = firstSince(history, now - span);
  let [low, high] = positive ? [0, 0] : [Infinity, -Infinity];
  for (let i = first; i < history.count; i++) {
    for (const column of columns) {
      const x = history.at(column, i);
      low = Math.min(low, x);
      high = Math.max(high, x);
    }
  }
  const still = !(Math.max(high, -low) > nothing);
  if (still) [low, high] = [-1, 1];
  else if (!(high > low)) [low, high] = [low - Math.abs(low) / 2, low + Math.abs(low) / 2];
  const margin = 0.06 * (high - low);
  [low, high] = [low - (positive ? 0 : margin), high + margin];
  const y = (value) => top + h * (1 - (value - low) / (high - low));
  context.font = "11px system-ui, sans-serif";
  context.fillStyle = style.soft;
  context.strokeStyle = style.line;
  context.textAlign = "right";
  for (const value of still ? [0] : ticks(low, high)) {
    context.beginPath();
    context.moveTo(left, y(value));
    context.lineTo(width - right, y(value));
    context.stroke();
    context.fillText(still ? "at rest" : short(value, unit), left - 6, y(value) + 4);
  }
  context.textAlign = "left";
  const digits = span < 0.1 ? 4 : span < 1 ? 3 : 2;
  context.fillText(`${Number((now - span).toFixed(digits))} s`, left, height - 4);
  context.textAlign = "right";
  context.fillText(`${now.toFixed(digits)} s`, width - right, height - 4);
  let written = left + 6;
  columns.forEach((column, k) => {
    context.strokeStyle = style.series[k % style.series.length];
    context.lineWidth = 1.5;
    context.beginPath();
    strip(history, column, first, now - span, span, w, (px, value) => context.lineTo(left + px, y(value)));
    context.stroke();
    context.lineWidth = 1;
    context.fillStyle = style.series[k % style.series.length];
    context.textAlign = "left";
    context.strokeStyle = style.panel;
    context.lineWidth = 4;
    context.strokeText(names[k], written, top + 9);
    context.lineWidth = 1;
    context.fillText(names[k], written, top + 9);
    written += context.measureText(names[k]).width + 14;
  });
}

/** Bars of each mode's share of the energy. */
export function drawBars(canvas, values, labels, style) {
  const [context, width, height] = prepare(canvas);
  const total = values.reduce((a, b) => a + b, 0) || 1;
  const bar = (width - 8) / values.length;
  context.font = "10px system-ui, sans-serif";
  context.textAlign = "center";
  let free = 0;
  values.forEach((value, k) => {
    const h = (height - 26) * Math.sqrt(value / total);
    context.fillStyle = style.line;
    context.fillRect(4 + k * bar + 1, 10, Math.max(bar - 2, 1), height - 26);
    context.fillStyle = style.series[0];
    context.fillRect(4 + k * bar + 1, height - 16 - h, Math.max(bar - 2, 1), h);
    context.fillStyle = style.soft;
    // Whole, within the picture, and apart from the one before.
    const half = context.measureText(labels[k]).width / 2;
    const at = Math.min(Math.max(4 + (k + 0.5) * bar, half + 2), width - half - 2);
    if (at - half < free) return;
    context.fillText(labels[k], at, height - 4);
    free = at + half + 6;
  });
}

/** Calls `put` along the strip: first, lowest, highest and last value of each pixel column. */
function strip(history, column, first, start, span, width, put) {
  let place = -1, low = 0, high = 0, last = 0;
  const flush = () => {
    if (place < 0) return;
    put(place, low);
    put(place, high);
    put(place, last);
  };
  for (let i = first; i < history.count; i++) {
    const px = Math.floor(((history.at(history.time, i) - start) / span) * width);
    const value = history.at(column, i);
    if (px !== place) {
      flush();
      put(px, value);
      [place, low, high] = [px, value, value];
    }
    [low, high, last] = [Math.min(low, value), Math.max(high, value), value];
  }
  flush();
}

function firstSince(history, time) {
  let [low, high] = [history.first, history.count];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (history.at(history.time, middle) < time) low = middle + 1;
    else high = middle;
  }
  return low;
}

/** Round values between the ends, at least three. */
function ticks(low, high) {
  const power = 10 ** Math.floor(Math.log10(high - low));
  for (const lead of [5, 2, 1, 0.5, 0.2, 0.1]) {
    const step = lead * power;
    const [first, last] = [Math.ceil(low / step), Math.floor(high / step)];
    if (last - first >= 2) return Array.from({ length: last - first + 1 }, (_, i) => (first + i) * step);
  }
  return [];
}

function prepare(canvas) {
  const ratio = Math.min(window.devicePixelRatio || 1, 2);
  const [width, height] = [canvas.clientWidth, canvas.clientHeight];
  const [w, h] = [Math.round(width * ratio), Math.round(height * ratio)];
  if (canvas.width !== w || canvas.height !== h) [canvas.width, canvas.height] = [w, h];
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  return [context, width, height];
}
