import { ABSENT, sameSurface } from './prepared_layer.js';

const FINE = 0.1; // share of the tear threshold's parallax below which a code's steps do not show
const SWEEPS = 4; // there and back each

/**
 * Takes the steps out of coarsely coded surfaces: every pixel moves towards the mean of its neighbours on the same
 * surface, finely coded ones counting more, but no farther than its code's rounding allows.
 * @param {import('./prepared_layer.js').PreparedLayer} layer its w is changed
 * @param {import('./prepared_layer.js').CodedDepths} depths
 */
export function smoothCodes(layer, depths) {
  const { w, code, step, columns } = layer;
  const { pixels, weights } = withNeighbours(layer, depths, coarsePixels(layer, depths));
  const relax = (k) => {
    const i = pixels[k];
    let mean = 0;
    if (weights[4 * k] > 0) mean += weights[4 * k] * w[i - 1];
    if (weights[4 * k + 1] > 0) mean += weights[4 * k + 1] * w[i + 1];
    if (weights[4 * k + 2] > 0) mean += weights[4 * k + 2] * w[i - columns];
    if (weights[4 * k + 3] > 0) mean += weights[4 * k + 3] * w[i + columns];
    const coded = depths.w[code[i]];
    const half = 0.5 * depths.steps[step[i]];
    w[i] = Math.max(0, Math.min(coded + half, Math.max(coded - half, mean)));
  };
  for (let sweep = 0; sweep < SWEEPS; sweep++) {
    for (let k = 0; k < pixels.length; k++) relax(k);
    for (let k = pixels.length - 1; k >= 0; k--) relax(k);
  }
}

function coarsePixels({ w, step }, depths) {
  const least = FINE * depths.parallax;
  const isCoarse = (i) => w[i] >= 0 && depths.steps[step[i]] > least;
  let count = 0;
  for (let i = 0; i < w.length; i++) if (isCoarse(i)) count++;
  const pixels = new Uint32Array(count);
  for (let i = 0, k = 0; i < w.length; i++) if (isCoarse(i)) pixels[k++] = i;
  return pixels;
}

/**
 * Those of the pixels that have a neighbour on their surface, and the weights of the left, right, upper and lower
 * neighbour of each, which sum to 1.
 */
function withNeighbours(layer, depths, candidates) {
  const { columns, rows } = layer;
  const weights = new Float32Array(4 * candidates.length);
  let count = 0;
  for (const i of candidates) {
    const x = i % columns;
    const y = (i - x) / columns;
    const sum = weigh(layer, depths, i, x > 0 ? i - 1 : i, weights, 4 * count) +
      weigh(layer, depths, i, x + 1 < columns ? i + 1 : i, weights, 4 * count + 1) +
      weigh(layer, depths, i, y > 0 ? i - columns : i, weights, 4 * count + 2) +
      weigh(layer, depths, i, y + 1 < rows ? i + columns : i, weights, 4 * count + 3);
    if (sum === 0) continue;
    for (let side = 0; side < 4; side++) weights[4 * count + side] /= sum;
    candidates[count++] = i;
  }
  return { pixels: candidates.subarray(0, count), weights };
}

/** neighbour: i itself where there is none. */
function weigh(layer, depths, i, neighbour, weights, to) {
  const joins = neighbour !== i && layer.w[neighbour] !== ABSENT && sameSurface(layer, depths, i, neighbour);
  weights[to] = joins ? 1 / (depths.steps[layer.step[neighbour]] + 0.1 * depths.parallax) : 0;
  return weights[to];
}
