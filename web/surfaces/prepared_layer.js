import { DISPARITY_STEPS, NO_DISPARITY } from '../reader/depth_codes.js';

/** Inverse depth where a layer is not present. */
export const ABSENT = -1;
// What a slanted surface may change from one pixel to the next: a share of its inverse depth, and pixels of parallax
// over one arc radius.
const SLANT = 0.02;
const PARALLAX_PX = 6;
// Pixels that look alike, all channels within so many levels, are torn from so much parallax on: what shows through a
// tear differs from both its sides, and a sheet over it does not.
const ALIKE_LEVELS = 8;
const ALIKE_PARALLAX_PX = 24;

/**
 * Inverse depths of codes, and which pixels belong to one surface (core/view/mesh has the same rule).
 */
export class CodedDepths {
  /** @param {import('../reader/records.js').Head} head */
  constructor(head) {
    const span = head.wNear - head.wFar;
    /** inverse depth of a disparity */
    this.w = Float32Array.from({ length: DISPARITY_STEPS + 1 }, (_, d) => head.wFar + (span * d) / DISPARITY_STEPS);
    /** inverse depth between neighbouring codes of a range so wide */
    this.steps = Float32Array.from({ length: 256 }, (_, step) => (span * step) / DISPARITY_STEPS);
    this.parallax = (PARALLAX_PX * head.vPitch) / (head.radius > 0 ? head.radius : 1);
    this.alikeParallax = (ALIKE_PARALLAX_PX * head.vPitch) / (head.radius > 0 ? head.radius : 1);
  }

  /** Whether present pixels of inverse depths a and b, as coded, are of one surface. */
  connected(a, aStep, b, bStep, parallax = this.parallax) {
    const apart = a > b ? a - b : b - a;
    return apart <= 0.51 * (aStep + bStep) + SLANT * (a > b ? a : b) + parallax;
  }

  /** What a surface may change by between pixels of these colours before views tear it. */
  parallaxOf(colour, other) { return lookAlike(colour, other) ? this.alikeParallax : this.parallax; }
}

function lookAlike(a, b) {
  return isNear(a & 255, b & 255) && isNear((a >>> 8) & 255, (b >>> 8) & 255) && isNear((a >>> 16) & 255, (b >>> 16) & 255);
}

function isNear(a, b) { return a - b <= ALIKE_LEVELS && b - a <= ALIKE_LEVELS; }

/**
 * A layer made ready for its mesh: planes of columns x rows, row by row. In a panorama that wraps the last column is the
 * first one again.
 * @typedef {object} PreparedLayer
 * @property {number} columns
 * @property {number} rows
 * @property {number} top the panorama's row that is the first here
 * @property {Float32Array} w inverse depth; ABSENT where not present
 * @property {Uint32Array} colour r | g << 8 | b << 16 | alpha << 24
 * @property {Uint16Array} code disparity exactly as coded; NO_DISPARITY where absent
 * @property {Uint8Array} step disparity between neighbouring codes
 */

/** @returns {PreparedLayer} with nothing in it */
export function emptyLayer(columns, rows, top) {
  const samples = columns * rows;
  return { columns, rows, top, w: new Float32Array(samples).fill(ABSENT), colour: new Uint32Array(samples),
           code: new Uint16Array(samples).fill(NO_DISPARITY), step: new Uint8Array(samples) };
}

/**
 * @param {import('../reader/records.js').Head} head
 * @param {CodedDepths} depths
 * @param {import('../reader/ldp_reader.js').LayerPlanes} planes
 * @returns {PreparedLayer}
 */
export function prepareLayer(head, depths, planes) {
  const { width, height } = planes;
  const layer = emptyLayer(head.wraps ? width + 1 : width, height, 0);
  for (let y = 0, to = 0; y < height; y++)
    for (let column = 0; column < layer.columns; column++, to++) {
      const from = y * width + (column === width ? 0 : column);
      if (!planes.coverage[from]) continue;
      layer.code[to] = planes.disparity[from];
      layer.w[to] = depths.w[planes.disparity[from]];
      layer.step[to] = planes.step[from];
      const rgb = planes.colour[3 * from] | (planes.colour[3 * from + 1] << 8) | (planes.colour[3 * from + 2] << 16);
      layer.colour[to] = rgb | (planes.alpha[from] << 24);
    }
  return layer;
}

/**
 * Whether pixels i and j of a layer, both present, are of one surface. Smoothing moves each by no more than half its
 * step, so that most are told by what they are now.
 */
export function sameSurface(layer, depths, i, j, parallax = depths.parallax) {
  const apart = layer.w[i] - layer.w[j];
  if (apart <= parallax && -apart <= parallax) return true;
  return depths.connected(depths.w[layer.code[i]], depths.steps[layer.step[i]], depths.w[layer.code[j]],
                          depths.steps[layer.step[j]], parallax);
}

/** Whether views join pixels i and j of a layer, both present. */
export function joinedInViews(layer, depths, i, j) {
  return sameSurface(layer, depths, i, j, depths.parallaxOf(layer.colour[i], layer.colour[j]));
}
