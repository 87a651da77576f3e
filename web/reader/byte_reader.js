import { LdpError, refuse } from './errors.js';

/** Little-endian numbers from the bytes of one record; every refusal names the place and the field. */
export class ByteReader {
  /**
   * @param {Uint8Array} bytes
   * @param {string} place in messages, such as "chunk HEAD"
   */
  constructor(bytes, place) {
    this.bytes = bytes;
    this.place = place;
    this.view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
    this.position = 0;
  }

  /** @returns {Uint8Array} the next `count` bytes, not copied */
  take(count) {
    const begin = this.skip(count);
    return this.bytes.subarray(begin, begin + count);
  }

  u8() { return this.bytes[this.skip(1)]; }
  u16() { return this.view.getUint16(this.skip(2), true); }
  u32() { return this.view.getUint32(this.skip(4), true); }
  f64() { return this.view.getFloat64(this.skip(8), true); }

  /** A whole number of 8 bytes; one that a double does not hold exactly is refused. */
  u64(field) {
    const value = this.view.getBigUint64(this.skip(8), true);
    if (value > BigInt(Number.MAX_SAFE_INTEGER)) refuse(this.place, field, 'less than 2^53', value.toString());
    return Number(value);
  }

  /** u32 within bounds, both included. */
  whole(field, least, most) {
    const value = this.u32();
    if (value < least || value > most) refuse(this.place, field, `${least} to ${most}`, value);
    return value;
  }

  /** u8 of 0 .. most. */
  choice(field, most) {
    const value = this.u8();
    if (value > most) refuse(this.place, field, `0 to ${most}`, value);
    return value;
  }

  finite(field) {
    const value = this.f64();
    if (!Number.isFinite(value)) refuse(this.place, field, 'a finite number', 'infinity or not a number');
    return value;
  }

  atLeast(field, least) {
    const value = this.finite(field);
    if (value < least) refuse(this.place, field, `at least ${least}`, value);
    return value;
  }

  positive(field) {
    const value = this.finite(field);
    if (!(value > 0)) refuse(this.place, field, 'a positive number', value);
    return value;
  }

  /** @returns {number[]} `count` finite numbers */
  numbers(field, count) {
    return Array.from({ length: count }, () => this.finite(field));
  }

  /** @returns {Uint8Array} the bytes of a `text` */
  textBytes() { return this.take(this.u16()); }

  expectEnd() {
    if (this.position < this.bytes.length)
      refuse(this.place, 'its length', `${this.position} bytes`, this.bytes.length);
  }

  skip(count) {
    const begin = this.position;
    if (count > this.bytes.length - begin)
      throw new LdpError(
        `${this.place}: its length: expected at least ${begin + count} bytes, found ${this.bytes.length}`);
    this.position += count;
    return begin;
  }
}
