const RAYS = { across: 24, down: 18 }; // of a view, that are followed
const STEPS = 3; // in which a ray finds how far its place is

/** How much of a view no photograph shows, from a coarse map of the panorama (surfaces/seen_map.js). */
export class SeenShare {
  /**
   * @param {import('../reader/records.js').Head} head
   * @param {import('../surfaces/seen_map.js').SeenMap} map
   */
  constructor(head, map) {
    Object.assign(this, { head, map });
    this.rayRadius = head.rays === 'pushbroom' ? head.radius : 0;
  }

  /**
   * @param {import('./surface_renderer.js').ViewCamera} camera
   * @returns {{unseen: number, right: number, down: number}} the share of its pixels; where the middle of what is seen
   *   lies from the view's, as slopes
   */
  of(camera) {
    const { width, height, fx, fy, cx, cy } = camera;
    let [seen, right, down] = [0, 0, 0];
    for (let row = 0; row < RAYS.down; row++)
      for (let column = 0; column < RAYS.across; column++) {
        const x = (((column + 0.5) / RAYS.across) * width - cx) / fx;
        const y = (((row + 0.5) / RAYS.down) * height - cy) / fy;
        const share = this.along(camera, x, y);
        seen += share;
        right += share * x;
        down += share * y;
      }
    const unseen = 1 - seen / (RAYS.across * RAYS.down);
    return seen > 0 ? { unseen, right: right / seen, down: down / seen } : { unseen, right: 0, down: 0 };
  }

  /** What is there on the ray of slopes x and y: 0 .. 1. */
  along({ eye, axes }, x, y) {
    const ray = [0, 1, 2].map((k) => axes[k] * x + axes[3 + k] * y + axes[6 + k]);
    let place = this.placeOf(Math.atan2(ray[1], ray[0]), ray[2] / Math.hypot(ray[0], ray[1]));
    for (let step = 0; step < STEPS; step++) {
      const w = this.map.w[this.cell(place)];
      const t = w > 0 ? distanceTo(this.rayRadius + 1 / w, eye, ray) : null;
      if (t === null) break;
      const [px, py, pz] = [0, 1, 2].map((k) => eye[k] + t * ray[k]);
      place = this.placeOf(Math.atan2(py, px), pz * w);
    }
    return this.isOnGrid(place) ? this.map.share[this.cell(place)] : 0;
  }

  /** In cells from the panorama's upper left corner. */
  placeOf(theta, v) {
    const { head, map } = this;
    const turn = 2 * Math.PI;
    const extent = head.width * head.thetaPitch;
    // Of the turns of an angle the one nearest to the panorama's middle.
    const fromMiddle = head.thetaLeft - extent / 2 - theta;
    const across = extent / 2 + fromMiddle - turn * Math.round(fromMiddle / turn);
    return { x: (across / extent) * map.columns, y: ((head.vTop - v) / (head.vPitch * head.height)) * map.rows };
  }

  isOnGrid({ x, y }) {
    const { columns, rows } = this.map;
    return (this.head.wraps || (x >= 0 && x < columns)) && y >= 0 && y < rows;
  }

  cell({ x, y }) {
    const { columns, rows } = this.map;
    const within = (value, count) => Math.min(count - 1, Math.max(0, Math.floor(value)));
    return within(y, rows) * columns + within(x, columns);
  }
}

/** How far along a ray it leaves a cylinder about the axis; null where it never does. */
function distanceTo(radius, eye, ray) {
  const a = ray[0] ** 2 + ray[1] ** 2;
  const b = eye[0] * ray[0] + eye[1] * ray[1];
  const c = eye[0] ** 2 + eye[1] ** 2 - radius ** 2;
  const root = b * b - a * c;
  if (!(a > 0) || root < 0) return null;
  const t = (Math.sqrt(root) - b) / a;
  return t > 0 ? t : null;
}
