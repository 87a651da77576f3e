const CELL_COLUMNS = 32; // over which the cylinder may be flat in a picture that stays for a second
const DARK = 40; // of 255: what no photo shows is black in the small picture
const BLURRED_ROWS = 2; // into which that is blurred
const DEPTH_SHARE = 0.25; // of the range of inverse depth, where most things are nearer or farther than

/**
 * The file's small picture as a strip over the whole panorama, all of it at one depth: to be seen until there is more.
 * @param {import('../reader/records.js').Head} head
 * @param {{width: number, height: number, data: Uint8Array|Uint8ClampedArray}} image RGBA
 * @returns {import('./mesh.js').MeshStrip}
 */
export function stripOfThumbnail(head, image) {
  coverEnds(image);
  const last = head.width - 1;
  const columns = Math.max(1, Math.ceil(last / CELL_COLUMNS));
  const w = head.wFar + DEPTH_SHARE * (head.wNear - head.wFar);
  const vertices = new ArrayBuffer(8 * 2 * (columns + 1));
  const [places, ws] = [new Uint16Array(vertices), new Float32Array(vertices)];
  for (let i = 0; i <= 2 * columns + 1; i++) {
    places.set([Math.min(last, CELL_COLUMNS * (i >> 1)), i & 1 ? head.height - 1 : 0], 4 * i);
    ws[2 * i + 1] = w;
  }
  const triangles = new Uint32Array(6 * columns);
  for (let i = 0; i < columns; i++) triangles.set([0, 1, 2, 2, 1, 3].map((corner) => 2 * i + corner), 6 * i);
  const bounds = { wMin: w, wMax: w, top: 0, bottom: head.height - 1 };
  const texture = { x: 0, y: 0, width: image.width, height: image.height, scale: head.width / image.width,
                    data: new Uint8Array(image.data.buffer) };
  return { x0: 0, x1: last, cells: [{ vertices, triangles, top: 0, texture, bounds }], opaque: new ArrayBuffer(0),
           soft: new ArrayBuffer(0), ...bounds };
}

/** Continues every column up and down over what is black at its ends. */
function coverEnds({ width, height, data }) {
  const pixels = new Uint32Array(data.buffer, data.byteOffset, width * height);
  const isDark = (i) => data[4 * i] < DARK && data[4 * i + 1] < DARK && data[4 * i + 2] < DARK;
  for (let x = 0; x < width; x++)
    for (const [end, step] of [[x, width], [x + (height - 1) * width, -width]]) {
      let rows = 0;
      while (rows < height && isDark(end + step * rows)) rows++;
      if (rows === 0 || rows + BLURRED_ROWS >= height) continue;
      rows += BLURRED_ROWS;
      for (let row = 0; row < rows; row++) pixels[end + step * row] = pixels[end + step * rows];
    }
}
