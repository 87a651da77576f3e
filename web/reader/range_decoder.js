/** 1 / (seen + 1.6) in 1/65536, by how often a decision of the kind was seen. */
const RATES = Uint32Array.from({ length: 64 }, (_, seen) => Math.floor(655360 / (10 * seen + 16)));
const MOST_SEEN = 63;
const LEAST_RANGE = 1 << 24;

/** Adaptive models of one list, each the probability of 0 in 1/65536 and how often it was seen. */
export class Models {
  /** @param {number} count */
  constructor(count) {
    this.zero = new Uint16Array(count).fill(32768);
    this.seen = new Uint8Array(count);
  }
}

/** The range decoder of FORMAT.md, section 5. Bytes behind the end count as 0 and are counted. */
export class RangeDecoder {
  /** @param {Uint8Array} bytes */
  constructor(bytes) {
    this.bytes = bytes;
    this.next = 0;
    this.missing = 0;
    // range and code as unsigned 32-bit numbers: fields of an object would be boxed beyond 2^31
    this.state = new Uint32Array([0xffffffff, 0]);
    for (let i = 0; i < 4; i++) this.state[1] = (this.state[1] << 8) | this.nextByte();
  }

  /**
   * @param {Models} models
   * @param {number} i which of them
   * @returns {0|1}
   */
  bit(models, i) {
    const state = this.state;
    const zero = models.zero[i];
    const seen = models.seen[i];
    const bound = Math.imul(state[0] >>> 16, zero) >>> 0;
    const rate = RATES[seen];
    let bit = 0;
    if (state[1] < bound) {
      state[0] = bound;
      models.zero[i] = zero + (Math.imul(65535 - zero, rate) >>> 16);
    } else {
      bit = 1;
      state[1] -= bound;
      state[0] -= bound;
      models.zero[i] = zero - (Math.imul(zero, rate) >>> 16);
    }
    if (seen < MOST_SEEN) models.seen[i] = seen + 1;
    while (state[0] < LEAST_RANGE) {
      state[0] <<= 8;
      state[1] = (state[1] << 8) | this.nextByte();
    }
    return bit;
  }

  /** Whether the bytes were used up exactly. */
  get isUsedUp() { return this.missing === 0 && this.next === this.bytes.length; }

  nextByte() {
    if (this.next < this.bytes.length) return this.bytes[this.next++];
    this.missing++;
    return 0;
  }
}
