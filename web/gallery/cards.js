import { api } from './api.js';

const VERDICTS = { good: 'Good', fair: 'Fair', sweep_again: 'Sweep again' };

/** A panorama's place in the list. @param {object} panorama @param {{mayChange: boolean, removed: () => void, failed: (error: Error) => void}} page */
export function cardOf(panorama, page) {
  const card = element('li', { className: 'card' });
  const shown = element(panorama.trouble ? 'div' : 'a');
  if (!panorama.trouble) shown.href = `/view/${encodeURIComponent(panorama.name)}`;
  shown.append(pictureOf(panorama), element('h2', { textContent: titleOf(panorama) }), ...linesOf(panorama));
  card.append(shown, filesOf(panorama, page));
  return card;
}

function pictureOf({ name, thumbnail, changed_ms: changed }) {
  if (!thumbnail) return element('div', { className: 'blank' });
  return element('img', { src: `/thumbnails/${encodeURIComponent(name)}?${changed}`, alt: '', loading: 'lazy' });
}

function titleOf({ name }) { return name.replace(/\.ldp$/, ''); }

function linesOf(panorama) {
  const line = (textContent, className = '') => element('p', { textContent, className });
  if (panorama.trouble) return [line(`This file is damaged: ${panorama.trouble}`, 'trouble')];
  const taken = new Date(panorama.captured_utc ?? panorama.changed_ms);
  const when = taken.toLocaleString(undefined, { dateStyle: 'medium', timeStyle: 'short' });
  const lines = [line(`${when} \u00b7 ${panorama.degrees}\u00b0 \u00b7 ${megabytes(panorama.bytes)}`)];
  if (panorama.verdict) {
    const verdict = line(VERDICTS[panorama.verdict] ?? panorama.verdict, `verdict ${panorama.verdict}`);
    verdict.title = panorama.verdict_text;
    lines.push(verdict);
    const why = panorama.verdict_text.split(': ').slice(1).join(': ');
    if (panorama.verdict !== 'good' && why) lines.push(line(why));
  }
  return lines;
}

function filesOf(panorama, page) {
  const files = element('div', { className: 'files' });
  const stem = titleOf(panorama);
  const endings = panorama.trouble ? ['ldp'] : ['ldp', 'jpg', 'glb'];
  for (const ending of endings) {
    const link = element('a', { href: `/panoramas/${encodeURIComponent(`${stem}.${ending}`)}`, textContent: `.${ending}` });
    link.download = `${stem}.${ending}`;
    link.setAttribute('aria-label', `download ${stem}.${ending}`);
    files.append(link);
  }
  if (page.mayChange) files.append(removeButton(panorama, page));
  return files;
}

function removeButton({ name }, page) {
  const button = element('button', { type: 'button', textContent: 'Delete' });
  button.onclick = () => {
    if (confirm(`Delete ${name} and the photographs of its sweep? This cannot be undone.`))
      api.remove(name).then(page.removed, page.failed);
  };
  return button;
}

function megabytes(bytes) { return `${(bytes / 1e6).toFixed(bytes < 1e6 ? 2 : 1)} MB`; }

function element(tag, properties = {}) { return Object.assign(document.createElement(tag), properties); }
