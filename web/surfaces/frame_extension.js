import { ABSENT, emptyLayer, sameSurface } from './prepared_layer.js';

const INSIDE_PX = 10; // nearer to a photograph's border depths are unsure
const WITNESSED_ROWS = 4; // of a surface that goes on, which two photographs could show
const ROW_STEP = 4; // of the rows that are asked for that
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
    this.cameras = cameras.map((camera) => inArcAxes(camera, head));
  }

  /** Whether at least `least` could show row `row` of column x (both may be outside) at inverse depth w > 0. */
  showing(x, row, w, least) {
    const { thetaLeft, thetaPitch, vTop, vPitch } = this.head;
    const theta = thetaLeft - (x + 0.5) * thetaPitch;
    const out = this.rayRadius + 1 / w;
    const [px, py, pz] = [out * Math.cos(theta), out * Math.sin(theta), (vTop - (row + 0.5) * vPitch) / w];
    for (const camera of this.cameras) if (isInside(camera, px, py, pz) && --least === 0) return true;
    return false;
  }
}

/** The camera with its centre and its axes (rows right, down, forward) in the arc's axes. */
function inArcAxes(camera, { axes, centre }) {
  const [r, c] = [camera.rotation, camera.centre];
  const column = (m, k) => [m[k], m[3 + k], m[6 + k]];
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const away = [c[0] - centre[0], c[1] - centre[1], c[2] - centre[2]];
  return { ...camera, at: [0, 1, 2].map((k) => dot(away, column(axes, k))),
           rows: [0, 1, 2].map((i) => [0, 1, 2].map((k) => dot(column(r, i), column(axes, k)))) };
}

function isInside({ rows, at, fx, fy, cx, cy, width, height, distortion: [k1, k2, p1, p2] }, px, py, pz) {
  const [dx, dy, dz] = [px - at[0], py - at[1], pz - at[2]];
  const z = rows[2][0] * dx + rows[2][1] * dy + rows[2][2] * dz;
  if (z <= 0) return false;
  const x = (rows[0][0] * dx + rows[0][1] * dy + rows[0][2] * dz) / z;
  const y = (rows[1][0] * dx + rows[1][1] * dy + rows[1][2] * dz) / z;
  const r2 = x * x + y * y;
  const radial = 1 + r2 * (k1 + r2 * k2);
  const u = fx * (x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)) + cx;
  const v = fy * (y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y) + cy;
  return u >= INSIDE_PX && v >= INSIDE_PX && u <= width - INSIDE_PX && v <= height - INSIDE_PX;
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
    for (let x = 0; x < this.front.columns; x++) this.extendColumn(x);
    this.dropUnwitnessed();
    return this.layer();
  }

  w(x, y) { return this.front.w[y * this.front.columns + x]; }

  extendColumn(x) {
    for (let y = 0; y < this.head.height; y++) {
      if (!this.ends(x, y)) continue;
      const rows = this.rowsBeyond(x, y);
      if (rows > 0) this.pieces.push({ x, from: y, rows, witnessed: this.witnessed(x, y) });
    }
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
    let rows = 0;
    while (rows < most && !this.frames.showing(x, y + this.step * (rows + 1), w, 1)) rows++;
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
