/**
 * A layer's colours as if all photographs had been taken at one exposure (FORMAT.md, `expo`).
 * @param {import('./ldp_reader.js').LayerPlanes} planes with colours
 * @param {import('./records.js').Head} head
 * @param {import('./records.js').Exposure|null} exposure
 * @returns {Uint8Array} r g b, row by row
 */
export function evenedColour({ width, height, colour }, head, exposure) {
  if (!exposure) return colour.slice();
  const even = new Uint8Array(colour.length);
  for (let y = 0, i = 0; y < height; y++)
    for (let x = 0; x < width; x++, i += 3) {
      const factors = factorsAt(exposure, (x + 0.5) / width, (y + 0.5) / height, head.wraps);
      const v = Math.max(colour[i], colour[i + 1], colour[i + 2]);
      for (let c = 0; c < 3; c++) even[i + c] = Math.floor(evenLevel(exposure.light, colour[i + c], factors[c], v) + 0.5);
    }
  return even;
}

function factorsAt({ columns, rows, factors }, xShare, yShare, wraps) {
  const across = between(xShare, columns, wraps);
  const down = between(yShare, rows, false);
  return [0, 1, 2].map((c) => {
    const [upper, lower] = [down.first, down.second].map((row) => {
      const [left, right] = [across.first, across.second].map((column) => factors[3 * (row * columns + column) + c]);
      return left + across.share * (right - left);
    });
    return (upper + down.share * (lower - upper)) / 4096;
  });
}

function between(place, nodes, wraps) {
  const at = place * nodes - 0.5;
  const before = Math.floor(at);
  const kept = (n) => (wraps ? (n + nodes) % nodes : Math.max(0, Math.min(nodes - 1, n)));
  return { first: kept(before), second: kept(before + 1), share: at - before };
}

function evenLevel(light, level, factor, largest) {
  const even = Math.min(255, levelOf(light, lightOf(light, level) * (1 / factor)));
  if (factor <= 1) return even;
  const t = Math.max(0, largest - 224) / 31;
  return even + t * t * (level - even);
}

const LEVELS_PER_KNOT = 16;

function lightOf(light, level) {
  const at = level / LEVELS_PER_KNOT;
  const knot = Math.floor(at);
  return light[knot] + (at - knot) * (light[knot + 1] - light[knot]);
}

function levelOf(light, of) {
  if (of >= light[light.length - 1]) return 256;
  let knot = 0;
  while (of >= light[knot + 1]) knot++;
  return LEVELS_PER_KNOT * (knot + (of - light[knot]) / (light[knot + 1] - light[knot]));
}
