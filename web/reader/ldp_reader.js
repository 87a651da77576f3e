import { decodeBlockRanges, singleRange } from './block_ranges.js';
import { decodeColour } from './colour.js';
import { bytesOfChunk, nameOfChunk, readContainer } from './container.js';
import { decodeCoverage, decodeTiles, TILE } from './coverage.js';
import { CodeDecoder, NO_DISPARITY } from './depth_codes.js';
import { LdpError, refuse } from './errors.js';
import { imageSize } from './image_size.js';
import { decodeAlpha, opaqueAlpha } from './opacity.js';
import { RangeDecoder } from './range_decoder.js';
import { readCameras, readExposure, readHead, readLayerRecord, readMetadata, readQuality } from './records.js';

const WHOLE_FILE = ['HEAD', 'thmb', 'cams', 'qual', 'meta', 'expo'];
const OF_STRIPS = ['DPTH', 'ALPH', 'COLR'];
/** What the format allows; a caller with less memory sets less. */
export const MOST_PIXELS = 2 ** 28;

/**
 * One layer, or the columns of one strip of it, all planes row by row.
 * @typedef {object} LayerPlanes
 * @property {number} width columns
 * @property {number} height rows
 * @property {Uint8Array} coverage 1 = present
 * @property {Uint16Array} disparity 0 .. 3825, 65535 where absent
 * @property {Uint8Array} step what one code means at the pixel, in disparity: the width of its block's range
 * @property {Uint8Array} alpha 0 .. 255, 0 where absent
 * @property {Uint8Array} colour r g b, 0 0 0 where absent
 */

/**
 * An .ldp file whose table, geometry and small records are read and checked; its layers are decoded when asked for.
 * All that is refused is refused with an LdpError.
 */
export class LdpReader {
  /**
   * @param {ArrayBuffer|Uint8Array} file must not change while it is read
   * @param {{mostPixels?: number}} [limits] the largest width x height that is read
   */
  constructor(file, { mostPixels = MOST_PIXELS } = {}) {
    this.file = file instanceof Uint8Array ? file : new Uint8Array(file);
    const { version, chunks } = readContainer(this.file);
    this.version = version;
    this.chunks = chunks;
    this.slots = new Map();
    chunks.forEach((chunk) => this.claim(chunk));
    /** @type {import('./records.js').Head} */
    this.head = readHead(this.needed('HEAD'), Math.min(mostPixels, MOST_PIXELS));
    /** @type {import('./records.js').LayerRecord[]} */
    this.layers = Array.from({ length: this.head.layerCount }, (_, layer) => readLayerRecord(
      this.needed('LAYR', layer), `chunk LAYR of layer ${layer + 1}`, this.head));
    this.checkStrips();
    const optional = (type, read, none) => (this.has(type) ? read(this.needed(type)) : none);
    this.cameras = optional('cams', readCameras, []);
    this.quality = optional('qual', readQuality, new Map());
    this.metadata = optional('meta', readMetadata, new Map());
    /** @type {import('./records.js').Exposure|null} null: colours are at even exposure */
    this.exposure = optional('expo', readExposure, null);
    /** @type {Uint8Array|null} a JPEG file */
    this.thumbnail = optional('thmb', (bytes) => bytes, null);
  }

  stripCount(layer) { return Math.ceil(this.head.width / this.layers[layer].stripPx); }

  /**
   * The depth half of a strip: everything but its colours.
   * @param {number} layer
   * @param {number} strip
   * @returns {LayerPlanes & {x0: number, tiles: object}} x0: the strip's first column; without colour
   */
  readDepthStrip(layer, strip) {
    const { blockPx, stripPx, low, high, hasAlpha } = this.layers[layer];
    const height = this.head.height;
    const x0 = strip * stripPx;
    const width = Math.min(this.head.width, x0 + stripPx) - x0;
    const place = nameOfChunk({ type: 'DPTH', layer, strip });
    const bytes = this.needed('DPTH', layer, strip);
    const decoder = new RangeDecoder(bytes);
    const tiles = decodeTiles(decoder, width, height);
    const coverage = decodeCoverage(decoder, tiles, width, height);
    if (!coverage) refuseEnd(place, bytes);
    const ranges = blockPx > 0 ? decodeBlockRanges(decoder, coverage, width, height, blockPx, place) : singleRange(low, high);
    const disparity = new CodeDecoder(decoder, coverage, ranges, width, height).run();
    if (!disparity || !decoder.isUsedUp) refuseEnd(place, bytes);
    const alpha = hasAlpha
      ? decodeAlpha(this.needed('ALPH', layer, strip), coverage, width, height, nameOfChunk({ type: 'ALPH', layer, strip }))
      : opaqueAlpha(coverage);
    return { x0, width, height, tiles, coverage, disparity, step: stepsOf(ranges, coverage, width, height), alpha };
  }

  /**
   * @param {number} layer
   * @param {object} options
   * @param {import('./colour.js').ImageDecoder} [options.decodeImage] without one colours stay 0 0 0
   * @param {(share: number) => void} [options.onProgress] 0 .. 1
   * @param {(planes: LayerPlanes) => Promise<void>|void} [options.onDepths] when all is there but the colours
   * @returns {Promise<LayerPlanes>} the whole layer
   */
  async readLayer(layer, { decodeImage, onProgress = () => {}, onDepths = () => {} } = {}) {
    const { width, height } = this.head;
    const whole = { width, height, coverage: new Uint8Array(width * height),
                    disparity: new Uint16Array(width * height).fill(NO_DISPARITY), step: new Uint8Array(width * height),
                    alpha: new Uint8Array(width * height), colour: new Uint8Array(3 * width * height) };
    const parts = this.readDepths(layer, whole);
    await onDepths(whole);
    for (let strip = 0; decodeImage && strip < parts.length; strip++) {
      pasteColumns(await this.readColour(layer, strip, parts[strip], decodeImage), parts[strip], whole.colour, width, 3);
      onProgress((strip + 1) / parts.length);
    }
    return whole;
  }

