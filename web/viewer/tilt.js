/** Turns the view, and so moves the eye along the arc, as the device is turned. */
export class Tilt {
  /** @param {(by: {yaw: number, pitch: number}) => void} turned radians to the left, up, since the last call */
  constructor(turned) {
    this.turned = turned;
    this.before = null;
    this.follow = (event) => this.turn(event);
  }

  static get isThere() { return 'ontouchstart' in window && 'DeviceOrientationEvent' in window; }

  /** Asks where systems demand it: from within a click. @returns {Promise<boolean>} whether it was allowed */
  async start() {
    const ask = DeviceOrientationEvent.requestPermission;
    if (ask && (await ask.call(DeviceOrientationEvent)) !== 'granted') return false;
    window.addEventListener('deviceorientation', this.follow);
    return true;
  }

  stop() { window.removeEventListener('deviceorientation', this.follow); }

  turn({ alpha, beta, gamma }) {
    if (alpha === null) return;
    const [a, b, g] = [alpha, beta, gamma].map((degrees) => (degrees * Math.PI) / 180);
    // Ahead is against the screen's normal.
    const x = -(Math.cos(a) * Math.sin(g) + Math.sin(a) * Math.sin(b) * Math.cos(g));
    const y = -(Math.sin(a) * Math.sin(g) - Math.cos(a) * Math.sin(b) * Math.cos(g));
    const z = -Math.cos(b) * Math.cos(g);
    const now = { yaw: Math.atan2(y, x), pitch: Math.asin(Math.min(1, Math.max(-1, z))) };
    if (this.before) {
      const turned = now.yaw - this.before.yaw;
      this.turned({ yaw: turned - 2 * Math.PI * Math.round(turned / (2 * Math.PI)), pitch: now.pitch - this.before.pitch });
    }
    this.before = now;
  }
}
