import { Models } from './range_decoder.js';

export const TILE = 16;
export const TILE_EMPTY = 0;
export const TILE_FULL = 1;
export const TILE_MIXED = 2;

/**
 * Step 1 of FORMAT.md, section 5.
 * @param {import('./range_decoder.js').RangeDecoder} decoder
 * @param {number} width of the strip, pixels
 * @param {number} height
 * @returns {{across: number, down: number, states: Uint8Array}} states row by row
 */
export function decodeTiles(decoder, width, height) {
  const across = Math.ceil(width / TILE);
  const down = Math.ceil(height / TILE);
  const states = new Uint8Array(across * down);
  const models = new Models(81 * 2);
  for (let y = 0; y < down; y++)
    for (let x = 0; x < across; x++) {
      const i = y * across + x;
      const w = x > 0 ? states[i - 1] : 0;
      const n = y > 0 ? states[i - across] : 0;
      const nw = x > 0 && y > 0 ? states[i - across - 1] : 0;
      const ne = x + 1 < across && y > 0 ? states[i - across + 1] : 0;
      const k = 27 * w + 9 * n + 3 * nw + ne;
      states[i] = decoder.bit(models, 2 * k) === 0 ? TILE_EMPTY : TILE_FULL + decoder.bit(models, 2 * k + 1);
    }
  return { across, down, states };
}

/**
 * Step 2: 1 where a pixel is present, row by row.
 * @returns {Uint8Array|null} width x height; null if the stream ended before
 */
export function decodeCoverage(decoder, tiles, width, height) {
  const coverage = new Uint8Array(width * height);
  const models = new Models(1024);
  // Two columns of nothing to the left, two to the right, so that contexts need no question about borders.
  const rows = [0, 1, 2].map(() => new Uint8Array(width + 4));
  for (let y = 0; y < height; y++) {
    if (decoder.missing > 0) return null;
    const [above2, above, row] = [rows[y % 3], rows[(y + 1) % 3], rows[(y + 2) % 3]];
    decodeCoverageRow(decoder, models, tiles, y, { above2, above, row }, width);
    coverage.set(row.subarray(2, 2 + width), y * width);
  }
  return coverage;
}

function decodeCoverageRow(decoder, models, tiles, y, { above2, above, row }, width) {
  const firstTile = Math.floor(y / TILE) * tiles.across;
  for (let x = 0; x < width; x++) {
    const state = tiles.states[firstTile + (x >> 4)];
    if (state !== TILE_MIXED) {
      row[x + 2] = state;
      continue;
    }
    const context = (above2[x + 1] << 9) | (above2[x + 2] << 8) | (above2[x + 3] << 7) | (above[x] << 6) |
      (above[x + 1] << 5) | (above[x + 2] << 4) | (above[x + 3] << 3) | (above[x + 4] << 2) | (row[x] << 1) | row[x + 1];
    row[x + 2] = decoder.bit(models, context);
  }
}
