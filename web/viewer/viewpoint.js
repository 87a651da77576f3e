const MOST_FIELD_OF_VIEW = 1.75; // radians, the wider side of the picture
const FIT = 0.96; // share of the panorama's height that fills the picture at zoom 1
const ZOOM = [0.6, 6];
const SOFT_SHARE = 0.2; // of a range, before its limits, in which moves become smaller and smaller

/**
 * Where one stands and looks. Every move takes a number within limits; near them it gets smaller, so that the eye never
 * bumps into a wall.
 */
export class Viewpoint {
  /** @param {import('../reader/records.js').Head} head */
  constructor(head) {
    this.head = head;
    const unit = head.radius > 0 ? head.radius : Math.max(head.limits.outer, 1e-3);
    /** what a hand's move of 1 moves the eye by, the capture's unit */
    this.unit = unit;
    const half = (head.width * head.thetaPitch) / 2;
    const middle = head.thetaLeft - half;
    const slope = (row) => Math.atan(head.vTop - row * head.vPitch);
    const along = head.closed || head.wraps ? Math.PI : (head.thetaEnd - head.thetaBegin) / 2;
    this.limits = {
      yaw: head.wraps ? null : [middle - half, middle + half],
      pitch: [slope(head.height), slope(0)],
      side: [-Math.min(along, 1), Math.min(along, 1)],
      out: [Math.min(head.limits.inner, unit) - unit, Math.max(head.limits.outer, unit) - unit],
      up: [-head.limits.height, head.limits.height],
    };
    this.middle = middle;
    this.reset();
  }

  reset() {
    /** yaw, pitch and side (along the arc, to the right) in radians; out and up in the capture's unit */
    Object.assign(this, { yaw: this.middle, pitch: 0, side: 0, out: 0, up: 0, zoom: 1 });
    this.pitch = Math.min(Math.max(0, this.limits.pitch[0]), this.limits.pitch[1]);
  }

  /**
   * @param {{yaw?: number, pitch?: number, side?: number, out?: number, up?: number}} by left, up, right, forward, up
   */
  move(by) {
    for (const [name, delta] of Object.entries(by)) this[name] += softened(delta, this[name], this.limits[name]);
  }

  zoomBy(factor) { this.zoom = Math.min(ZOOM[1], Math.max(ZOOM[0], this.zoom * factor)); }

  /** Pixels of a picture's focal length: at zoom 1 the panorama fills its height. */
  focal(width, height) {
    const [low, high] = this.limits.pitch;
    const fit = height / (2 * Math.tan(((high - low) * FIT) / 2));
    return this.zoom * Math.max(fit, Math.max(width, height) / (2 * Math.tan(MOST_FIELD_OF_VIEW / 2)));
  }

  /**
   * @param {number} width pixels
   * @param {number} height
   * @param {number} sway radians to the right along the arc, beside what was moved
   * @returns {import('./surface_renderer.js').ViewCamera}
   */
  camera(width, height, sway = 0) {
    const { head, yaw, pitch } = this;
    const f = this.focal(width, height);
    const wanted = yaw - this.side - sway;
    const angle = head.closed || head.wraps ? wanted : Math.min(head.thetaEnd, Math.max(head.thetaBegin, wanted));
    const radius = this.unit + this.out;
    const [c, s, cp, sp] = [Math.cos(yaw), Math.sin(yaw), Math.cos(pitch), Math.sin(pitch)];
    return { width, height, fx: f, fy: f, cx: width / 2, cy: height / 2,
             eye: [radius * Math.cos(angle), radius * Math.sin(angle), this.up],
             axes: [s, -c, 0, c * sp, s * sp, -cp, c * cp, s * cp, sp] };
  }
}

function softened(delta, at, limits) {
  if (!limits) return delta;
  const [least, most] = limits;
  const margin = SOFT_SHARE * (most - least);
  const room = delta > 0 ? most - at : at - least;
  if (!(margin > 0) || room <= 0) return 0;
  return Math.sign(delta) * Math.min(Math.abs(delta) * Math.min(1, room / margin), room);
}

/**
 * A camera as transforms.json has it, in the world, as the scene wants it.
 * @param {import('../reader/records.js').Head} head
 * @param {{width: number, height: number, fx: number, fy: number, cx: number, cy: number, worldFromCamera: number[][]}} camera
 *   worldFromCamera: 4 x 4 in OpenGL axes (x right, y up, z back)
 * @returns {import('./surface_renderer.js').ViewCamera}
 */
export function cameraInArcAxes(head, { worldFromCamera: m, ...lens }) {
  const column = (k) => [head.axes[k], head.axes[3 + k], head.axes[6 + k]];
  const toArc = (v) => [0, 1, 2].map((k) => column(k)[0] * v[0] + column(k)[1] * v[1] + column(k)[2] * v[2]);
  const axis = (k, sign) => toArc([0, 1, 2].map((row) => sign * m[row][k]));
  return { ...lens, eye: toArc([0, 1, 2].map((k) => m[k][3] - head.centre[k])),
           axes: [...axis(0, 1), ...axis(1, -1), ...axis(2, -1)] };
}
