import { ByteReader } from './byte_reader.js';
import { refuse } from './errors.js';

const ROTATION_TOLERANCE = 1e-6;
const MOST_ENTRIES = 4096;
const MOST_EXPOSURE_NODES = 256; // along a side
const RESPONSE_KNOTS = 17;

/**
 * HEAD: the panorama's geometry (FORMAT.md, section 2).
 * @typedef {object} Head
 * @property {number} width pixels
 * @property {number} height pixels
 * @property {number} layerCount
 * @property {'pushbroom'|'central'} rays
 * @property {boolean} wraps column `width` is column 0 again
 * @property {boolean} closed the sweep closed
 * @property {number[]} centre of the arc, 3 numbers in the capture's unit
 * @property {number[]} axes 9 numbers row by row; columns u(0), u(90 degrees), n
 * @property {number} radius of the arc, the capture's unit
 * @property {number} thetaBegin radians: where the hand's path begins
 * @property {number} thetaEnd radians
 * @property {number} thetaLeft radians, of the left border
 * @property {number} thetaPitch radians a column
 * @property {number} vTop
 * @property {number} vPitch a row
 * @property {number} wFar inverse depth at disparity 0, 1 / unit
 * @property {number} wNear inverse depth at disparity 3825
 * @property {{inner: number, outer: number, height: number}} limits of the viewing space, the capture's unit
 */

/**
 * @param {Uint8Array} bytes
 * @param {number} mostPixels that the caller is ready to hold a layer of
 * @returns {Head}
 */
export function readHead(bytes, mostPixels) {
  const input = new ByteReader(bytes, 'chunk HEAD');
  const width = input.whole('width', 1, 65535);
  const height = input.whole('height', 1, 16368);
  if (width * height > mostPixels) refuse(input.place, 'width x height', `at most ${mostPixels}`, width * height);
  const layerCount = input.choice('number of layers', 8);
  if (layerCount < 1) refuse(input.place, 'number of layers', '1 to 8', 0);
  const rays = input.choice('kind of rays', 1) === 0 ? 'pushbroom' : 'central';
  const flags = input.choice('flags', 3);
  input.choice('reserved byte', 0);
  const head = { width, height, layerCount, rays, wraps: (flags & 1) !== 0, closed: (flags & 2) !== 0,
                 ...readArc(input), ...readSampling(input), limits: readLimits(input) };
  input.expectEnd();
  const turn = head.thetaPitch * width;
  if (head.wraps && Math.abs(turn - 2 * Math.PI) > 1e-6)
    refuse(input.place, 'theta_pitch x width of a panorama that wraps', 'a full turn', turn);
  return head;
}

function readArc(input) {
  const centre = input.numbers('arc centre', 3);
  const axes = readRotation(input, 'arc axes');
  const radius = input.atLeast('arc radius', 0);
  const thetaBegin = input.finite('theta_begin');
  return { centre, axes, radius, thetaBegin, thetaEnd: input.atLeast('theta_end', thetaBegin) };
}

function readSampling(input) {
  const thetaLeft = input.finite('theta_left');
  const thetaPitch = input.positive('theta_pitch');
  const vTop = input.finite('v_top');
  const vPitch = input.positive('v_pitch');
  const wFar = input.atLeast('w_far', 0);
  return { thetaLeft, thetaPitch, vTop, vPitch, wFar, wNear: input.atLeast('w_near', wFar) };
}

function readLimits(input) {
  const inner = input.atLeast('inner viewing radius', 0);
  const outer = input.atLeast('outer viewing radius', 0);
  return { inner, outer, height: input.atLeast('viewing height', 0) };
}

/** A right-handed rotation matrix, row by row. */
function readRotation(input, field) {
  const m = input.numbers(field, 9);
  const column = (k) => [m[k], m[3 + k], m[6 + k]];
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const [x, y, z] = [column(0), column(1), column(2)];
  const cross = [x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]];
  const skew = Math.max(...[x, y, z].map((a) => Math.abs(dot(a, a) - 1)), Math.abs(dot(x, y)), Math.abs(dot(x, z)),
                        Math.abs(dot(y, z)));
  if (!(skew <= ROTATION_TOLERANCE) || dot(cross, z) < 0) refuse(input.place, field, 'a rotation', 'another matrix');
  return m;
}

/**
 * LAYR (FORMAT.md, section 3).
 * @typedef {object} LayerRecord
 * @property {number} blockPx 0: one range for the whole layer
 * @property {number} stripPx columns of a strip
 * @property {number} present number of present pixels
 * @property {number} low of the layer's range; of no meaning with blocks
 * @property {number} high
 * @property {boolean} hasAlpha
 */

/**
 * @param {Uint8Array} bytes
 * @param {string} place
 * @param {Head} head
 * @returns {LayerRecord}
 */
