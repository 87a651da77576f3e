// A decoder of images for node: Pillow, which uses the same libraries as the C++ reader. One python3 serves all calls.
import { spawn } from 'node:child_process';

const SERVER = `
import io, struct, sys
from PIL import Image
while True:
    head = sys.stdin.buffer.read(4)
    if len(head) < 4: break
    data = sys.stdin.buffer.read(struct.unpack('<I', head)[0])
    try:
        image = Image.open(io.BytesIO(data)).convert('RGBA')
        answer = struct.pack('<II', *image.size) + image.tobytes()
    except Exception:
        answer = struct.pack('<II', 0, 0)
    sys.stdout.buffer.write(answer)
    sys.stdout.buffer.flush()
`;

/** @returns {{decodeImage: import('../../web/reader/colour.js').ImageDecoder, close: () => void}} */
export function startPillow(python) {
  const server = spawn(python, ['-c', SERVER], { stdio: ['pipe', 'pipe', 'inherit'] });
  let received = Buffer.alloc(0);
  let wake = () => {};
  server.stdout.on('data', (more) => {
    received = Buffer.concat([received, more]);
    wake();
  });
  const take = async (count) => {
    while (received.length < count) await new Promise((done) => { wake = done; });
    const bytes = received.subarray(0, count);
    received = received.subarray(count);
    return bytes;
  };
  const decodeImage = async (bytes) => {
    const head = Buffer.alloc(4);
    head.writeUInt32LE(bytes.length);
    server.stdin.write(head);
    server.stdin.write(bytes);
    const size = await take(8);
    const [width, height] = [size.readUInt32LE(0), size.readUInt32LE(4)];
    if (width === 0) throw new Error('not an image');
    return { width, height, data: new Uint8Array(await take(4 * width * height)) };
  };
  return { decodeImage, close: () => server.stdin.end() };
}
