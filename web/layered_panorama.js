import { Controls } from './viewer/controls.js';
import { Frame } from './viewer/frame.js';
import { Headset } from './viewer/headset.js';
import { Scene } from './viewer/scene.js';
import { SeenShare } from './viewer/seen_share.js';
import { startWorker } from './viewer/start_worker.js';
import { Tilt } from './viewer/tilt.js';
import { cameraInArcAxes, eyesOf, Viewpoint } from './viewer/viewpoint.js';

const SWAY = { reach: 0.12, seconds: 6 }; // radians along the arc, there and back
const MOST_PIXEL_RATIO = 2;
const EYES = 0.064; // metres apart
const LONGEST_STEP = 0.1; // seconds that one frame moves things on at most

/**
 * <layered-panorama src="room.ldp"></layered-panorama>: shows a panorama with parallax.
 *
 * Attributes: src, an address of an .ldp file. Instead of it, `element.file = ArrayBuffer`. exposure, `local` or `even`.
 * Events: `preview` when there is something to see, then more of it; `load` when everything is there; `error` (detail:
 * words) when it cannot be shown.
 */
export class LayeredPanorama extends HTMLElement {
  static observedAttributes = ['src', 'exposure'];

  constructor() {
    super();
    this.frame = new Frame(this.attachShadow({ mode: 'open' }));
    this.bytes = null;
    this.worker = null;
    this.tilt = null;
    this.forget();
    this.listen();
  }

  connectedCallback() {
    this.sizes = new ResizeObserver(() => this.changed());
    this.sizes.observe(this);
    if (this.bytes && !this.worker && !this.complete) this.prepare();
  }

  disconnectedCallback() {
    this.sizes?.disconnect();
    this.endWorker();
  }

  attributeChangedCallback(name, before, value) {
    if (name === 'exposure') this.expose(value);
    else if (value) this.load(value);
  }

  /** The whole file. @param {ArrayBuffer} bytes */
  set file(bytes) {
    this.bytes = bytes;
    this.prepare();
  }

  /** Whether all of the panorama is shown. */
  get complete() { return this.isComplete; }

  /**
   * Draws what a camera sees, at the camera's size, whatever the viewer's own size is.
   * @param {Parameters<typeof cameraInArcAxes>[1]} camera
   * @returns {Uint8Array} RGBA, row by row
   */
  pictureOf(camera) {
    this.scene.draw(cameraInArcAxes(this.opened.head, camera));
    const pixels = this.scene.pixels();
    this.changed();
    return pixels;
  }

  // ---- loading

  async load(src) {
    this.frame.showMessage('');
    this.frame.showProgress(0);
    const stale = () => this.getAttribute('src') !== src;
    try {
      const response = await fetch(src);
      if (!response.ok) throw new Error(`the server answered ${response.status}`);
      const bytes = await response.arrayBuffer();
      if (!stale()) this.file = bytes;
    } catch (error) {
      if (!stale()) this.fail(`${src} cannot be loaded: ${error.message}`);
    }
  }

  forget() {
    this.isComplete = false;
    this.opened = null;
    this.scene = null;
    this.viewpoint = null;
    this.controls?.end();
    this.controls = null;
    this.headset?.end();
  }

  endWorker() {
    this.worker?.terminate();
    this.worker = null;
  }

  /** From the file's bytes to the first picture and on; again after a lost context. */
  prepare(viewpoint = null) {
    this.endWorker();
    this.forget();
    this.frame.showMessage('');
    this.frame.showProgress(0);
    this.keptViewpoint = viewpoint;
    try {
      this.worker = startWorker();
    } catch (error) {
      this.fail(`no worker can be started: ${error.message}`);
      return;
    }
    this.worker.onmessage = ({ data }) => this.hear(data);
    this.worker.onerror = (event) => this.fail(`the worker ended: ${event.message ?? 'for an unknown reason'}`);
    this.worker.postMessage({ file: this.bytes });
  }

  /** @param {import('./viewer/preparation.js').PreparationMessage} message */
  hear({ opened, map, progress, number, strip, removed, seen, done, failed }) {
    try {
      if (opened) this.open(opened);
      if (map) this.viewpoint.frameBy(new SeenShare(this.opened.head, map));
      if (progress !== undefined) this.frame.showProgress(progress);
      if (strip) this.scene?.addStrip(number, strip);
      if (removed !== undefined) this.scene?.removeStrip(removed);
      if (done) this.finish();
      if (failed) this.fail(failed);
      if (seen || done) this.changed();
      if (seen) this.dispatchEvent(new Event('preview'));
    } catch (error) {
      this.fail(error.message);
    }
  }

  open(opened) {
    this.opened = opened;
    this.scene = new Scene(this.frame.canvas, opened.head, opened.exposure);
    this.scene.even = this.isEven ? 1 : 0;
    this.frame.evenButton.hidden = opened.exposure === null;
    this.viewpoint = this.keptViewpoint ?? new Viewpoint(opened.head);
    this.viewpoint.swayReach = this.isUntouched ? SWAY.reach : 0;
    this.controls = new Controls(this.frame.canvas, this.viewpoint, { changed: () => this.changed(), touched: () => this.touched() });
    this.frame.describe(opened, this.bytes.byteLength);
  }

