const ADVICE = {
  'keep going': 'Keep turning', slower: 'Turn more slowly', faster: 'Turn a little faster', level: 'Keep the camera level',
  'too dark': 'Too dark', 'turn back': 'Turn back a little', done: 'Done: let go',
};
const PHASES = { idle: 'Ready', capturing: 'Taking a sweep', building: 'Making the panorama', done: 'Finished', failed: 'Failed' };
const FULL_TURN = 2 * Math.PI;
const MOST_FRAMES = 12; // shown, the last ones
const RETRY_MS = 5000;

/** The device's own display: what it tells, in the page's section. */
export class LiveDisplay {
  /** @param {HTMLElement} section @param {() => void} finished when there may be another panorama */
  constructor(section, finished) {
    this.section = section;
    this.finished = finished;
    this.part = (id) => section.querySelector(`#${id}`);
    this.phase = 'idle';
    this.frames = 0;
    this.connect();
  }

  connect() {
    const events = new EventSource('/events');
    events.onmessage = ({ data }) => this.hear(JSON.parse(data));
    events.onerror = () => {
      if (events.readyState === EventSource.CLOSED) setTimeout(() => this.connect(), RETRY_MS);
    };
  }

  /** @param {object} message see device/gallery/status_json.h */
  hear(message) {
    this.section.hidden = false;
    this[message.type]?.(message);
  }

  status({ phase, capture, text, frames_stored: stored, sweeps_left: left }) {
    if (phase !== this.phase) this.enter(phase);
    this.part('phase').textContent = `${PHASES[phase] ?? phase}${capture ? ` \u00b7 ${capture}` : ''}`;
    if (phase !== 'capturing') this.say(phase === 'done' ? 'The panorama is ready' : text); // its text is a path
    if (phase === 'idle') this.part('figures').textContent = `room for ${left} more sweeps`;
    if (phase === 'capturing' && capture) this.showFrames(capture, stored);
  }

  enter(phase) {
    if (phase === 'capturing') this.clearFrames();
    if (phase !== 'capturing' && phase !== 'building') this.clearFrames();
    this.phase = phase;
    this.showShare(phase === 'done' ? 1 : 0);
    this.part('figures').textContent = '';
    this.finished();
  }

  guidance({ advice, covered_rad: covered, frames_chosen: chosen }) {
    if (this.phase !== 'capturing') return;
    this.say(ADVICE[advice] ?? advice, advice !== 'keep going' && advice !== 'done');
    this.showShare(Math.abs(covered) / FULL_TURN);
    this.part('figures').textContent = `${Math.round((Math.abs(covered) * 180) / Math.PI)}\u00b0 \u00b7 ${chosen} photographs`;
  }

  progress({ stage, fraction }) {
    if (this.phase !== 'building') return;
    this.part('figures').textContent = `${stage}, ${Math.round(100 * fraction)} %`;
    this.showShare(fraction);
  }

  result({ ok, text, reasons }) {
    this.part('figures').textContent = [text, ...reasons.split('\n')].filter(Boolean).join(' \u00b7 ');
    if (ok) this.finished();
  }

  say(words, isWarning = false) {
    const advice = this.part('advice');
    if (advice.textContent !== words) advice.textContent = words;
    advice.classList.toggle('warn', isWarning);
  }

  showShare(share) {
    const percent = Math.round(100 * Math.min(1, share));
    this.part('bar').setAttribute('aria-valuenow', String(percent));
    this.part('bar').firstElementChild.style.width = `${percent}%`;
  }

  clearFrames() {
    this.frames = 0;
    this.part('frames').replaceChildren();
  }

  showFrames(capture, stored) {
    const row = this.part('frames');
    this.frames = Math.max(this.frames, stored - MOST_FRAMES);
    for (; this.frames < stored; this.frames++) {
      const name = `frame_${String(this.frames).padStart(3, '0')}.jpg`;
      row.append(Object.assign(document.createElement('img'), { src: `/sweeps/${capture}/${name}`, alt: `photograph ${this.frames + 1}` }));
    }
    while (row.children.length > MOST_FRAMES) row.firstElementChild.remove();
    row.scrollLeft = row.scrollWidth;
  }
}
