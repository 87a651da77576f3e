/**
 * The kind and size of a JPEG or WebP file, from its beginning alone: what is checked before a decoder sees it.
 * @param {Uint8Array} bytes
 * @returns {{type: 'image/jpeg'|'image/webp', width: number, height: number}|null} null: neither, or no size in it
 */
export function imageSize(bytes) {
  if (bytes[0] === 0xff && bytes[1] === 0xd8) return jpegSize(bytes);
  const text = (at) => String.fromCharCode(...bytes.subarray(at, at + 4));
  if (text(0) === 'RIFF' && text(8) === 'WEBP') return webpSize(bytes, text(12));
  return null;
}

/** The first frame header of a JPEG file. */
function jpegSize(bytes) {
  for (let at = 2; at + 9 < bytes.length && bytes[at] === 0xff;) {
    const marker = bytes[at + 1];
    if (marker === 0xff) {
      at++;
      continue;
    }
    const isFrame = marker >= 0xc0 && marker <= 0xcf && marker !== 0xc4 && marker !== 0xc8 && marker !== 0xcc;
    if (isFrame)
      return { type: 'image/jpeg', height: (bytes[at + 5] << 8) | bytes[at + 6], width: (bytes[at + 7] << 8) | bytes[at + 8] };
    at += 2 + ((bytes[at + 2] << 8) | bytes[at + 3]);
  }
  return null;
}

function webpSize(bytes, kind) {
  if (bytes.length < 30) return null;
  const type = 'image/webp';
  if (kind === 'VP8 ')
    return { type, width: (bytes[26] | (bytes[27] << 8)) & 0x3fff, height: (bytes[28] | (bytes[29] << 8)) & 0x3fff };
  if (kind === 'VP8L') {
    const bits = bytes[21] | (bytes[22] << 8) | (bytes[23] << 16) | (bytes[24] << 24);
    return { type, width: (bits & 0x3fff) + 1, height: ((bits >>> 14) & 0x3fff) + 1 };
  }
  if (kind !== 'VP8X' || bytes[20] & 2) return null; // animations are none of the format
  const number = (at) => (bytes[at] | (bytes[at + 1] << 8) | (bytes[at + 2] << 16)) + 1;
  return { type, width: number(24), height: number(27) };
}
