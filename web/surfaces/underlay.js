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
  const { w, colour, code, step } = deepest;
  for (const layer of layers.slice(1))
    for (let i = 0; i < w.length; i++) {
      if (layer.w[i] < 0 || (w[i] >= 0 && layer.w[i] >= w[i])) continue;
      w[i] = layer.w[i];
      colour[i] = layer.colour[i];
      code[i] = layer.code[i];
      step[i] = layer.step[i];
    }
  return deepest;
}

/** Pixels that take over another's surface. */
class Steps {
  constructor() {
    this.count = 0;
    this.to = new Int32Array(1024);
    this.from = new Int32Array(1024);
  }

  add(to, from) {
    if (this.count === this.to.length) [this.to, this.from] = [twice(this.to), twice(this.from)];
    this.to[this.count] = to;
    this.from[this.count++] = from;
  }
}

function twice(values) {
  const grown = new Int32Array(2 * values.length);
  grown.set(values);
  return grown;
}

class Grower {
  constructor(deepest, depths, wraps) {
    Object.assign(this, { deepest, depths, wraps });
    this.columns = wraps ? deepest.columns - 1 : deepest.columns; // without the repeated one
    this.grown = new Uint8Array(deepest.w.length);
    this.askedIn = new Uint8Array(deepest.w.length);
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
  take({ to, from, count }) {
    for (const plane of PLANES) {
      const values = this.deepest[plane];
      const taken = values.slice(0, count);
      for (let k = 0; k < count; k++) taken[k] = values[from[k]];
      for (let k = 0; k < count; k++) values[to[k]] = taken[k];
    }
    for (let k = 0; k < count; k++) this.grown[to[k]] = 1;
  }

  /** Of all pixels those beside a deeper surface, each with the pixel of it that goes on there. */
  firstSteps() {
    const { columns, rows } = this.deepest;
    const steps = new Steps();
    for (let y = 0; y < rows; y++)
      for (let x = 0, i = y * columns; x < this.columns; x++, i++) this.addStep(i, x, steps);
    return steps;
  }

  /** The same of what changed and its neighbours, each asked once: nowhere else is there anything new. */
  stepsAround(before, round) {
    const steps = new Steps();
    for (let k = 0; k < before.count; k++) {
      const own = before.to[k];
      const x = own % this.deepest.columns;
      this.ask(own, round, steps);
      this.ask(this.left(own, x), round, steps);
      this.ask(this.right(own, x), round, steps);
      this.ask(this.above(own), round, steps);
      this.ask(this.below(own), round, steps);
    }
    return steps;
  }

  ask(pixel, round, steps) {
    if (this.askedIn[pixel] === round) return;
    this.askedIn[pixel] = round;
    this.addStep(pixel, pixel % this.deepest.columns, steps);
  }

  addStep(own, x, steps) {
    let best = this.deeper(own, own, this.left(own, x));
    best = this.deeper(own, best, this.right(own, x));
    best = this.deeper(own, best, this.above(own));
    best = this.deeper(own, best, this.below(own));
    if (best !== own) steps.add(own, best);
  }

  /** Neighbour n, if it is of a surface that lies deeper than the best one so far. */
  deeper(own, best, n) {
    const { w } = this.deepest;
    return w[n] >= 0 && w[n] < w[best] && !sameSurface(this.deepest, this.depths, own, n) ? n : best;
  }

  // Neighbours of pixel i, in column x; i itself where there is none.
  left(i, x) { return x > 0 ? i - 1 : this.wraps ? i + this.columns - 1 : i; }
  right(i, x) {
    if (this.wraps && x >= this.columns - 1) return i - x + ((x + 1) % this.columns);
    return x + 1 < this.deepest.columns ? i + 1 : i;
  }
  above(i) { return i >= this.deepest.columns ? i - this.deepest.columns : i; }
  below(i) { return i + this.deepest.columns < this.deepest.w.length ? i + this.deepest.columns : i; }
}
