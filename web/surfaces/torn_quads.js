import { ABSENT, joinedInViews } from './prepared_layer.js';
import { TORN_VERTEX_BYTES } from './torn_vertex.js';

/** Words of a quad: corners (x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1). */
const QUAD_WORDS = TORN_VERTEX_BYTES;
/** Where a missing corner is extended from: its neighbours along the quad's sides, then the opposite corner. */
const EXTENDED_FROM = [[1, 2, 3], [0, 3, 2], [3, 0, 1], [2, 1, 0]];
const JOINS = [0, 1, 0, 2, 1, 3, 2, 3, 0, 3, 1, 2]; // pairs of corners
const OPAQUE = 255;
const DIGIT_BITS = 11;
const DIGIT_MASK = (1 << DIGIT_BITS) - 1;

/**
 * The quads of one strip after another that are torn or not opaque. Each surface that touches one becomes a quad of its own, whose missing
 * corners are, in this order,
 *   - the pixel of another layer that continues the surface, so that layers are sewn together without a seam;
 *   - a copy of the neighbouring corner: opaque where something nearer hides it, transparent where nothing nearer does
 *     (the silhouette fades over one pixel).
 */
export class TornQuads {
  /** @param {import('./prepared_layer.js').PreparedLayer[]} layers all that are drawn, made-up ones too */
  constructor(layers, depths) {
    Object.assign(this, { layers, depths });
    this.opaque = new GrowingQuads();
    this.soft = new GrowingQuads();
    this.surface = new Int8Array(4);
    this.at = new Int32Array(4); // the quad's pixels in its layer's planes
    this.w = new Float32Array(4);
    this.colour = new Uint32Array(4);
  }

  /** Another strip. @param {number} x0 */
  begin(x0) {
    this.x0 = x0;
    this.bounds = { wMin: Infinity, wMax: 0, top: Infinity, bottom: -Infinity };
  }

  /** @param {number} index of the layer @param {import('./strip_cells.js').StripCells} quads its quads in the strip */
  addLayer(index, quads) {
    const { columns, rows, solid } = quads;
    for (let y = 0, quad = 0; y < rows; y++)
      for (let x = 0; x < columns; x++, quad++) if (!solid[quad]) this.addQuad(index, x, y);
  }

  addQuad(index, x, y) {
    const layer = this.layers[index];
    const i = y * layer.columns + this.x0 + x;
    const { at, surface } = this;
    at[0] = i;
    at[1] = i + 1;
    at[2] = i + layer.columns;
    at[3] = i + layer.columns + 1;
    if (layer.w[at[0]] < 0 && layer.w[at[1]] < 0 && layer.w[at[2]] < 0 && layer.w[at[3]] < 0) return;
    this.group(layer);
    for (let own = 0; own < 4; own++) if (surface[own] === own) this.addSurface(index, own, x, y);
  }

  /** Surfaces of the quad's corners, each named by its first corner; -1 = absent. */
  group(layer) {
    const { at, surface } = this;
    for (let k = 0; k < 4; k++) surface[k] = layer.w[at[k]] < 0 ? -1 : k;
    for (let join = 0; join < JOINS.length; join += 2) {
      const a = surface[JOINS[join]];
      const b = surface[JOINS[join + 1]];
      if (a < 0 || b < 0 || a === b || !joinedInViews(layer, this.depths, at[JOINS[join]], at[JOINS[join + 1]])) continue;
      for (let k = 0; k < 4; k++) if (surface[k] === Math.max(a, b)) surface[k] = Math.min(a, b);
    }
  }

  addSurface(index, own, x, y) {
    const layer = this.layers[index];
    const { surface, at, w, colour } = this;
    let soft = false;
    for (let k = 0; k < 4; k++) {
      if (surface[k] === own) {
        w[k] = layer.w[at[k]];
        colour[k] = layer.colour[at[k]];
      } else {
        const neighbours = EXTENDED_FROM[k];
        let n = 0;
        while (surface[neighbours[n]] !== own) n++;
        this.extend(index, at[neighbours[n]], k, x + (k & 1), y + (k >> 1) + layer.top);
      }
      if (colour[k] >>> 24 !== OPAQUE) soft = true;
    }
    if (soft && (colour[0] | colour[1] | colour[2] | colour[3]) >>> 24 === 0) return;
    (soft ? this.soft : this.opaque).push(x, y + layer.top, w, colour);
    this.include(y + layer.top);
  }

