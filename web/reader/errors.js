/**
 * A file that is no .ldp file, is damaged, or holds more than the reader may use. The message says which chunk, what was
 * expected and what was found.
 */
export class LdpError extends Error {
  constructor(message) {
    super(message);
    this.name = 'LdpError';
  }
}

/** The image inside a COLR chunk could not be decoded by the decoder of images at hand. */
export class ImageError extends LdpError {
  constructor(message) {
    super(message);
    this.name = 'ImageError';
  }
}

/**
 * @param {string} place what is being read, such as "chunk HEAD"
 * @param {string} field
 * @param {string|number} expected
 * @param {string|number} found
 * @returns {never}
 */
export function refuse(place, field, expected, found) {
  throw new LdpError(`${place}: ${field}: expected ${expected}, found ${found}`);
}
