import { NO_DISPARITY } from '../reader/depth_codes.js';
import { ABSENT, sameSurface } from './prepared_layer.js';

const REACH_PX = 20;
const PLANES = ['w', 'colour', 'code', 'step'];

/**
 * One layer more, made up: continues the deepest surfaces some pixels underneath the nearer ones beside them, so that a
 * small step aside opens no cracks along silhouettes.
 * @param {import('./prepared_layer.js').PreparedLayer[]} layers of one size, at least one
 * @param {import('./prepared_layer.js').CodedDepths} depths
 * @param {boolean} wraps
 * @returns {import('./prepared_layer.js').PreparedLayer}
 */
export function makeUnderlay(layers, depths, wraps) {
  return new Grower(deepestOf(layers), depths, wraps).grow();
}

function deepestOf(layers) {
  const deepest = { ...layers[0] };
  for (const plane of PLANES) deepest[plane] = deepest[plane].slice();
  for (const layer of layers.slice(1))
    for (let i = 0; i < deepest.w.length; i++) {
      if (layer.w[i] < 0 || (deepest.w[i] >= 0 && layer.w[i] >= deepest.w[i])) continue;
      for (const plane of PLANES) deepest[plane][i] = layer[plane][i];
    }
  return deepest;
}

class Grower {
  constructor(deepest, depths, wraps) {
    Object.assign(this, { deepest, depths, wraps });
    this.columns = wraps ? deepest.columns - 1 : deepest.columns; // without the repeated one
    this.grown = new Uint8Array(deepest.w.length);
    this.askedIn = new Uint8Array(deepest.w.length);
    this.around = new Uint32Array(4);
  }

  grow() {
    const { deepest, grown } = this;
    let steps = this.firstSteps();
    for (let round = 1; round <= REACH_PX; round++) {
      this.take(steps);
      steps = this.stepsAround(steps, round);
    }
    for (let i = 0; i < grown.length; i++) {
      if (grown[i]) continue;
      deepest.w[i] = ABSENT;
      deepest.code[i] = NO_DISPARITY;
    }
    return deepest;
  }

  /** All from the same state. */
  take(steps) {
    for (const plane of PLANES) {
      const values = this.deepest[plane];
      const taken = values.slice(0, steps.length / 2);
      for (let k = 0; k < taken.length; k++) taken[k] = values[steps[2 * k + 1]];
      for (let k = 0; k < taken.length; k++) values[steps[2 * k]] = taken[k];
    }
    for (let k = 0; k < steps.length; k += 2) this.grown[steps[k]] = 1;
  }

  /** Of all pixels those beside a deeper surface, each with the pixel of it that goes on there: [to, from, ...]. */
  firstSteps() {
    const { columns, rows } = this.deepest;
    const steps = [];
    for (let y = 0; y < rows; y++)
      for (let x = 0, i = y * columns; x < this.columns; x++, i++) this.addStep(i, x, y, steps);
    return steps;
  }

  /** The same of what changed and its neighbours, each asked once: nowhere else is there anything new. */
  stepsAround(before, round) {
    const { columns } = this.deepest;
    const steps = [];
    const neighbours = new Uint32Array(5);
    for (let k = 0; k < before.length; k += 2) {
      const own = before[k];
      const x = own % columns;
      const count = this.findNeighbours(own, x, (own - x) / columns);
      neighbours[0] = own;
      for (let n = 0; n < count; n++) neighbours[n + 1] = this.around[n];
      for (let n = 0; n <= count; n++) this.ask(neighbours[n], round, steps);
    }
    return steps;
  }

  ask(pixel, round, steps) {
    if (this.askedIn[pixel] === round) return;
    this.askedIn[pixel] = round;
    const x = pixel % this.deepest.columns;
    this.addStep(pixel, x, (pixel - x) / this.deepest.columns, steps);
  }

  addStep(own, x, y, steps) {
    const { w } = this.deepest;
    const count = this.findNeighbours(own, x, y);
    let best = own;
    for (let k = 0; k < count; k++) {
      const n = this.around[k];
      if (w[n] >= 0 && w[n] < w[best] && !sameSurface(this.deepest, this.depths, own, n)) best = n;
    }
    if (best !== own) steps.push(own, best);
  }

  /** Into `around`: left, right, above, below. */
  findNeighbours(pixel, x, y) {
    const { columns, rows } = this.deepest;
    const [around, last] = [this.around, this.columns - 1];
    let count = 0;
    if (x > 0) around[count++] = pixel - 1;
    else if (this.wraps) around[count++] = pixel + last;
    if (this.wraps && x >= last) around[count++] = pixel + 1 - this.columns;
    else if (x + 1 < columns) around[count++] = pixel + 1;
    if (y > 0) around[count++] = pixel - columns;
    if (y + 1 < rows) around[count++] = pixel + columns;
    return count;
  }
}
