// Colours for numbers, each [red, green, blue] from 0 to 1.

// Samples of viridis (S. van der Walt, N. Smith: CC0), perceptually uniform: dark is small.
const VIRIDIS = ["440154", "482878", "3e4989", "31688e", "26828e", "1f9e89", "35b779", "6ece58", "b5de2b", "fde725"];
// Blue to red through a light gray, as light on both sides: below, at and above zero.
const DIVERGING = ["2a4fa3", "4f7fc8", "86aede", "bfd3e8", "e6e6e3", "efc9b5", "e29b7f", "c85f50", "a02a36"];
const UNKNOWN = [0.62, 0.62, 0.64];
const PLAIN = [0.72, 0.75, 0.79];

function mapColor(map, share) {
  const at = Math.min(Math.max(share, 0), 1) * (map.length - 1), k = Math.min(Math.floor(at), map.length - 2);
  const channel = (hex, c) => parseInt(hex.slice(2 * c, 2 * c + 2), 16) / 255;
  return [0, 1, 2].map((c) => channel(map[k], c) + (at - k) * (channel(map[k + 1], c) - channel(map[k], c)));
}

function deviationColor(mode, deviation, scale) {
  if (mode === "plain") return PLAIN;
  return mode === "signed" ? mapColor(DIVERGING, 0.5 + deviation / scale / 2) : mapColor(VIRIDIS, Math.abs(deviation) / scale);
}

// For all 256 codes of a deviation.
function codeColors(mode, sequence, scale) {
  return Array.from({ length: 256 }, (_, code) =>
    code === 0 && mode !== "plain" ? UNKNOWN : deviationColor(mode, sequence.deviation(code), scale));
}

function mapGradient(mode) {
  return `linear-gradient(to right, ${(mode === "signed" ? DIVERGING : VIRIDIS).map((hex) => "#" + hex).join(", ")})`;
}