export function readLayerRecord(bytes, place, head) {
  const input = new ByteReader(bytes, place);
  const blockPx = input.whole('block size', 0, 256);
  const stripPx = input.whole('strip width', 16, 8192);
  if (stripPx % 16 !== 0 || (blockPx > 0 && stripPx % blockPx !== 0))
    refuse(place, 'strip width', 'a multiple of 16 and of the block size', stripPx);
  const present = input.u64('number of present pixels');
  if (present > head.width * head.height)
    refuse(place, 'number of present pixels', `at most ${head.width * head.height}`, present);
  const [low, high] = [input.u8(), input.u8()];
  if (low > high || (blockPx > 0 && high > 0))
    refuse(place, 'range', blockPx > 0 ? '0 and 0 with block ranges' : 'low <= high', `${low} and ${high}`);
  const hasAlpha = input.choice('opacity', 1) === 1;
  input.choice('reserved byte', 0);
  input.expectEnd();
  return { blockPx, stripPx, present, low, high, hasAlpha };
}

/**
 * Local exposure (`expo`): by what light colours at even exposure were multiplied, by direction.
 * @typedef {object} Exposure
 * @property {number[]} light at levels 0, 16 .. 256: the camera's response
 * @property {number} columns of nodes
 * @property {number} rows
 * @property {Uint16Array} factors of red, green and blue light of each node in 1/4096, row by row
 */

/** @returns {Exposure} */
export function readExposure(bytes) {
  const input = new ByteReader(bytes, 'chunk expo');
  const light = [0];
  for (let knot = 1; knot < RESPONSE_KNOTS; knot++) {
    light.push(input.u32());
    if (light[knot] <= light[knot - 1]) refuse(input.place, 'the response', 'rising light', light[knot]);
  }
  const columns = input.whole('columns of the exposure', 1, MOST_EXPOSURE_NODES);
  const rows = input.whole('rows of the exposure', 1, MOST_EXPOSURE_NODES);
  const factors = Uint16Array.from({ length: 3 * columns * rows }, () => input.u16());
  input.expectEnd();
  if (factors.includes(0)) refuse(input.place, 'a factor of the exposure', '1 to 65535', 0);
  return { light, columns, rows, factors };
}

/**
 * One source camera (`cams`).
 * @typedef {object} SourceCamera
 * @property {string} name of the photo
 * @property {number} width pixels
 * @property {number} height pixels
 * @property {number} fx pixels
 * @property {number} fy
 * @property {number} cx pixel centres are at .5
 * @property {number} cy
 * @property {number[]} distortion k1 k2 p1 p2, in OpenCV's order
 * @property {number[]} rotation world from camera, row by row; columns right, down, forward
 * @property {number[]} centre in the capture's unit
 */

/** @param {Uint8Array} bytes @returns {SourceCamera[]} */
export function readCameras(bytes) {
  const input = new ByteReader(bytes, 'chunk cams');
  const cameras = [];
  for (let left = input.whole('number of cameras', 0, MOST_ENTRIES); left > 0; left--) {
    const name = decodeText(input.textBytes());
    const width = input.whole('width of a camera\'s image', 1, 65536);
    const height = input.whole('height of a camera\'s image', 1, 65536);
    const [fx, fy] = [input.positive('fx'), input.positive('fy')];
    const [cx, cy] = input.numbers('principal point', 2);
    cameras.push({ name, width, height, fx, fy, cx, cy, distortion: input.numbers('distortion', 4),
                   rotation: readRotation(input, 'rotation of a camera'),
                   centre: input.numbers('centre of a camera', 3) });
  }
  input.expectEnd();
  return cameras;
}

/** `qual`. @param {Uint8Array} bytes @returns {Map<string, number>} figures by name */
export function readQuality(bytes) {
  return readMap(new ByteReader(bytes, 'chunk qual'), (input) => input.f64());
}

/** `meta`. @param {Uint8Array} bytes @returns {Map<string, string>} */
export function readMetadata(bytes) {
  return readMap(new ByteReader(bytes, 'chunk meta'), (input) => decodeText(input.textBytes()));
}

function readMap(input, readValue) {
  const map = new Map();
  let last = null;
  for (let left = input.whole('number of entries', 0, MOST_ENTRIES); left > 0; left--) {
    const key = input.textBytes();
    if (last && !isBefore(last, key)) refuse(input.place, 'order of keys', 'ascending', `'${decodeText(key)}'`);
    last = key;
    map.set(decodeText(key), readValue(input));
  }
  input.expectEnd();
  return map;
}

/** Byte by byte. */
function isBefore(a, b) {
  const shared = Math.min(a.length, b.length);
  for (let i = 0; i < shared; i++) if (a[i] !== b[i]) return a[i] < b[i];
  return a.length < b.length;
}

function decodeText(bytes) {
  return new TextDecoder().decode(bytes);
}
