const MOVE_PER_PX = 0.002; // arms' lengths
const WHEEL = 0.001; // of the logarithm of zoom
const KEY_TURN = 0.9; // radians a second
const KEY_MOVE = 0.45; // arms' lengths a second

/** What a key that is held down does, per second. */
const HELD = {
  ArrowLeft: { yaw: KEY_TURN }, ArrowRight: { yaw: -KEY_TURN }, ArrowUp: { pitch: KEY_TURN }, ArrowDown: { pitch: -KEY_TURN },
  KeyA: { side: -KEY_MOVE }, KeyD: { side: KEY_MOVE }, KeyW: { out: KEY_MOVE }, KeyS: { out: -KEY_MOVE },
  KeyE: { up: KEY_MOVE }, KeyQ: { up: -KEY_MOVE },
};
const ZOOM_KEYS = { Equal: 1.1, NumpadAdd: 1.1, Minus: 1 / 1.1, NumpadSubtract: 1 / 1.1 };

/**
 * Hands on a canvas: mouse, fingers, keys, gamepad. They move the viewpoint and call `changed`.
 */
export class Controls {
  /**
   * @param {HTMLElement} surface takes the events; keys while it has the focus
   * @param {import('./viewpoint.js').Viewpoint} viewpoint
   * @param {{changed: () => void, touched: () => void}} listener touched: by a hand, for the first time or again
   */
  constructor(surface, viewpoint, listener) {
    Object.assign(this, { surface, viewpoint, listener });
    this.pointers = new Map();
    this.held = new Set();
    this.stop = new AbortController();
    const on = (type, action, options = {}) =>
      surface.addEventListener(type, action.bind(this), { signal: this.stop.signal, ...options });
    on('pointerdown', this.press);
    on('pointermove', this.drag);
    for (const type of ['pointerup', 'pointercancel']) on(type, this.release);
    on('wheel', this.roll, { passive: false });
    on('contextmenu', (event) => event.preventDefault());
    on('keydown', this.keyDown);
    on('keyup', (event) => this.held.delete(event.code));
    on('blur', () => this.held.clear());
    window.addEventListener('gamepadconnected', () => this.watchGamepads(), { signal: this.stop.signal });
    this.watchGamepads();
  }

  end() { this.stop.abort(); }

  /** No event tells that a stick was moved. */
  watchGamepads() {
    if (this.isWatching) return;
    const look = () => {
      this.isWatching = !this.stop.signal.aborted && gamepads().length > 0;
      if (!this.isWatching) return;
      if (gamepads().some(isHeld)) {
        this.listener.touched();
        this.listener.changed();
      }
      requestAnimationFrame(look);
    };
    look();
  }

  /** Whether a step is due although no event comes. */
  get isMoving() { return this.held.size > 0 || gamepads().some(isHeld); }

  /** Held keys and gamepads, `seconds` after the last call. */
  step(seconds) {
    for (const key of this.held) this.moveBy(HELD[key], seconds);
    for (const pad of gamepads()) {
      const [side, out, yaw, pitch] = axesOf(pad);
      this.moveBy({ side: side * KEY_MOVE, out: -out * KEY_MOVE, yaw: -yaw * KEY_TURN, pitch: -pitch * KEY_TURN }, seconds);
    }
  }

  /** Angles of `rates` are radians, lengths arms' lengths. */
  moveBy(rates, factor) {
    const lengths = { out: this.viewpoint.unit, up: this.viewpoint.unit };
    this.viewpoint.move(Object.fromEntries(
      Object.entries(rates).map(([name, rate]) => [name, rate * factor * (lengths[name] ?? 1)])));
    this.listener.changed();
  }

  press(event) {
    this.listener.touched();
    this.surface.focus({ preventScroll: true, focusVisible: false });
    this.surface.setPointerCapture(event.pointerId);
    this.pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
  }

  release(event) { this.pointers.delete(event.pointerId); }

  drag(event) {
    const before = this.pointers.get(event.pointerId);
    if (!before) return;
    const now = { x: event.clientX, y: event.clientY };
    const by = { x: now.x - before.x, y: now.y - before.y };
    if (this.pointers.size === 1) {
      if (event.shiftKey || event.buttons & 2) this.moveEye(by);
      else this.turn(by);
    } else {
      this.pinch(event.pointerId, before, now, by);
    }
    this.pointers.set(event.pointerId, now);
  }

  /** What is in the middle of the picture stays under the hand. */
  turn(by) {
    const speed = this.viewpoint.slopeAcross / Math.max(1, this.surface.clientWidth);
    this.moveBy({ yaw: by.x * speed, pitch: by.y * speed }, 1);
  }

  /** What is near follows the hand, as when one pushes it aside. */
  moveEye(by) {
    this.moveBy({ side: -by.x * MOVE_PER_PX, up: by.y * MOVE_PER_PX }, 1);
  }

  /** Fingers that part enlarge; fingers that move together move the eye. */
  pinch(id, before, now, by) {
    const [other] = [...this.pointers].filter(([pointer]) => pointer !== id).map(([, place]) => place);
    const distance = (a) => Math.max(1, Math.hypot(a.x - other.x, a.y - other.y));
    this.viewpoint.zoomBy(distance(now) / distance(before));
    this.moveEye({ x: by.x / 2, y: by.y / 2 });
  }

  roll(event) {
    event.preventDefault();
    this.listener.touched();
    this.viewpoint.zoomBy(Math.exp(-event.deltaY * WHEEL));
    this.listener.changed();
  }

  keyDown(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (HELD[event.code]) this.held.add(event.code);
    else if (ZOOM_KEYS[event.code]) this.viewpoint.zoomBy(ZOOM_KEYS[event.code]);
    else if (event.code === 'Home') this.viewpoint.reset();
    else return;
    event.preventDefault();
    this.listener.touched();
    this.listener.changed();
  }
}

function gamepads() {
  return [...(navigator.getGamepads?.() ?? [])].filter((pad) => pad?.connected && pad.mapping === 'standard');
}

function isHeld(pad) { return axesOf(pad).some((value) => value !== 0); }

/** Left stick, right stick; what rests is 0. */
function axesOf(pad) {
  return [0, 1, 2, 3].map((i) => (Math.abs(pad.axes[i] ?? 0) > 0.15 ? pad.axes[i] : 0));
}