  /** All strips of a layer but their colours into `whole`: of each what its colours are decoded with. */
  readDepths(layer, whole) {
    const parts = [];
    let present = 0;
    for (let strip = 0; strip < this.stripCount(layer); strip++) {
      const part = this.readDepthStrip(layer, strip);
      for (const plane of ['coverage', 'disparity', 'step', 'alpha'])
        pasteColumns(part[plane], part, whole[plane], whole.width, 1);
      present += part.coverage.reduce((sum, p) => sum + p, 0);
      const { x0, width, height, tiles, coverage } = part;
      parts.push({ x0, width, height, tiles, coverage });
    }
    if (present !== this.layers[layer].present)
      refuse(`chunk LAYR of layer ${layer + 1}`, 'number of present pixels', this.layers[layer].present, present);
    return parts;
  }

  /** The images of a layer's colours that are no larger than its strips, for who wants to begin decoding them. */
  imagesOf(layer) {
    const most = (pixels) => Math.ceil(pixels / TILE) * TILE;
    const images = [];
    for (let strip = 0; strip < this.stripCount(layer); strip++) {
      const bytes = this.needed('COLR', layer, strip).subarray(1);
      const found = imageSize(bytes);
      if (found && found.width <= most(this.layers[layer].stripPx) && found.height <= most(this.head.height))
        images.push({ bytes, type: found.type });
    }
    return images;
  }

  readColour(layer, strip, part, decodeImage) {
    const place = nameOfChunk({ type: 'COLR', layer, strip });
    return decodeColour(this.needed('COLR', layer, strip), part, this.version, place, decodeImage);
  }

  // ---- the table

  claim(chunk) {
    const { type, layer, strip } = chunk;
    const ofFile = WHOLE_FILE.includes(type);
    const ofStrip = OF_STRIPS.includes(type);
    if (!ofFile && !ofStrip && type !== 'LAYR') {
      if (/^[A-Z]/.test(type))
        throw new LdpError(`${nameOfChunk(chunk)}: needed to read the file, but unknown to this version`);
      return;
    }
    if ((layer === null) !== ofFile || (strip === null) !== !ofStrip)
      refuse(nameOfChunk(chunk), 'layer and strip', 'those of its type', 'others');
    const slot = slotOf(type, layer, strip);
    if (this.slots.has(slot)) throw new LdpError(`${nameOfChunk(chunk)}: it is there a second time`);
    this.slots.set(slot, chunk);
  }

  checkStrips() {
    this.layers.forEach((record, layer) => {
      for (let strip = 0; strip < this.stripCount(layer); strip++) {
        for (const type of ['DPTH', 'COLR']) this.chunk(type, layer, strip);
        if (record.hasAlpha) this.chunk('ALPH', layer, strip);
        else if (this.has('ALPH', layer, strip))
          throw new LdpError(`${nameOfChunk({ type: 'ALPH', layer, strip })}: the layer has no opacity`);
      }
    });
    for (const chunk of this.slots.values()) {
      if (chunk.layer === null) continue;
      if (chunk.layer >= this.layers.length) refuse(nameOfChunk(chunk), 'layer', `1 to ${this.layers.length}`, chunk.layer + 1);
      const strips = this.stripCount(chunk.layer);
      if (chunk.strip !== null && chunk.strip >= strips) refuse(nameOfChunk(chunk), 'strip', `1 to ${strips}`, chunk.strip + 1);
    }
  }

  has(type, layer = null, strip = null) { return this.slots.has(slotOf(type, layer, strip)); }

  chunk(type, layer = null, strip = null) {
    const chunk = this.slots.get(slotOf(type, layer, strip));
    if (!chunk) throw new LdpError(`${nameOfChunk({ type, layer, strip })}: expected one, found none`);
    return chunk;
  }

  needed(type, layer = null, strip = null) { return bytesOfChunk(this.file, this.chunk(type, layer, strip)); }
}

function slotOf(type, layer, strip) {
  return `${type} ${layer ?? '-'} ${strip ?? '-'}`;
}

function refuseEnd(place, bytes) {
  throw new LdpError(`${place}: its coded data: expected an end after ${bytes.length} bytes, found another`);
}

function stepsOf({ blockPx, across, low, high }, coverage, width, height) {
  const steps = new Uint8Array(width * height);
  for (let y = 0, i = 0; y < height; y++) {
    const first = blockPx > 0 ? Math.floor(y / blockPx) * across : 0;
    for (let x = 0; x < width; x++, i++) {
      if (!coverage[i]) continue;
      const block = blockPx > 0 ? first + Math.floor(x / blockPx) : 0;
      steps[i] = high[block] - low[block];
    }
  }
  return steps;
}

function pasteColumns(part, { x0, width, height }, whole, wholeWidth, samples) {
  for (let y = 0; y < height; y++)
    whole.set(part.subarray(y * width * samples, (y + 1) * width * samples), (y * wholeWidth + x0) * samples);
}