  finish() {
    this.endWorker();
    this.isComplete = true;
    this.frame.showProgress(null);
    this.dispatchEvent(new Event('load'));
  }

  fail(words) {
    this.endWorker();
    this.frame.showProgress(null);
    this.frame.showMessage(`This panorama cannot be shown: ${words}.`);
    this.dispatchEvent(new CustomEvent('error', { detail: words }));
  }

  // ---- hands

  listen() {
    const { canvas, fullButton, tiltButton, eyesButton, evenButton, headsetButton } = this.frame;
    fullButton.onclick = () => this.toggleFullScreen();
    fullButton.hidden = !this.requestFullscreen;
    tiltButton.hidden = !Tilt.isThere;
    tiltButton.onclick = () => this.toggleTilt();
    eyesButton.hidden = !Tilt.isThere;
    eyesButton.onclick = () => this.toggleTwoEyes();
    evenButton.onclick = () => this.toggleExposure();
    headsetButton.onclick = () => this.putOnHeadset();
    Headset.isThere().then((there) => { headsetButton.hidden = !there; });
    canvas.addEventListener('keydown', (event) => {
      if (event.code === 'KeyF') this.toggleFullScreen();
      if (event.code === 'KeyI') this.frame.togglePanel();
      if (event.code === 'KeyL' && this.opened?.exposure) this.toggleExposure();
    });
    canvas.addEventListener('webglcontextlost', (event) => {
      event.preventDefault();
      this.scene = null;
    });
    canvas.addEventListener('webglcontextrestored', () => this.prepare(this.viewpoint));
    this.isUntouched = !matchMedia('(prefers-reduced-motion: reduce)').matches;
  }

  touched() {
    this.isUntouched = false;
    this.frame.hideHint();
  }

  toggleFullScreen() {
    if (document.fullscreenElement) document.exitFullscreen();
    else this.requestFullscreen?.();
  }

  /** Photos on automatic exposure: each direction as bright as they were, or all as if taken at one exposure. */
  expose(exposure) {
    this.isEven = exposure === 'even';
    if (this.scene) this.scene.even = this.isEven ? 1 : 0;
    this.frame.evenButton.setAttribute('aria-pressed', String(this.isEven));
    this.changed();
  }

  toggleExposure() {
    this.touched();
    this.setAttribute('exposure', this.isEven ? 'local' : 'even');
  }

  /** Pictures for both eyes beside each other: a phone in a holder with lenses. */
  toggleTwoEyes() {
    this.touched();
    this.isForTwoEyes = !this.isForTwoEyes;
    this.frame.eyesButton.setAttribute('aria-pressed', String(this.isForTwoEyes));
    this.changed();
  }

  async putOnHeadset() {
    if (!this.scene || this.headset) return;
    this.touched();
    try {
      this.headset = new Headset(this.scene, this.viewpoint);
      await this.headset.run();
    } catch (error) {
      this.frame.showMessage(`The headset cannot be used: ${error.message}.`);
    }
    this.headset = null;
    this.changed();
  }

  async toggleTilt() {
    this.touched();
    if (this.tilt) {
      this.tilt.stop();
      this.tilt = null;
    } else {
      this.tilt = new Tilt((by) => {
        this.viewpoint?.move(by);
        this.changed();
      });
      if (!(await this.tilt.start())) this.tilt = null;
    }
    this.frame.tiltButton.setAttribute('aria-pressed', String(this.tilt !== null));
  }

  // ---- drawing, only when there is something new

  changed() {
    if (!this.frameAsked) this.frameAsked = requestAnimationFrame((now) => this.drawFrame(now));
  }

  drawFrame(now) {
    this.frameAsked = 0;
    const seconds = Math.min(LONGEST_STEP, (now - (this.lastFrame ?? now)) / 1000);
    this.lastFrame = now;
    if (!this.scene || !this.isConnected || this.headset) return;
    this.controls.step(seconds);
    const ratio = Math.min(MOST_PIXEL_RATIO, devicePixelRatio || 1);
    const { clientWidth, clientHeight } = this.frame.canvas;
    const [width, height] = [clientWidth, clientHeight].map((side) => Math.max(1, Math.round(side * ratio)));
    const eyes = this.isForTwoEyes ? 2 : 1;
    const camera = this.viewpoint.camera(Math.max(1, Math.floor(width / eyes)), height, this.sway(now));
    this.scene.drawBeside(eyes === 2 ? eyesOf(camera, EYES) : [camera]);
    if (this.isSwaying || this.controls.isMoving) this.changed();
  }

  /** While parts are still made the machine has other things to do. */
  get isSwaying() { return this.isUntouched && this.isComplete; }

  /** A gentle move from side to side, until a hand is laid on. */
  sway(now) {
    if (!this.isSwaying) return 0;
    this.swayBegan ??= now;
    return SWAY.reach * Math.sin((2 * Math.PI * (now - this.swayBegan)) / 1000 / SWAY.seconds);
  }
}

customElements.define('layered-panorama', LayeredPanorama);
