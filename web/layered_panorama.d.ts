/**
 * <layered-panorama src="room.ldp"></layered-panorama>
 * Attributes: `src`; `exposure`, `local` or `even`: of photos on automatic exposure, as bright as they were or as if taken at one.
 * Events: `preview` when there is something to see, then more of it; `load` when everything is there; `error`, a CustomEvent<string> with words, when it cannot be shown.
 */
export class LayeredPanorama extends HTMLElement {
  /** The whole file, instead of `src`. */
  set file(bytes: ArrayBuffer);
  /** Whether all of the panorama is there. */
  readonly complete: boolean;
  /** What a pinhole camera sees (pixels; 4 x 4 in OpenGL axes, as in transforms.json): RGBA, row by row. */
  pictureOf(camera: {
    width: number; height: number; fx: number; fy: number; cx: number; cy: number; worldFromCamera: number[][];
  }): Uint8Array;
}

declare global {
  interface HTMLElementTagNameMap {
    'layered-panorama': LayeredPanorama;
  }
}
