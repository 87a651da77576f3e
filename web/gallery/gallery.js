import { api } from './api.js';
import { cardOf } from './cards.js';
import { LiveDisplay } from './live.js';

const LOOK_AGAIN_MS = 30000;
const part = (id) => document.getElementById(id);
const page = { mayChange: false, removed: show, failed: ({ message }) => complain(message) };
let shown = '';

function complain(words) {
  part('trouble').textContent = words;
  part('trouble').hidden = words === '';
}

async function show() {
  try {
    const { live, changes, panoramas } = await api.list();
    complain('');
    part('key').hidden = !changes;
    part('key').textContent = api.token ? 'Lock' : 'Unlock';
    page.mayChange = changes && api.token !== '';
    part('hands').hidden = !live || !page.mayChange;
    const state = JSON.stringify([panoramas, page.mayChange]);
    if (state !== shown) part('list').replaceChildren(...panoramas.map((panorama) => cardOf(panorama, page)));
    shown = state;
    part('count').textContent = panoramas.length > 0 ? String(panoramas.length) : '';
    part('empty').hidden = panoramas.length > 0;
    return live;
  } catch (error) {
    complain(`The gallery cannot be reached: ${error.message}.`);
    return false;
  }
}

part('key').onclick = () => {
  api.token = api.token ? '' : prompt('The token that the gallery was started with:') ?? '';
  show();
};
for (const button of part('hands').children)
  button.onclick = () => api.tellDevice(button.dataset.word).catch((error) => complain(error.message));
setInterval(show, LOOK_AGAIN_MS);
if (await show()) globalThis.liveDisplay = new LiveDisplay(part('live'), show);
