import { LdpError } from './errors.js';
import { Models } from './range_decoder.js';

/**
 * The disparity range of every block: a pixel's code c means 15 low + (high - low) c.
 * @typedef {object} BlockRanges
 * @property {number} blockPx 0: one range for everything
 * @property {number} across blocks in a row
 * @property {Uint8Array} low row by row; of blocks without a pixel 0
 * @property {Uint8Array} high
 */

/** One range for a whole layer. @returns {BlockRanges} */
export function singleRange(low, high) {
  return { blockPx: 0, across: 1, low: Uint8Array.of(low), high: Uint8Array.of(high) };
}

/**
 * Step 3 of FORMAT.md, section 5.
 * @param {import('./range_decoder.js').RangeDecoder} decoder
 * @param {Uint8Array} coverage width x height
 * @returns {BlockRanges}
 */
export function decodeBlockRanges(decoder, coverage, width, height, blockPx, place) {
  const across = Math.ceil(width / blockPx);
  const down = Math.ceil(height / blockPx);
  const used = usedBlocks(coverage, width, height, blockPx, across, down);
  const lows = new Int16Array(across * down);
  const spans = new Int16Array(across * down);
  const sets = [0, 1, 2, 3].map(() => ({ more: new Models(9), digits: new Models(18) }));
  for (let y = 0; y < down; y++)
    for (let x = 0; x < across; x++) {
      const i = y * across + x;
      if (!used[i]) continue;
      const low = decodeNumber(decoder, sets[0], expectedNumber(lows, used, across, x, y));
      const expected = expectedNumber(spans, used, across, x, y);
      const span = decodeNumber(decoder, sets[expected <= 2 ? 1 : expected <= 10 ? 2 : 3], expected);
      if (low < 0 || span < 0 || low + span > 255)
        throw new LdpError(`${place}: block range: expected 0 <= low <= high <= 255, found one outside`);
      lows[i] = low;
      spans[i] = span;
    }
  return { blockPx, across, low: Uint8Array.from(lows), high: Uint8Array.from(lows, (low, i) => low + spans[i]) };
}

function usedBlocks(coverage, width, height, blockPx, across, down) {
  const used = new Uint8Array(across * down);
  const blockOf = Uint16Array.from({ length: width }, (_, x) => Math.floor(x / blockPx));
  for (let y = 0; y < height; y++) {
    const first = Math.floor(y / blockPx) * across;
    for (let x = 0; x < width; x++) if (coverage[y * width + x]) used[first + blockOf[x]] = 1;
  }
  return used;
}

function expectedNumber(values, used, across, x, y) {
  const i = y * across + x;
  const hasW = x > 0 && used[i - 1];
  const hasN = y > 0 && used[i - across];
  if (!hasW) return hasN ? values[i - across] : 0;
  const w = values[i - 1];
  if (!hasN) return w;
  const n = values[i - across];
  if (!used[i - across - 1]) return (w + n) >> 1;
  return Math.min(Math.max(w + n - values[i - across - 1], Math.min(w, n)), Math.max(w, n));
}

function decodeNumber(decoder, { more, digits }, expected) {
  let k = 0;
  while (k < 8 && decoder.bit(more, k)) k++;
  let m = 1;
  for (let i = k - 1; i >= 0; i--) m = 2 * m + decoder.bit(digits, 2 * k + (i === k - 1 ? 1 : 0));
  m -= 1;
  return expected + (m % 2 === 1 ? (m + 1) / 2 : -m / 2);
}
