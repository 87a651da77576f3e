import { LdpError } from './errors.js';
import { Models, RangeDecoder } from './range_decoder.js';

/** FORMAT.md, section 6: of absent pixels 0, of an opaque layer's present ones 255 (no chunk says so). */
export function opaqueAlpha(coverage) {
  return coverage.map((present) => (present ? 255 : 0));
}

/**
 * @param {Uint8Array} bytes of an ALPH chunk
 * @param {Uint8Array} coverage width x height
 * @returns {Uint8Array} opacity, width x height
 */
export function decodeAlpha(bytes, coverage, width, height, place) {
  const alpha = new Uint8Array(width * height);
  const decoder = new RangeDecoder(bytes);
  const models = { notOpaque: new Models(16), notClear: new Models(16), digits: new Models(4 * 256) };
  for (let y = 0; y < height && decoder.missing === 0; y++)
    for (let x = 0; x < width; x++) {
      const i = y * width + x;
      if (!coverage[i]) continue;
      const w = x > 0 && coverage[i - 1] ? alpha[i - 1] : -1;
      const n = y > 0 && coverage[i - width] ? alpha[i - width] : -1;
      alpha[i] = decodeValue(decoder, models, w, n);
    }
  if (!decoder.isUsedUp)
    throw new LdpError(`${place}: its coded data: expected an end after ${bytes.length} bytes, found another`);
  return alpha;
}

/** w, n: the neighbours' values, -1 where absent. */
function decodeValue(decoder, { notOpaque, notClear, digits }, w, n) {
  const k = 4 * kindOf(w) + kindOf(n);
  if (decoder.bit(notOpaque, k) === 0) return 255;
  if (decoder.bit(notClear, k) === 0) return 0;
  const expected = w >= 0 && n >= 0 ? (w + n) >> 1 : w >= 0 ? w : n >= 0 ? n : 128;
  const list = 256 * (expected >> 6);
  let node = 1;
  for (let i = 0; i < 8; i++) node = 2 * node + decoder.bit(digits, list + node);
  return node & 255;
}

function kindOf(value) {
  return value < 0 ? 0 : value === 0 ? 1 : value === 255 ? 3 : 2;
}
