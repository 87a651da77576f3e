import { BackgroundFill } from './background_fill.js';
import { Target } from './gl.js';
import { SurfaceRenderer } from './surface_renderer.js';

/** Everything of a panorama that lives on the graphics chip; made anew when its context was lost. */
export class Scene {
  /**
   * @param {HTMLCanvasElement} canvas
   * @param {import('../reader/records.js').Head} head
   * @param {import('../reader/records.js').Exposure|null} exposure
   */
  constructor(canvas, head, exposure) {
    this.canvas = canvas;
    this.gl = contextOf(canvas);
    this.surfaces = new SurfaceRenderer(this.gl, head, exposure);
    this.fill = new BackgroundFill(this.gl, head);
    this.picture = null;
  }

  /** 0: colours as stored; 1: at even exposure. */
  set even(share) { this.surfaces.even = share; }

  addStrip(number, strip) { this.surfaces.addStrip(number, strip); }
  removeStrip(number) { this.surfaces.freeStrip(number); }

  /** Draws into the canvas, which takes the camera's size. @param {import('./surface_renderer.js').ViewCamera} camera */
  draw(camera) { this.drawBeside([camera]); }

  /** Pictures of one size beside each other in the canvas. @param {import('./surface_renderer.js').ViewCamera[]} cameras */
  drawBeside(cameras) {
    const { width, height } = cameras[0];
    const all = { width: width * cameras.length, height };
    if (this.canvas.width !== all.width || this.canvas.height !== height) Object.assign(this.canvas, all);
    cameras.forEach((camera, i) => this.drawInto(camera, { framebuffer: null, x: i * width, y: 0 }));
  }

  /**
   * @param {import('./surface_renderer.js').ViewCamera} camera
   * @param {{framebuffer: WebGLFramebuffer|null, x: number, y: number}} place its picture's lower left corner there
   */
  drawInto(camera, place) {
    const { gl } = this;
    const { width, height } = camera;
    if (this.picture?.width !== width || this.picture.height !== height) {
      this.picture?.free();
      this.picture = new Target(gl, width, height, { internal: gl.RGBA8, format: gl.RGBA, type: gl.UNSIGNED_BYTE }, true);
    }
    this.picture.bind();
    gl.clearColor(0, 0, 0, 0);
    gl.clearDepth(1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    this.surfaces.draw(camera);
    this.fill.run(this.picture, camera, this.surfaces.near, place);
  }

  /** @returns {Uint8Array} RGBA of what was drawn last, its first row first; to be asked before the browser shows it */
  pixels() {
    const { gl, canvas: { width, height } } = this;
    const data = new Uint8Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, data);
    const upright = new Uint8Array(data.length);
    for (let y = 0; y < height; y++) upright.set(data.subarray(4 * width * y, 4 * width * (y + 1)), 4 * width * (height - 1 - y));
    return upright;
  }
}

function contextOf(canvas) {
  const gl = canvas.getContext('webgl2', { alpha: false, antialias: false, depth: false, powerPreference: 'high-performance' });
  if (!gl) throw new Error('this browser shows no 3D pictures (WebGL 2 is off or missing)');
  return gl;
}
