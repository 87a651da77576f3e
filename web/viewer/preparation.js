import { decodeImageInBrowser, ImagesAhead } from '../reader/browser_images.js';
import { imageSize } from '../reader/image_size.js';
import { LdpReader } from '../reader/ldp_reader.js';
import { verdictOf } from '../reader/verdict.js';
import { MeshBuilder } from '../surfaces/mesh.js';
import { mapOfSeen } from '../surfaces/seen_map.js';
import { stripOfThumbnail } from '../surfaces/thumbnail.js';

const MOST_SHOWN_PIXELS = 2 ** 25; // of a layer: what the memory of a phone holds several of

const THUMBNAIL = -1; // the number of its strip
const MOST_THUMBNAIL_PX = 480; // a side

/**
 * What a preparation tells, in this order:
 *   {opened: {head, layers, exposure, verdict, metadata}}  everything but the layers
 *   {progress: 0 .. 1}                            again and again
 *   {map}                                         where the front layer shows anything (surfaces/seen_map.js)
 *   {number, strip}                               a strip to draw; when it comes again, more cells and all of its torn quads
 *   {seen: true}                                  the strips so far make a picture
 *   {removed: number}                             a strip that is not to be drawn any more
 *   {done: true} or {failed: message}
 * @typedef {object} PreparationMessage
 */

/**
 * Reads a file and makes its mesh: first of its small picture, then of the front layer alone, so that something is seen
 * soon, then of all.
 * @param {ArrayBuffer} file
 * @param {(message: PreparationMessage, transferred?: ArrayBuffer[]) => void} tell
 */
export async function prepare(file, tell) {
  try {
    const reader = new LdpReader(file, { mostPixels: MOST_SHOWN_PIXELS });
    tell({ opened: { head: reader.head, layers: reader.layers, exposure: reader.exposure,
                     verdict: verdictOf(reader.quality), metadata: Object.fromEntries(reader.metadata) } });
    const builder = new MeshBuilder(reader.head, reader.cameras);
    const steps = reader.layers.length + 1;
    const ahead = new ImagesAhead();
    ahead.begin(reader.imagesOf(0));
    for (let layer = 0; layer < reader.layers.length; layer++) {
      const onProgress = (share) => tell({ progress: (layer + share) / steps });
      const onDepths = (planes) => layer === 0 && tellWhatIsSeen(reader, planes, tell);
      const planes = await reader.readLayer(layer, { decodeImage: ahead.decodeImage, onProgress, onDepths });
      if (layer + 1 < reader.layers.length) ahead.begin(reader.imagesOf(layer + 1));
      builder.addLayer(planes, reader.layers[layer].blockPx > 0);
      if (layer > 0) continue;
      tellStrips(builder, tell, () => {});
      tell({ removed: THUMBNAIL });
      tell({ seen: true });
    }
    builder.addMadeUp();
    tellStrips(builder, tell, (share) => tell({ progress: (steps - 1 + share) / steps }));
    tell({ done: true });
  } catch (error) {
    tell({ failed: error.message });
  }
}

/** How views are framed, and then something to see. */
async function tellWhatIsSeen(reader, planes, tell) {
  tell({ map: mapOfSeen(reader.head, planes) });
  await tellThumbnail(reader, tell);
}

/** A file without one, or with one that cannot be decoded, is shown all the same: a little later. */
async function tellThumbnail({ head, thumbnail }, tell) {
  const size = thumbnail && imageSize(thumbnail);
  if (!size || Math.max(size.width, size.height) > MOST_THUMBNAIL_PX) return;
  const image = await decodeImageInBrowser(thumbnail, size.type).catch(() => null);
  if (!image) return;
  tell({ number: THUMBNAIL, strip: stripOfThumbnail(head, image) });
  tell({ seen: true });
}

function tellStrips(builder, tell, onProgress) {
  for (let number = 0; number < builder.stripCount; number++) {
    const strip = builder.buildStrip(number);
    const transferred = [strip.opaque, strip.soft];
    for (const { vertices, triangles, texture } of strip.cells) transferred.push(vertices, triangles.buffer, texture.data.buffer);
    tell({ number, strip }, transferred);
    onProgress((number + 1) / builder.stripCount);
  }
}
