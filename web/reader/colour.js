import { TILE, TILE_EMPTY } from './coverage.js';
import { ImageError, refuse } from './errors.js';
import { guidedColour, isLossyWebp } from './guided_colour.js';
import { imageSize } from './image_size.js';

const TILE_PIXELS = TILE * TILE;
const LEAST_OF_WHOLE_TILE = 192; // present pixels with which a gathered image stores a tile as it is

/** Hilbert's curve through a tile: x | y << 4 of its points (FORMAT.md, section 7). */
const TILE_CURVE = Uint8Array.from({ length: TILE_PIXELS }, (_, point) => {
  let [x, y] = [0, 0];
  for (let side = 1, rest = point; side < TILE; side *= 2, rest >>= 2) {
    const rx = (rest >> 1) & 1;
    const ry = (rest ^ rx) & 1;
    if (ry === 0) [x, y] = rx === 1 ? [side - 1 - y, side - 1 - x] : [y, x];
    x += side * rx;
    y += side * ry;
  }
  return x | (y << 4);
});

/**
 * A decoder of images: the browser's own, or any other that gives 8-bit RGBA.
 * @callback ImageDecoder
 * @param {Uint8Array} bytes a JPEG or WebP file
 * @param {'image/jpeg'|'image/webp'} type
 * @returns {Promise<{width: number, height: number, data: Uint8Array|Uint8ClampedArray}>} data: RGBA row by row
 */

/**
 * @param {Uint8Array} bytes of a COLR chunk
 * @param {object} strip
 * @param {{across: number, down: number, states: Uint8Array}} strip.tiles
 * @param {Uint8Array} strip.coverage width x height
 * @param {number} strip.width
 * @param {number} strip.height
 * @param {number} version of the file
 * @param {string} place
 * @param {ImageDecoder} decodeImage
 * @returns {Promise<Uint8Array>} r g b of every pixel, width x height x 3; absent ones are 0 0 0
 */
export async function decodeColour(bytes, strip, version, place, decodeImage) {
  if (bytes.length < 1) refuse(place, 'its length', 'at least 1 byte', 0);
  const codec = bytes[0];
  if (codec > (version === 1 ? 2 : 4)) refuse(place, 'codec', `0 to ${version === 1 ? 2 : 4}`, codec);
  const any = strip.tiles.states.some((state) => state !== TILE_EMPTY);
  if ((codec === 0) === any) refuse(place, 'codec', any ? '1 or more (tiles are stored)' : '0 (no tile is stored)', codec);
  const colour = new Uint8Array(3 * strip.width * strip.height);
  if (codec === 0) {
    if (bytes.length > 1) refuse(place, 'its length', '1 byte', bytes.length);
    return colour;
  }
  const packing = packingOf(strip, codec >= 3);
  const image = await decodeChecked(bytes.subarray(1), codec, packing, place, decodeImage);
  unpack(strip, packing, image.data, image.width, colour);
  return colour;
}

/** Which tiles are stored whole, and the size of the packed image in pixels. */
function packingOf({ tiles, coverage, width, height }, gathered) {
  const whole = new Uint8Array(tiles.states.length);
  let [wholeTiles, loosePixels] = [0, 0];
  for (let i = 0; i < tiles.states.length; i++) {
    if (tiles.states[i] === TILE_EMPTY) continue;
    const present = gathered ? presentIn(coverage, width, height, i % tiles.across, Math.floor(i / tiles.across)) : 0;
    whole[i] = !gathered || present >= LEAST_OF_WHOLE_TILE ? 1 : 0;
    if (whole[i]) wholeTiles++;
    else loosePixels += present;
  }
  const stored = wholeTiles + Math.ceil(loosePixels / TILE_PIXELS);
  return { whole, wholeTiles, width: TILE * tiles.across, height: TILE * Math.ceil(stored / tiles.across) };
}

function presentIn(coverage, width, height, tileX, tileY) {
  let count = 0;
  for (let y = tileY * TILE; y < Math.min(height, (tileY + 1) * TILE); y++)
    for (let x = tileX * TILE; x < Math.min(width, (tileX + 1) * TILE); x++) count += coverage[y * width + x];
  return count;
}

async function decodeChecked(file, codec, expected, place, decodeImage) {
  const type = codec % 2 === 1 ? 'image/jpeg' : 'image/webp';
  const found = imageSize(file);
  if (!found || found.type !== type) refuse(place, 'its image', type, found ? found.type : 'something else');
  if (found.width !== expected.width || found.height !== expected.height)
    refuse(place, 'size of its image', `${expected.width} x ${expected.height}`, `${found.width} x ${found.height}`);
  let image;
  try {
    image = await decodeImage(file, type);
  } catch (error) {
    throw new ImageError(`${place}: its image cannot be decoded: ${error.message}`);
  }
  if (image.width !== expected.width || image.height !== expected.height)
    throw new ImageError(`${place}: its image was decoded to another size`);
  return isLossyWebp(file) ? guidedColour(image) : image;
}

function unpack(strip, packing, rgba, stride, colour) {
  const { tiles, width, height } = strip;
  const copy = (x, y, from) => {
    const to = 3 * (y * width + x);
    colour[to] = rgba[from];
    colour[to + 1] = rgba[from + 1];
    colour[to + 2] = rgba[from + 2];
  };
  const tileAt = (k) => 4 * (Math.floor(k / tiles.across) * TILE * stride + (k % tiles.across) * TILE);
  let [whole, loose] = [0, 0];
  for (let i = 0; i < tiles.states.length; i++) {
    if (tiles.states[i] === TILE_EMPTY) continue;
    const x0 = (i % tiles.across) * TILE;
    const y0 = Math.floor(i / tiles.across) * TILE;
    const first = packing.whole[i] ? tileAt(whole++) : 0;
    for (let point = 0; point < TILE_PIXELS; point++) {
      const inTile = packing.whole[i] ? point : TILE_CURVE[point];
      const x = x0 + (inTile & 15);
      const y = y0 + (inTile >> 4);
      if (x >= width || y >= height || !strip.coverage[y * width + x]) continue;
      if (packing.whole[i]) {
        copy(x, y, first + 4 * ((inTile >> 4) * stride + (inTile & 15)));
      } else {
        const to = TILE_CURVE[loose % TILE_PIXELS];
        copy(x, y, tileAt(packing.wholeTiles + Math.floor(loose / TILE_PIXELS)) + 4 * ((to >> 4) * stride + (to & 15)));
        loose++;
      }
    }
  }
}
