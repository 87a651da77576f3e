import { Models } from './range_decoder.js';

/** Disparity of a pixel that is not there. */
export const NO_DISPARITY = 65535;
/** Disparity D stands for inverse depth w_far + (w_near - w_far) D / DISPARITY_STEPS. */
export const DISPARITY_STEPS = 3825;

const NO_CODE = -1;
const CODES = 16;
/** g(d) of FORMAT.md for d = -15 .. 15, at d + 15. */
const G = Uint8Array.from({ length: 31 }, (_, i) => {
  const d = i - 15;
  const size = Math.abs(d);
  return 3 + Math.sign(d) * (size < 2 ? size : size < 4 ? 2 : 3);
});

/**
 * Step 4 of FORMAT.md, section 5: the codes of a strip, row by row. Rows stand in planes with two rows above, two columns
 * to the left and one to the right in which nothing is present.
 */
export class CodeDecoder {
  /**
   * @param {import('./range_decoder.js').RangeDecoder} decoder
   * @param {Uint8Array} coverage width x height
   * @param {import('./block_ranges.js').BlockRanges} ranges
   */
  constructor(decoder, coverage, ranges, width, height) {
    Object.assign(this, { decoder, coverage, ranges, width, height });
    this.stride = width + 3;
    const samples = this.stride * (height + 2);
    this.codes = new Int8Array(samples).fill(NO_CODE);
    this.rangeOf = new Uint16Array(samples); // low << 8 | high
    this.a = new Models(343 * 6);
    this.b = new Models(343 * 4);
    this.c = new Models(343);
    this.d = new Models(49);
    this.f = new Models(6 * 15);
  }

  /** @returns {Uint16Array|null} disparity, width x height, NO_DISPARITY where absent; null if the stream ended before */
  run() {
    const disparity = new Uint16Array(this.width * this.height).fill(NO_DISPARITY);
    for (let y = 0; y < this.height; y++) {
      if (this.decoder.missing > 0) return null;
      this.runRow(y, disparity);
    }
    return disparity;
  }

  runRow(y, disparity) {
    const { coverage, ranges, width } = this;
    const { blockPx, low, high } = ranges;
    const firstBlock = blockPx > 0 ? Math.floor(y / blockPx) * ranges.across : 0;
    let block = firstBlock;
    let blockEnd = blockPx > 0 ? blockPx : width;
    for (let x = 0, from = y * width, at = (y + 2) * this.stride + 2; x < width; x++, from++, at++) {
      if (x === blockEnd) {
        block++;
        blockEnd += blockPx;
      }
      if (!coverage[from]) continue;
      const own = (low[block] << 8) | high[block];
      const span = high[block] - low[block];
      this.rangeOf[at] = own;
      const code = span > 0 ? this.decodeCode(at, own) : 0;
      this.codes[at] = code;
      disparity[from] = 15 * low[block] + span * code;
    }
  }

  /** The code of the pixel at `j` as the range `own` has it. */
  codeIn(own, j) {
    const code = this.codes[j];
    const its = this.rangeOf[j];
    if (code === NO_CODE || its === own) return code;
    const disparity = 15 * (its >> 8) + ((its & 255) - (its >> 8)) * code;
    const low = own >> 8;
    const span = (own & 255) - low;
    const above = disparity - 15 * low + (span >> 1);
    return above <= 0 ? 0 : Math.min(15, Math.floor(above / span));
  }

  decodeCode(at, own) {
    const stride = this.stride;
    let w = this.codeIn(own, at - 1);
    let n = this.codeIn(own, at - stride);
    let nw = this.codeIn(own, at - stride - 1);
    let ne = this.codeIn(own, at - stride + 1);
    let ww = this.codeIn(own, at - 2);
    let nn = this.codeIn(own, at - 2 * stride);
    const absent = (w === NO_CODE ? 1 : 0) + (n === NO_CODE ? 1 : 0);
    if (absent === 2) w = n = ne !== NO_CODE ? ne : nw !== NO_CODE ? nw : 0;
    if (n === NO_CODE) n = w;
    if (w === NO_CODE) w = nw !== NO_CODE ? nw : n;
    if (nw === NO_CODE) nw = n;
    if (ne === NO_CODE) ne = n;
    if (ww === NO_CODE) ww = w;
    if (nn === NO_CODE) nn = n;
    const gn = G[n - nw + 15];
    const gw = G[w - nw + 15];
    const q = 49 * gn + 7 * gw + G[ne - n + 15];
    const least = w < n ? w : n;
    const most = w < n ? n : w;
    const plane = w + n - nw;
    const first = plane < least ? least : plane > most ? most : plane;
    const s = absent > 0 ? 3 + absent : (ww === w ? 1 : 0) + (nn === n ? 2 : 0);
    if (this.decoder.bit(this.a, 6 * q + s) === 0) return first;
    const steepest = Math.max(Math.abs(n - nw), Math.abs(w - nw), Math.abs(ne - n));
    return this.decodeOther(q, { first, w, n, nw, ne }, 7 * gn + gw, Math.min(2, steepest));
  }

  /** Decisions 2 to 4. */
  decodeOther(q, { first, w, n, nw, ne }, way, steepness) {
    const { decoder } = this;
    let tried = 1 << first;
    const second = first === w ? n : w;
    if (second !== first) {
      if (decoder.bit(this.b, 4 * q + (w === first ? 1 : 0) + (n === first ? 2 : 0)) === 0) return second;
      tried |= 1 << second;
    }
    const third = ne === first || ne === second ? nw : ne;
    if (third !== first && third !== second) {
      if (decoder.bit(this.c, q) === 0) return third;
      tried |= 1 << third;
    }
    return this.walk(first, tried, way, steepness);
  }

  walk(first, tried, way, steepness) {
    let above = 0;
    let below = 0;
    for (let c = 0; c < CODES; c++)
      if (!(tried & (1 << c))) {
        if (c > first) above++;
        else below++;
      }
    const upwards = above > 0 && below > 0 ? this.decoder.bit(this.d, way) : above > 0 ? 1 : 0;
    const list = 15 * (2 * steepness + upwards);
    const step = upwards ? 1 : -1;
    let left = upwards ? above : below;
    for (let c = first + step, passed = 0; ; c += step) {
      if (tried & (1 << c)) continue;
      if (--left === 0 || this.decoder.bit(this.f, list + passed) === 0) return c;
      passed++;
    }
  }
}
