import { ABSENT, emptyLayer, sameSurface } from './prepared_layer.js';

const INSIDE_PX = 10; // nearer to a photograph's border depths are unsure
const WITNESSED_ROWS = 4; // of a surface that goes on, which two photographs could show
const ROW_STEP = 4; // of the rows that are asked for that
const FIRST_STRIDE = 16; // rows over which no photograph begins and ends
const BRIDGE = 64; // columns to either side within which a surface that they do show stands by others
const BRIDGE_SHARE = 0.1; // of its inverse depth by which the other may differ
const MOST_MIRRORED = 160; // rows of a surface that its continuation shows again, there and back
const MOST_OF_ROWS = 0.5; // of the panorama's, that are made up at either end

/**
 * Near surfaces that the photographs' frames cut off, made up beyond them (core/view/mesh/frame_extension.h).
 * @param {import('./prepared_layer.js').PreparedLayer} front
 * @param {import('./prepared_layer.js').CodedDepths} depths
 * @param {import('../reader/records.js').Head} head
 * @param {import('../reader/records.js').SourceCamera[]} cameras without one nothing is made up
 * @returns {import('./prepared_layer.js').PreparedLayer[]} for each end of the columns at which anything goes on
 */
export function extendBeyondFrames(front, depths, head, cameras) {
  if (cameras.length === 0) return [];
  const frames = new Frames(head, cameras);
  return [-1, 1].map((step) => new ColumnEnd(front, depths, head, frames, step).extended()).filter((layer) => layer !== null);
}

/** How many photographs could show a place of the panorama. */
class Frames {
  constructor(head, cameras) {
    this.head = head;
    this.rayRadius = head.rays === 'pushbroom' ? head.radius : 0;
    this.cameras = cameras.map((camera) => photoInArcAxes(camera, head));
    const theta = (_, x) => head.thetaLeft - (x + 0.5) * head.thetaPitch;
    const thetas = Float64Array.from({ length: head.width + 1 }, theta);
    this.cosines = thetas.map(Math.cos);
    this.sines = thetas.map(Math.sin);
    this.last = 0;
  }

  /** Whether at least `least` could show row `row` (it may be outside) of column x at inverse depth w > 0. */
  showing(x, row, w, least) {
    const out = this.rayRadius + 1 / w;
    const px = out * this.cosines[x];
    const py = out * this.sines[x];
    const pz = (this.head.vTop - (row + 0.5) * this.head.vPitch) / w;
    // The one that showed the last place is likely to show this one.
    if (least === 1 && isInside(this.cameras[this.last], px, py, pz)) return true;
    let found = 0;
    for (let i = 0; i < this.cameras.length && found < least; i++) {
      if (!isInside(this.cameras[i], px, py, pz)) continue;
      this.last = i;
      found++;
    }
    return found === least;
  }
}

/** The camera with its centre and its axes (rows right, down, forward) in the arc's axes. */
function photoInArcAxes(camera, { axes, centre }) {
  const { rotation, centre: c, distortion: [k1, k2, p1, p2] } = camera;
  const column = (m, k) => [m[k], m[3 + k], m[6 + k]];
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const away = [c[0] - centre[0], c[1] - centre[1], c[2] - centre[2]];
  const [x, y, z] = [0, 1, 2].map((k) => dot(away, column(axes, k)));
  const [right, down, forward] = [0, 1, 2].map((i) => [0, 1, 2].map((k) => dot(column(rotation, i), column(axes, k))));
  return { ...camera, x, y, z, right, down, forward, k1, k2, p1, p2 };
}

function isInside(camera, px, py, pz) {
  const { right, down, forward, k1, k2, p1, p2 } = camera;
  const dx = px - camera.x;
  const dy = py - camera.y;
  const dz = pz - camera.z;
  const z = forward[0] * dx + forward[1] * dy + forward[2] * dz;
  if (z <= 0) return false;
  const x = (right[0] * dx + right[1] * dy + right[2] * dz) / z;
  const y = (down[0] * dx + down[1] * dy + down[2] * dz) / z;
  const r2 = x * x + y * y;
  const radial = 1 + r2 * (k1 + r2 * k2);
  const u = camera.fx * (x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)) + camera.cx;
  const v = camera.fy * (y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y) + camera.cy;
  return u >= INSIDE_PX && v >= INSIDE_PX && u <= camera.width - INSIDE_PX && v <= camera.height - INSIDE_PX;
}

/**
 * @typedef {object} Piece
 * @property {number} x
 * @property {number} from the surface's own last row
 * @property {number} rows beyond it
 * @property {boolean} witnessed
 */

