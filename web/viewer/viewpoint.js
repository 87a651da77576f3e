const MOST_FIELD_OF_VIEW = 1.75; // radians, the wider side of the picture
const FIT = 0.96; // share of the panorama's height that fills the picture at zoom 1
const ZOOM = [0.6, 6];
const SOFT_SHARE = 0.2; // of a range, before its limits, in which moves become smaller and smaller
// Share of a view that no photograph shows: of the first view at most, and of any that hands lead to; how much closer
// views come for that.
const UNSEEN = { home: 0.004, most: 0.02 };
const CLOSEST = 4;
const HALVINGS = 6;
const AIMINGS = 3;

/**
 * Where one stands and looks. Every move takes a number within limits; near them it gets smaller, so that the eye never
 * bumps into a wall. Views are framed inside what is seen: turns end where too little would be, and an eye that moves
 * away from the arc comes closer to what there is.
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
    /** how far the eye sways along the arc, radians */
    this.swayReach = 0;
    /** @type {import('./seen_share.js').SeenShare|null} null: not known yet; nothing is framed */
    this.seen = null;
    this.size = { width: 800, height: 600 };
    this.shownZoom = 1;
    this.reset();
  }

  /** @param {import('./seen_share.js').SeenShare} seen */
  frameBy(seen) {
    this.seen = seen;
    this.reframe();
  }

  /** Of the pictures to come, pixels. */
  resize(width, height) {
    if (this.size.width === width && this.size.height === height) return;
    this.size = { width, height };
    this.reframe();
  }

  reframe() {
    if (this.isHome) this.reset();
    else this.settle();
  }

  /** To the middle of what is seen. */
  reset() {
    /** yaw, pitch and side (along the arc, to the right) in radians; out and up in the capture's unit */
    Object.assign(this, { yaw: this.middle, pitch: 0, side: 0, out: 0, up: 0, zoom: 1 });
    this.pitch = Math.min(Math.max(0, this.limits.pitch[0]), this.limits.pitch[1]);
    this.isHome = true;
    if (!this.seen) return;
    for (let i = 0; i < AIMINGS; i++) {
      this.aim();
      this.zoom = this.closerUntil((zoom) => this.unseenAtHome(zoom) <= UNSEEN.home);
    }
  }

  unseenAtHome(zoom) {
    return Math.max(...[-1, 0, 1].map((way) => this.look(zoom, way * this.swayReach).unseen));
  }

  /**
   * @param {{yaw?: number, pitch?: number, side?: number, out?: number, up?: number}} by left, up, right, forward, up
   */
  move(by) {
    this.isHome = false;
    for (const [name, delta] of Object.entries(by)) {
      if (delta === 0) continue;
      const step = softened(delta, this[name], this.limits[name]);
      if (name === 'yaw' || name === 'pitch') this.turn(name, step);
      else this[name] += step;
    }
    if (by.side || by.out || by.up) this.settle();
  }

  /** As far as enough is seen; what shows more of it is free. */
  turn(name, step) {
    const from = this[name];
    if (!this.seen) {
      this[name] += step;
      return;
    }
    const zoom = this.zoom * this.closer();
    const unseenAfter = (share) => {
      this[name] = from + share * step;
      return this.look(zoom).unseen;
    };
    const before = unseenAfter(0);
    const room = Math.max(0, 1 - before / UNSEEN.most);
    const most = Math.max(before, UNSEEN.most);
    if (unseenAfter(1) <= before) return;
    let share = Math.min(1, 3 * room);
    for (let i = 0; i < HALVINGS && share > 0; i++, share /= 2) if (unseenAfter(share) <= most) return;
    this[name] = from;
  }

  zoomBy(factor) {
    this.isHome = false;
    this.zoom = Math.min(ZOOM[1], Math.max(ZOOM[0], this.zoom * factor));
    this.settle();
    this.zoom *= this.closer();
  }

  /** Turns to what is seen where too little is. */
  settle() {
    for (let i = 0; this.seen && i < AIMINGS && this.look(this.zoom).unseen > UNSEEN.most; i++) this.aim();
  }

  aim() {
    const { right, down } = this.look(this.zoom);
    const within = (value, limits) => (limits ? Math.min(limits[1], Math.max(limits[0], value)) : value);
    this.yaw = within(this.yaw - Math.atan(right), this.limits.yaw);
    this.pitch = within(this.pitch - Math.atan(down), this.limits.pitch);
  }

  /** By what a view is enlarged, beside the zoom, so that enough of it is seen. */
  closer() {
    return this.seen ? this.closerUntil((factor) => this.look(this.zoom * factor).unseen <= UNSEEN.most) : 1;
  }

  /** The least factor from 1 on that is enough. */
  closerUntil(isEnough) {
    if (isEnough(1)) return 1;
    let [low, high] = [0, Math.log(CLOSEST)];
    for (let i = 0; i < HALVINGS; i++) {
      const middle = (low + high) / 2;
      if (isEnough(Math.exp(middle))) high = middle;
      else low = middle;
    }
    return Math.exp(high);
  }

  look(zoom, sway = 0) { return this.seen.of(this.cameraAt(zoom, sway)); }

  /** Pixels of a picture's focal length: at zoom 1 the panorama fills its height. */
  focal(zoom) {
    const { width, height } = this.size;
    const [low, high] = this.limits.pitch;
    const fit = height / (2 * Math.tan(((high - low) * FIT) / 2));
    return zoom * Math.max(fit, Math.max(width, height) / (2 * Math.tan(MOST_FIELD_OF_VIEW / 2)));
  }

  /** Slope of the width of the picture shown: by what a drag from side to side turns. */
  get slopeAcross() { return this.size.width / this.focal(this.shownZoom); }

  /**
   * @param {number} width pixels
   * @param {number} height
   * @param {number} sway radians to the right along the arc, beside what was moved
   * @returns {import('./surface_renderer.js').ViewCamera}
   */
  camera(width, height, sway = 0) {
    this.resize(width, height);
    this.shownZoom = this.zoom * this.closer();
    return this.cameraAt(this.shownZoom, sway);
  }

  /** In the arc's axes. */
  eye(sway = 0) {
    const { head } = this;
    const wanted = this.yaw - this.side - sway;
    const angle = head.closed || head.wraps ? wanted : Math.min(head.thetaEnd, Math.max(head.thetaBegin, wanted));
    const radius = this.unit + this.out;
    return [radius * Math.cos(angle), radius * Math.sin(angle), this.up];
  }

  cameraAt(zoom, sway) {
    const { yaw, pitch, size: { width, height } } = this;
    const f = this.focal(zoom);
    const [c, s, cp, sp] = [Math.cos(yaw), Math.sin(yaw), Math.cos(pitch), Math.sin(pitch)];
    return { width, height, fx: f, fy: f, cx: width / 2, cy: height / 2, eye: this.eye(sway),
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
 * The left and the right eye's camera.
 * @param {import('./surface_renderer.js').ViewCamera} camera between them
 * @param {number} apart the capture's unit
 */
export function eyesOf(camera, apart) {
  const { eye, axes } = camera;
  return [-0.5, 0.5].map((side) => ({ ...camera, eye: eye.map((at, k) => at + side * apart * axes[k]) }));
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
