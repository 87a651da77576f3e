const SOFT = 0.8; // share of a limit from which on the head's own moves become smaller

/** A panorama in a headset (WebXR): both eyes, head motion softly inside the limits. */
export class Headset {
  /** @param {import('./scene.js').Scene} scene @param {import('./viewpoint.js').Viewpoint} viewpoint where one begins */
  constructor(scene, viewpoint) {
    Object.assign(this, { scene, viewpoint });
    this.session = null;
    this.start = null;
  }

  /** @returns {Promise<boolean>} */
  static async isThere() {
    try {
      return (await navigator.xr?.isSessionSupported('immersive-vr')) === true;
    } catch {
      return false;
    }
  }

  end() { this.session?.end(); }

  /** From within a click; until it is taken off. */
  async run() {
    const { gl } = this.scene;
    await gl.makeXRCompatible();
    const session = await navigator.xr.requestSession('immersive-vr');
    this.session = session;
    session.updateRenderState({ baseLayer: new XRWebGLLayer(session, gl, { alpha: false, antialias: false, depth: false }) });
    const space = await session.requestReferenceSpace('local');
    await new Promise((ended, failed) => {
      session.addEventListener('end', ended);
      const draw = (_, frame) => {
        try {
          this.drawFrame(frame, space);
          session.requestAnimationFrame(draw);
        } catch (error) {
          session.end();
          failed(error);
        }
      };
      session.requestAnimationFrame(draw);
    });
  }

  drawFrame(frame, space) {
    const pose = frame.getViewerPose(space);
    if (!pose) return;
    const layer = this.session.renderState.baseLayer;
    const head = pointOf(pose.transform.matrix);
    this.start ??= head;
    for (const view of pose.views) {
      const { x, y, width, height } = layer.getViewport(view);
      this.scene.drawInto(this.cameraOf(view, head, width, height), { framebuffer: layer.framebuffer, x, y });
    }
  }

  /** The headset's axes (right, up, back) begin as the viewpoint's. */
  cameraOf({ transform: { matrix }, projectionMatrix: p }, head, width, height) {
    const { viewpoint } = this;
    const [c, s] = [Math.cos(viewpoint.yaw), Math.sin(viewpoint.yaw)];
    const toArc = ([x, y, z]) => [s * x - c * z, -c * x - s * z, y];
    const away = toArc(head.map((at, k) => at - this.start[k]));
    const fromHead = toArc(pointOf(matrix).map((at, k) => at - head[k]));
    const centre = insideLimits(viewpoint, viewpoint.eye().map((at, k) => at + away[k]));
    const axis = (k, sign) => toArc([0, 1, 2].map((row) => sign * matrix[4 * k + row]));
    return { width, height, fx: (p[0] * width) / 2, fy: (p[5] * height) / 2, cx: ((1 - p[8]) * width) / 2,
             cy: ((1 + p[9]) * height) / 2, eye: centre.map((at, k) => at + fromHead[k]),
             axes: [...axis(0, 1), ...axis(1, -1), ...axis(2, -1)] };
  }
}

function pointOf(matrix) { return [matrix[12], matrix[13], matrix[14]]; }

/** @param {number[]} eye in the arc's axes */
function insideLimits({ unit, limits }, [x, y, z]) {
  const radius = Math.hypot(x, y);
  const kept = unit + softlyWithin(radius - unit, limits.out);
  const scale = radius > 0 ? kept / radius : 1;
  return [scale * x, scale * y, softlyWithin(z, limits.up)];
}

function softlyWithin(value, [least, most]) {
  const half = (most - least) / 2;
  if (!(half > 0)) return least;
  const share = (value - (least + most) / 2) / half;
  const beyond = Math.abs(share) - SOFT;
  const kept = beyond > 0 ? SOFT + (1 - SOFT) * Math.tanh(beyond / (1 - SOFT)) : Math.abs(share);
  return (least + most) / 2 + half * Math.sign(share) * kept;
}
