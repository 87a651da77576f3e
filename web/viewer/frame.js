const STYLE = `
:host { display: block; position: relative; min-height: 12em; background: #26282b; color: #eee; font: 14px system-ui, sans-serif; overflow: hidden }
canvas { width: 100%; height: 100%; display: block; touch-action: none; cursor: grab; outline-offset: -3px }
canvas:active { cursor: grabbing }
.corner { position: absolute; right: .6em; bottom: .6em; display: flex; gap: .4em }
button { min-width: 2.6em; min-height: 2.6em; border: 0; border-radius: 1.3em; padding: 0 .8em; font: inherit; color: #fff; background: rgba(0, 0, 0, .5); cursor: pointer }
button[aria-pressed="true"] { background: #28c }
button:hover, button:focus-visible { background: rgba(0, 0, 0, .8) }
[hidden] { display: none !important }
.progress { position: absolute; left: 0; top: 0; height: 3px; width: 0; background: #6cf; transition: width .2s }
.message { position: absolute; inset: 0; display: grid; place-content: center; padding: 2em; text-align: center; text-shadow: 0 0 6px #000 }
.hint { position: absolute; left: 0; right: 0; bottom: 4em; padding: 0 1em; text-align: center; text-wrap: balance; pointer-events: none; text-shadow: 0 0 6px #000; transition: opacity 1s }
.panel { position: absolute; right: .6em; bottom: 4em; max-width: min(30em, calc(100% - 3em)); max-height: calc(100% - 7em); overflow: auto; padding: .8em 1em; border-radius: .6em; background: rgba(0, 0, 0, .75) }
.panel h2 { margin: 0 0 .4em; font-size: 1.1em }
.panel dl { margin: .4em 0 0; display: grid; grid-template-columns: auto 1fr; gap: .2em .8em }
.panel dt { opacity: .7 } .panel dd { margin: 0; overflow-wrap: anywhere }`;

const BODY = `
<canvas tabindex="0" role="application" part="canvas" aria-label="Panorama with depth. Arrow keys turn, W A S D Q E move, plus and minus zoom, Home returns, F full screen, I information, L light."></canvas>
<div class="hint" aria-hidden="true"></div>
<div class="progress" role="progressbar" aria-label="loading" aria-valuemin="0" aria-valuemax="100" hidden></div>
<div class="message" role="alert" hidden></div>
<div class="panel" role="dialog" aria-label="about this panorama" hidden></div>
<div class="corner">
<button class="headset" type="button" hidden>headset</button>
<button class="eyes" type="button" aria-label="pictures for both eyes, side by side" aria-pressed="false" hidden>two eyes</button>
<button class="tilt" type="button" aria-label="follow the turning of this device" aria-pressed="false" hidden>tilt</button>
<button class="even" type="button" aria-label="as if all photos had been taken at one exposure" aria-pressed="false" hidden>one exposure</button>
<button class="about" type="button" aria-label="about this panorama" aria-expanded="false">i</button>
<button class="full" type="button" aria-label="full screen"><svg width="16" height="16" viewBox="0 0 16 16" fill="none" stroke="currentColor" stroke-width="2" aria-hidden="true"><path d="M1 5V1h4M11 1h4v4M15 11v4h-4M5 15H1v-4"/></svg></button>
</div>`;

const HINTS = {
  fingers: 'drag to look around \u00b7 pinch to zoom \u00b7 two fingers to move',
  mouse: 'drag to look around \u00b7 wheel to zoom \u00b7 shift-drag to move',
};
const GRADE_WORDS = { good: 'Good', fair: 'Fair', sweep_again: 'Sweep again' };

/** The viewer's own page: canvas, buttons, progress, messages. */
export class Frame {
  /** @param {ShadowRoot} root */
  constructor(root) {
    root.innerHTML = `<style>${STYLE}</style>${BODY}`;
    const part = (name) => root.querySelector(name);
    this.canvas = part('canvas');
    this.hint = part('.hint');
    this.hint.textContent = HINTS[matchMedia('(pointer: coarse)').matches ? 'fingers' : 'mouse'];
    this.bar = part('.progress');
    this.message = part('.message');
    this.panel = part('.panel');
    this.aboutButton = part('.about');
    this.fullButton = part('.full');
    this.tiltButton = part('.tilt');
    this.eyesButton = part('.eyes');
    this.evenButton = part('.even');
    this.headsetButton = part('.headset');
    this.aboutButton.onclick = () => this.togglePanel();
  }

  togglePanel() {
    this.panel.hidden = !this.panel.hidden;
    this.aboutButton.setAttribute('aria-expanded', String(!this.panel.hidden));
  }

  /** @param {number|null} share 0 .. 1; null: nothing is under way */
  showProgress(share) {
    this.bar.hidden = share === null;
    this.bar.style.width = `${Math.round(100 * (share ?? 1))}%`;
    this.bar.setAttribute('aria-valuenow', String(Math.round(100 * (share ?? 1))));
  }

  /** @param {string} text empty: none */
  showMessage(text) {
    this.message.hidden = text === '';
    this.message.textContent = text;
  }

  hideHint() { this.hint.style.opacity = 0; }

  /** The panel: verdict and what is known of the capture. @param {object} opened see preparation.js */
  describe({ head, layers, verdict, metadata }, bytes) {
    const turn = Math.round(((head.width * head.thetaPitch) / Math.PI) * 180);
    const facts = [['Taken', metadata.captured_utc], ['With', metadata.device],
                   ['Size', `${head.width} x ${head.height}, ${turn}\u00b0, ${layers.length} layers`],
                   ['File', `${(bytes / 1e6).toFixed(2)} MB`], ['Made by', metadata.software]];
    const title = document.createElement('h2');
    title.textContent = verdict ? `${GRADE_WORDS[verdict.verdict]}: new views of about ${Math.round(verdict.expectedViewPsnrDb)} dB`
      : 'Layered depth panorama';
    const list = document.createElement('dl');
    for (const [name, value] of facts) if (value) list.append(textIn('dt', name), textIn('dd', value));
    this.panel.replaceChildren(title, ...(verdict?.reasons ?? []).map(({ text }) => textIn('p', text)), list);
  }
}

function textIn(tag, text) {
  const element = document.createElement(tag);
  element.textContent = text;
  return element;
}
