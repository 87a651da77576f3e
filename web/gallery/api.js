const KEY = 'ldp-token';

/** What the gallery's server knows and does; see device/gallery/gallery.h. */
export const api = {
  /** @returns {Promise<{live: boolean, changes: boolean, panoramas: object[]}>} */
  async list() {
    const response = await fetch('/panoramas.json');
    if (!response.ok) throw new Error(`the gallery answered ${response.status}`);
    return response.json();
  },

  get token() { return sessionStorage.getItem(KEY) ?? ''; },
  set token(text) {
    if (text) sessionStorage.setItem(KEY, text);
    else sessionStorage.removeItem(KEY);
  },

  tellDevice(word) { return change('POST', `/device/${word}`); },
  remove(name) { return change('DELETE', `/panoramas/${encodeURIComponent(name)}`); },
};

async function change(method, address) {
  const response = await fetch(address, { method, headers: { Authorization: `Bearer ${api.token}` } });
  if (response.status === 401) api.token = '';
  if (!response.ok) throw new Error((await response.text()).trim());
}
