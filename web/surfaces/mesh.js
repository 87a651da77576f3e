import { extendBeyondFrames } from './frame_extension.js';
import { smoothCodes } from './code_smoother.js';
import { CodedDepths, prepareLayer } from './prepared_layer.js';
import { CellScratch, StripCells } from './strip_cells.js';
import { TornQuads } from './torn_quads.js';
import { makeUnderlay } from './underlay.js';

/** Columns of quads that are prepared, and left out of a view, together. */
export const STRIP_PX = 256;

/**
 * The layers of a panorama as surfaces that tear where depth jumps: the mesh of `ldp render` (core/view/mesh), but for
 * quads that are merged where a surface is flat.
 *
 * Vertices are the centres of present pixels, lifted to their inverse depth w. A quad lies between four neighbouring
 * pixels. Where all four are of one surface and opaque it is solid; where not it is torn, and each surface that touches
 * it becomes a quad of its own.
 */
export class MeshBuilder {
  /**
   * @param {import('../reader/records.js').Head} head
   * @param {import('../reader/records.js').SourceCamera[]} cameras
   */
  constructor(head, cameras) {
    this.head = head;
    this.cameras = cameras;
    this.depths = new CodedDepths(head);
    /** @type {import('./prepared_layer.js').PreparedLayer[]} */
    this.layers = [];
    this.torn = new TornQuads(this.layers, this.depths);
    this.scratch = new CellScratch();
    /** of each strip what is made already: quads of its first layers */
    this.quadsOf = Array.from({ length: this.stripCount }, () => []);
  }

  /**
   * Front to back.
   * @param {import('../reader/ldp_reader.js').LayerPlanes} planes
   * @param {boolean} hasBlocks with one range for all, neighbouring codes are as often two surfaces as one
   */
  addLayer(planes, hasBlocks) {
    this.layers.push(prepareLayer(this.head, this.depths, planes));
    if (hasBlocks) smoothCodes(this.layers[this.layers.length - 1], this.depths);
  }

  /** What no layer shows, behind silhouettes and beyond the photographs' frames: after the last layer. */
  addMadeUp() {
    const underlay = makeUnderlay(this.layers, this.depths, this.head.wraps);
    const beyond = extendBeyondFrames(this.layers[0], this.depths, this.head, this.cameras);
    this.layers.push(underlay, ...beyond);
  }

  get stripCount() { return Math.ceil(this.quadsAcross / STRIP_PX); }
  get quadsAcross() { return this.head.wraps ? this.head.width : this.head.width - 1; }

  /**
   * @typedef {object} MeshStrip everything between columns x0 and x1, of all layers
   * @property {number} x0
   * @property {number} x1
   * @property {number} wMin least inverse depth
   * @property {number} wMax
   * @property {number} top first row with a vertex
   * @property {number} bottom last row
   * @property {import('./strip_cells.js').Cells[]} cells of each layer that has any, front to back: of layers that were not
   *   there yet when the strip was built before
   * @property {ArrayBuffer} opaque torn quads (torn_quads.js) of all layers, in no order
   * @property {ArrayBuffer} soft those with a corner that is not opaque, the farthest first
   */

  /** @param {number} strip @returns {MeshStrip} */
  buildStrip(strip) {
    const x0 = strip * STRIP_PX;
    const x1 = Math.min(x0 + STRIP_PX, this.quadsAcross);
    const { torn } = this;
    const quads = this.quadsOf[strip];
    const cells = [];
    torn.begin(x0);
    this.layers.forEach((layer, index) => {
      if (index === quads.length) {
        quads.push(new StripCells(layer, this.depths, this.head, x0, x1));
        const merged = quads[index].merge(this.scratch);
        if (merged) cells.push(merged);
      }
      torn.addLayer(index, quads[index]);
    });
    const bounds = boundsOf([...quads.map((inLayer) => inLayer.bounds).filter(Boolean), torn.bounds]);
    return { x0, x1, cells, ...torn.take(), ...bounds };
  }
}

function boundsOf(all) {
  const least = (key) => Math.min(...all.map((b) => b[key]));
  const most = (key) => Math.max(...all.map((b) => b[key]));
  return { wMin: least('wMin'), wMax: most('wMax'), top: least('top'), bottom: most('bottom') };
}
