// What the page holds, as core/base/markup_text.h writes it: the panorama, and the scripts of viewer and worker, compressed.
const ldpPage = {
  bytes(id) {
    const text = document.getElementById(id).textContent;
    const digit = (i) => {
      const code = i < text.length ? text.charCodeAt(i) : 117;
      return code === 118 ? 27 : code - 33;
    };
    const bytes = new Uint8Array(Math.floor((text.length * 4) / 5));
    for (let i = 0, at = 0; i < text.length; i += 5) {
      let group = 0;
      for (let k = 0; k < 5; k++) group = group * 85 + digit(i + k);
      for (let shift = 24; shift >= 0 && at < bytes.length; shift -= 8) bytes[at++] = group >>> shift;
    }
    return bytes;
  },

  async start() {
    const packed = new Blob([this.bytes('scripts')]).stream();
    const text = await new Response(packed.pipeThrough(new DecompressionStream('gzip'))).text();
    const [viewer, worker] = text.split('\n@next@\n');
    this.worker = worker;
    const script = document.createElement('script');
    script.type = 'module';
    script.textContent = viewer;
    document.body.append(script);
  },
};
ldpPage.start().catch((error) => {
  document.querySelector('layered-panorama').textContent = `This browser cannot show the panorama: ${error.message}.`;
});
