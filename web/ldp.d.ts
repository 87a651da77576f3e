/** Inverse depth of disparity D is wFar + (wNear - wFar) D / DISPARITY_STEPS. */
export const DISPARITY_STEPS: 3825;
/** Disparity of a pixel that is not there. */
export const NO_DISPARITY: 65535;
/** width x height that the format allows. */
export const MOST_PIXELS: number;

/** Thrown for a file that is no .ldp file, is damaged, or is larger than allowed; the message says where and why. */
export class LdpError extends Error {}
/** An image in the file that the decoder of images refused. */
export class ImageError extends LdpError {}

/** Geometry. Lengths are in the capture's unit, angles in radians; see FORMAT.md, section 2. */
export interface Head {
  width: number;
  height: number;
  layerCount: number;
  rays: 'pushbroom' | 'central';
  wraps: boolean;
  closed: boolean;
  centre: number[];
  /** 3 x 3, row by row; columns u(0), u(90 degrees), n. */
  axes: number[];
  radius: number;
  thetaBegin: number;
  thetaEnd: number;
  thetaLeft: number;
  thetaPitch: number;
  vTop: number;
  vPitch: number;
  wFar: number;
  wNear: number;
  limits: { inner: number; outer: number; height: number };
}

export interface LayerRecord {
  blockPx: number;
  stripPx: number;
  present: number;
  low: number;
  high: number;
  hasAlpha: boolean;
}

export interface SourceCamera {
  name: string;
  width: number;
  height: number;
  fx: number;
  fy: number;
  cx: number;
  cy: number;
  /** k1 k2 p1 p2 */
  distortion: number[];
  /** World from camera, 3 x 3 row by row; columns right, down, forward. */
  rotation: number[];
  centre: number[];
}

/** By what light colours at even exposure were multiplied, by direction; see FORMAT.md, section 4. */
export interface Exposure {
  /** At levels 0, 16 .. 256: the camera's response. */
  light: number[];
  columns: number;
  rows: number;
  /** Of red, green and blue light of each node in 1/4096, row by row. */
  factors: Uint16Array;
}

/** Planes of width x height samples, row by row; colour has r g b of each pixel. */
export interface LayerPlanes {
  width: number;
  height: number;
  /** 1 = present */
  coverage: Uint8Array;
  /** 0 .. 3825, 65535 where absent */
  disparity: Uint16Array;
  /** what one code means at the pixel, in disparity */
  step: Uint8Array;
  alpha: Uint8Array;
  colour: Uint8Array;
}

export type ImageDecoder = (bytes: Uint8Array, type: 'image/jpeg' | 'image/webp') =>
  Promise<{ width: number; height: number; data: Uint8Array | Uint8ClampedArray }>;

/** The browser's own decoder, in pages and workers. */
export const decodeImageInBrowser: ImageDecoder;

export class LdpReader {
  constructor(file: ArrayBuffer | Uint8Array, limits?: { mostPixels?: number });
  readonly version: number;
  readonly head: Head;
  readonly layers: LayerRecord[];
  readonly cameras: SourceCamera[];
  readonly quality: Map<string, number>;
  readonly metadata: Map<string, string>;
  /** Null: colours are at even exposure. */
  readonly exposure: Exposure | null;
  /** A JPEG file. */
  readonly thumbnail: Uint8Array | null;
  stripCount(layer: number): number;
  /** Of the colours, for who wants to begin decoding them. */
  imagesOf(layer: number): { bytes: Uint8Array; type: string }[];
  /** Everything of a strip but its colours; x0 is its first column. */
  readDepthStrip(layer: number, strip: number): Omit<LayerPlanes, 'colour'> & { x0: number };
  /** Without decodeImage colours are 0 0 0. */
  readLayer(layer: number, options?: {
    decodeImage?: ImageDecoder;
    onProgress?: (share: number) => void;
    /** When all is there but the colours. */
    onDepths?: (planes: LayerPlanes) => Promise<void> | void;
  }): Promise<LayerPlanes>;
}

/** A layer's colours as if all photographs had been taken at one exposure: r g b, row by row. */
export function evenedColour(planes: LayerPlanes, head: Head, exposure: Exposure | null): Uint8Array;

export interface Verdict {
  verdict: 'good' | 'fair' | 'sweep_again';
  expectedViewPsnrDb?: number;
  reasons: { code: string; text: string; fromDeg: number; toDeg: number }[];
}

/** Null where the sweep was not judged. */
export function verdictOf(figures: Map<string, number>): Verdict | null;
