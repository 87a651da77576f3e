import { DISPARITY_STEPS } from '../reader/depth_codes.js';

const MOST_COLUMNS = 160;

/**
 * Where a panorama shows anything, and how far that is: coarse, for framing views.
 * @typedef {object} SeenMap
 * @property {number} columns cells across the panorama
 * @property {number} rows
 * @property {Float32Array} share of a cell's pixels that are there, 0 .. 1, row by row
 * @property {Float32Array} w mean inverse depth; of what is near where nothing is there
 */

/**
 * @param {import('../reader/records.js').Head} head
 * @param {import('../reader/ldp_reader.js').LayerPlanes} planes of the front layer; colours are not looked at
 * @returns {SeenMap}
 */
export function mapOfSeen(head, { width, height, coverage, disparity }) {
  const cellPx = Math.ceil(width / MOST_COLUMNS);
  const [columns, rows] = [Math.ceil(width / cellPx), Math.ceil(height / cellPx)];
  const [sum, seen, all] = [1, 2, 3].map(() => new Float32Array(columns * rows));
  for (let y = 0, i = 0; y < height; y++)
    for (let x = 0, row = Math.floor(y / cellPx) * columns; x < width; x++, i++) {
      const cell = row + Math.floor(x / cellPx);
      all[cell]++;
      if (!coverage[i]) continue;
      seen[cell]++;
      sum[cell] += disparity[i];
    }
  const scale = (head.wNear - head.wFar) / DISPARITY_STEPS;
  const w = sum.map((value, cell) => (seen[cell] > 0 ? head.wFar + (scale * value) / seen[cell] : NaN));
  spread(w, columns);
  return { columns, rows, share: seen.map((count, cell) => count / all[cell]), w: w.map((value) => value || 0) };
}

/** Along rows and columns, there and back, over what is not known. */
function spread(w, columns) {
  const take = (cell, from) => {
    if (Number.isNaN(w[cell]) && from >= 0 && from < w.length) w[cell] = w[from];
  };
  for (const step of [columns, 1]) {
    for (let cell = 0; cell < w.length; cell++) if (step > 1 || cell % columns > 0) take(cell, cell - step);
    for (let cell = w.length - 1; cell >= 0; cell--) if (step > 1 || (cell + 1) % columns > 0) take(cell, cell + step);
  }
}