  /** Corner k, at column x of the strip and row `row` of the panorama, as pixel `from` next to it would go on there. */
  extend(index, from, k, x, row) {
    const own = this.layers[index];
    const { depths, w, colour } = this;
    const ownCoded = depths.w[own.code[from]];
    const ownStep = depths.steps[own.step[from]];
    let best = null;
    let bestAt = 0;
    let bestApart = Infinity;
    let hidden = false;
    for (let other = 0; other < this.layers.length; other++) {
      const layer = this.layers[other];
      const y = row - layer.top;
      const i = y * layer.columns + this.x0 + x;
      if (y < 0 || y >= layer.rows || layer.w[i] === ABSENT) continue;
      if (layer.w[i] > own.w[from]) hidden = true;
      if (other === index) continue;
      const parallax = depths.parallaxOf(own.colour[from], layer.colour[i]);
      if (!depths.connected(ownCoded, ownStep, depths.w[layer.code[i]], depths.steps[layer.step[i]], parallax)) continue;
      const apart = Math.abs(layer.w[i] - own.w[from]);
      if (apart >= bestApart) continue;
      best = layer;
      bestAt = i;
      bestApart = apart;
    }
    w[k] = best ? best.w[bestAt] : own.w[from];
    colour[k] = best ? best.colour[bestAt] : hidden ? own.colour[from] : own.colour[from] & 0xffffff;
  }

  include(row) {
    const { bounds, w } = this;
    bounds.wMin = Math.min(bounds.wMin, w[0], w[1], w[2], w[3]);
    bounds.wMax = Math.max(bounds.wMax, w[0], w[1], w[2], w[3]);
    bounds.top = Math.min(bounds.top, row);
    bounds.bottom = Math.max(bounds.bottom, row + 1);
  }

  /** Those of the strip. @returns {{opaque: ArrayBuffer, soft: ArrayBuffer}} soft: the farthest first */
  take() {
    return { opaque: this.opaque.take(), soft: this.soft.takeSorted() };
  }
}

class GrowingQuads {
  constructor() {
    this.count = 0;
    this.resize(1024);
  }

  resize(room) {
    const grown = new ArrayBuffer(4 * QUAD_WORDS * room);
    if (this.words) new Uint32Array(grown).set(this.words);
    this.room = room;
    this.words = new Uint32Array(grown);
    this.floats = new Float32Array(grown);
    this.shorts = new Int16Array(grown);
  }

  push(x, row, w, colour) {
    if (this.count === this.room) this.resize(2 * this.room);
    for (let k = 0, at = QUAD_WORDS * this.count; k < 4; k++, at += 3) {
      this.shorts[2 * at] = x + (k & 1);
      this.shorts[2 * at + 1] = row + (k >> 1);
      this.floats[at + 1] = w[k];
      this.words[at + 2] = colour[k];
    }
    this.count++;
  }

  /** All of them; none are left. */
  take() {
    const taken = this.words.slice(0, QUAD_WORDS * this.count);
    this.count = 0;
    return taken.buffer;
  }

  /** By the mean of their inverse depths, least first. */
  takeSorted() {
    const keys = new Float32Array(this.count);
    for (let i = 0, at = 0; i < this.count; i++, at += QUAD_WORDS)
      keys[i] = this.floats[at + 1] + this.floats[at + 4] + this.floats[at + 7] + this.floats[at + 10];
    const order = ascending(keys);
    const sorted = new Uint32Array(QUAD_WORDS * this.count);
    for (let i = 0, to = 0; i < order.length; i++)
      for (let k = 0, from = QUAD_WORDS * order[i]; k < QUAD_WORDS; k++) sorted[to++] = this.words[from++];
    this.count = 0;
    return sorted.buffer;
  }
}

/** The order of numbers that are not negative, whose bits therefore stand in their order too; equal ones stay in theirs. */
function ascending(numbers) {
  const bits = new Uint32Array(numbers.buffer);
  let order = new Uint32Array(bits.length);
  for (let i = 0; i < order.length; i++) order[i] = i;
  let sorted = new Uint32Array(order.length);
  for (let shift = 0; shift < 32; shift += DIGIT_BITS) {
    const next = new Uint32Array(1 << DIGIT_BITS); // where the next number of each digit goes
    for (const number of bits) next[(number >>> shift) & DIGIT_MASK]++;
    for (let digit = 0, before = 0; digit <= DIGIT_MASK; digit++) [next[digit], before] = [before, before + next[digit]];
    for (const i of order) sorted[next[(bits[i] >>> shift) & DIGIT_MASK]++] = i;
    [order, sorted] = [sorted, order];
  }
  return order;
}
