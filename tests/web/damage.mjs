// Files as a bad cable and a careful forger would change them.
import { crc32c } from '../../web/reader/crc32c.js';

/** Numbers that look random, the same ones every time (xorshift32). */
export function randomNumbers(seed) {
  let state = seed >>> 0;
  return (below) => {
    state ^= state << 13;
    state ^= state >>> 17;
    state ^= state << 5;
    return (state >>> 0) % below;
  };
}

/** Makes the length and the checksums right again, so that tests reach what lies behind them. */
export function seal(file) {
  if (file.length < 32) return file;
  const view = new DataView(file.buffer, file.byteOffset, file.length);
  view.setBigUint64(16, BigInt(file.length), true);
  const entries = view.getUint32(12, true);
  if (entries <= Math.floor((file.length - 32) / 32)) {
    for (let at = 32; at < 32 + 32 * entries; at += 32) {
      const [offset, length] = [Number(view.getBigUint64(at + 8, true)), Number(view.getBigUint64(at + 16, true))];
      if (offset + length <= file.length) view.setUint32(at + 24, crc32c(file.subarray(offset, offset + length)), true);
    }
    view.setUint32(24, crc32c(file.subarray(32, 32 + 32 * entries)), true);
  }
  view.setUint32(28, crc32c(file.subarray(0, 28)), true);
  return file;
}

/**
 * `count` damaged copies of the files: cut short, bytes changed, and both behind checksums made right.
 * @param {Uint8Array[]} files
 * @returns {Uint8Array[]}
 */
export function damagedCopies(files, count, seed) {
  const random = randomNumbers(seed);
  const change = (copy) => {
    for (let left = 1 + random(3); left > 0; left--) copy[random(copy.length)] ^= 1 + random(255);
    return copy;
  };
  const ways = [(copy) => copy.slice(0, random(copy.length)), change, (copy) => seal(change(copy)),
                (copy) => seal(change(copy)), (copy) => seal(copy.slice(0, 32 + random(copy.length - 32)))];
  return Array.from({ length: count }, (_, i) => ways[i % ways.length](files[random(files.length)].slice()));
}
