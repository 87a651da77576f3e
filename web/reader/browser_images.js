/**
 * The browser's own decoder of JPEG and WebP, in a page or a worker: bytes as they are, no colour management.
 * @type {import('./colour.js').ImageDecoder}
 */
export async function decodeImageInBrowser(bytes, type) { return pixelsOf(await bitmapOf(bytes, type)); }

/** The same, of images that it was told of while there was other work to do: browsers decode in threads of their own. */
export class ImagesAhead {
  constructor() {
    this.begun = new Map(); // by where their bytes begin in the file
    /** @type {import('./colour.js').ImageDecoder} */
    this.decodeImage = async (bytes, type) => {
      const bitmap = this.begun.get(bytes.byteOffset) ?? bitmapOf(bytes, type);
      this.begun.delete(bytes.byteOffset);
      return pixelsOf(await bitmap);
    };
  }

  /** @param {{bytes: Uint8Array, type: string}[]} images of one file */
  begin(images) {
    for (const { bytes, type } of images) {
      const bitmap = bitmapOf(bytes, type);
      bitmap.catch(() => {}); // told when it is asked for
      this.begun.set(bytes.byteOffset, bitmap);
    }
  }
}

async function bitmapOf(bytes, type) {
  return createImageBitmap(new Blob([bytes], { type }), { colorSpaceConversion: 'none', premultiplyAlpha: 'none' });
}

function pixelsOf(bitmap) {
  const { width, height } = bitmap;
  const canvas = typeof OffscreenCanvas === 'undefined'
    ? Object.assign(document.createElement('canvas'), { width, height })
    : new OffscreenCanvas(width, height);
  const pen = canvas.getContext('2d', { willReadFrequently: true });
  pen.drawImage(bitmap, 0, 0);
  bitmap.close();
  return { width, height, data: pen.getImageData(0, 0, width, height).data };
}
