// Two ramps: one for sizes (dark to light, readable without colour), one for signed values around a neutral middle.

const SIZES = ["#45529f", "#3278b8", "#1f9bab", "#4fbd8b", "#b0d865", "#fbe457"];
const SIGNED = ["#1f4e9c", "#5c97cf", "#bcd3e6", "#e6e4e0", "#eec0a2", "#da7350", "#a3242f"];

const channels = (hex) => [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16));

/** 256 RGBA colours. */
export function ramp(signed) {
  const stops = (signed ? SIGNED : SIZES).map(channels);
  return Uint8Array.from({ length: 1024 }, (_, i) => {
    if (i % 4 === 3) return 255;
    const x = ((i >> 2) / 255) * (stops.length - 1);
    const left = Math.min(Math.floor(x), stops.length - 2);
    return Math.round(stops[left][i % 4] * (left + 1 - x) + stops[left + 1][i % 4] * (x - left));
  });
}

/** The same ramp as a CSS gradient. */
export const gradient = (signed) => `linear-gradient(to right, ${(signed ? SIGNED : SIZES).join(", ")})`;