/** One end of the columns: step is -1 upwards, 1 downwards. */
class ColumnEnd {
  constructor(front, depths, head, frames, step) {
    Object.assign(this, { front, depths, head, frames, step });
    this.back = Math.max(0, frames.rayRadius - head.limits.inner);
    /** @type {Piece[]} */
    this.pieces = [];
  }

  extended() {
    for (let y = 0; y < this.head.height; y++)
      for (let x = 0; x < this.front.columns; x++) if (this.ends(x, y)) this.addPiece(x, y);
    this.pieces.sort((a, b) => a.x - b.x || a.from - b.from);
    this.dropUnwitnessed();
    return this.layer();
  }

  w(x, y) { return this.front.w[y * this.front.columns + x]; }

  addPiece(x, y) {
    const rows = this.rowsBeyond(x, y);
    if (rows > 0) this.pieces.push({ x, from: y, rows, witnessed: this.witnessed(x, y) });
  }

  ends(x, y) {
    const own = this.w(x, y);
    if (own <= 0) return false;
    const next = y + this.step;
    if (next < 0 || next >= this.head.height || this.w(x, next) < 0) return true;
    return this.w(x, next) < own && !this.sameSurface(x, y, next);
  }

  sameSurface(x, y, other) {
    if (other < 0 || other >= this.head.height || this.w(x, other) === ABSENT) return false;
    return sameSurface(this.front, this.depths, y * this.front.columns + x, other * this.front.columns + x);
  }

  /** Rows of the surface that ends here, up to MOST_MIRRORED. */
  ownRows(x, y) {
    let rows = 1;
    while (rows < MOST_MIRRORED && this.sameSurface(x, y - this.step * (rows - 1), y - this.step * rows)) rows++;
    return rows;
  }

  /** Whether two photographs could show this surface, not only its end: what one alone shows may have any depth. */
  witnessed(x, y) {
    const w = this.w(x, y);
    const own = this.ownRows(x, y);
    for (let i = 0, rows = 0; i < own; i += ROW_STEP) {
      if (this.frames.showing(x, y - this.step * i, w, 2)) rows += ROW_STEP;
      if (rows >= WITNESSED_ROWS) return true;
    }
    return false;
  }

  rowsBeyond(x, y) {
    const w = this.w(x, y);
    const most = this.mostRows(w);
    const isShown = (rows) => this.frames.showing(x, y + this.step * rows, w, 1);
    if (most === 0 || isShown(1)) return 0;
    let rows = 1;
    for (let stride = FIRST_STRIDE; stride >= 1; stride /= 2)
      while (rows + stride <= most && !isShown(rows + stride)) rows += stride;
    return rows;
  }

  /** Rows by which an eye within the limits sees farther up (or down) at inverse depth w than one on the arc. */
  mostRows(w) {
    const { vPitch, height, limits } = this.head;
    const rows = (w * (0.5 * vPitch * height * this.back + limits.height)) / vPitch;
    return Math.floor(Math.min(rows, MOST_OF_ROWS * height));
  }

  /** What no two photographs show stays where it stands between two parts, on one surface, that they do. */
  dropUnwitnessed() {
    this.pieces = this.pieces.filter((piece, i) => piece.witnessed || (this.hasWitness(i, -1) && this.hasWitness(i, 1)));
  }

  hasWitness(own, side) {
    const { x, from } = this.pieces[own];
    const w = this.w(x, from);
    for (let i = own + side; i >= 0 && i < this.pieces.length; i += side) {
      const other = this.pieces[i];
      if (Math.abs(other.x - x) > BRIDGE) return false;
      if (other.witnessed && Math.abs(this.w(other.x, other.from) - w) < BRIDGE_SHARE * w) return true;
    }
    return false;
  }

  layer() {
    if (this.pieces.length === 0) return null;
    let [first, last] = [Infinity, -Infinity];
    for (const { from, rows } of this.pieces) {
      const end = from + this.step * rows;
      first = Math.min(first, from, end);
      last = Math.max(last, from, end);
    }
    const made = emptyLayer(this.front.columns, last - first + 1, first);
    for (const piece of this.pieces) this.fill(piece, made);
    return made;
  }

  fill({ x, from, rows }, made) {
    const { front, step } = this;
    const w = this.w(x, from);
    const source = from * front.columns + x;
    const own = this.ownRows(x, from);
    for (let i = 0; i <= rows; i++) {
      const to = (from + step * i - made.top) * made.columns + x;
      if (made.w[to] >= w) continue;
      const phase = i % (2 * own);
      const mirrored = from - step * Math.min(phase, 2 * own - 1 - phase);
      made.w[to] = w;
      made.code[to] = front.code[source];
      made.step[to] = front.step[source];
      made.colour[to] = front.colour[mirrored * front.columns + x];
    }
  }
}
