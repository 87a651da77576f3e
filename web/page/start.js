// What the page holds, base64: the panorama, and the scripts of viewer and worker, compressed.
const ldpPage = {
  bytes(id) {
    const text = atob(document.getElementById(id).textContent);
    const bytes = new Uint8Array(text.length);
    for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
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
