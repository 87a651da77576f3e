// web/reader against the C++ reader: plane for plane on the golden files, and on damaged ones.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import path from 'node:path';
import test from 'node:test';
import { crc32c } from '../../web/reader/crc32c.js';
import { ImageError, LdpError } from '../../web/reader/errors.js';
import { evenedColour } from '../../web/reader/exposure.js';
import { LdpReader } from '../../web/reader/ldp_reader.js';
import { verdictOf } from '../../web/reader/verdict.js';
import { damagedCopies, seal } from './damage.mjs';
import { startPillow } from './pillow.mjs';

const GOLDEN = process.env.LDP_GOLDEN;
const MOST_MS = 2000; // for any file of this size, damaged or not
const pillow = startPillow(process.env.LDP_PYTHON);
test.after(() => pillow.close());

const goldenNames = readdirSync(GOLDEN).filter((name) => name.endsWith('.ldp')).sort();
const goldenFiles = goldenNames.map((name) => new Uint8Array(readFileSync(path.join(GOLDEN, name))));

const hex = (bytes) => crc32c(bytes).toString(16).padStart(8, '0');

async function planesOf(file, decodeImage = pillow.decodeImage) {
  const reader = new LdpReader(file);
  const lines = [];
  for (let i = 0; i < reader.layers.length; i++) {
    const layer = await reader.readLayer(i, { decodeImage });
    const disparity = new Uint8Array(layer.disparity.buffer);
    const planes = { disparity, coverage: layer.coverage, alpha: layer.alpha, colour: layer.colour };
    if (reader.exposure) planes.even = evenedColour(layer, reader.head, reader.exposure);
    for (const [name, bytes] of Object.entries(planes))
      lines.push(`layer ${i + 1} ${name} ${hex(bytes)}\n`);
  }
  return lines.join('');
}

/** What the C++ reader says of files, in their order: {refused} or {planes}. */
function judgedByCpp(files) {
  const folder = mkdtempSync(path.join(tmpdir(), 'ldp_damaged_'));
  try {
    const paths = files.map((file, i) => path.join(folder, `${i}.ldp`));
    paths.forEach((name, i) => writeFileSync(name, files[i]));
    const text = execFileSync(process.env.LDP_PLANES, paths, { encoding: 'utf8', maxBuffer: 1 << 26 });
    return text.split(/^file .*\n/m).slice(1).map((said) => (said.startsWith('refused') ? { refused: said } : { planes: said }));
  } finally {
    rmSync(folder, { recursive: true });
  }
}

test('the checksum is CRC-32C', () => {
  assert.equal(crc32c(new TextEncoder().encode('123456789')), 0xe3069283);
});

goldenNames.forEach((name, i) => {
  test(`planes of ${name} are those of the C++ reader`, async () => {
    assert.equal(await planesOf(goldenFiles[i]), readFileSync(path.join(GOLDEN, name.replace('.ldp', '.txt')), 'utf8'));
  });
});

test('the example of FORMAT.md has the geometry and the records written there', () => {
  const reader = new LdpReader(goldenFiles[goldenNames.indexOf('tiny.ldp')]);
  const { head } = reader;
  assert.deepEqual([head.width, head.height, head.layerCount, head.rays, head.wraps], [5, 3, 2, 'pushbroom', false]);
  assert.deepEqual(head.centre, [0.5, -0.25, 1.625]);
  assert.deepEqual([head.radius, head.thetaLeft, head.thetaPitch, head.vTop], [0.65, 1.75, 1 / 64, 0.6875]);
  assert.deepEqual([head.wFar, head.wNear, head.limits], [0, 1.25, { inner: 0.25, outer: 1, height: 0.125 }]);
  assert.equal(reader.cameras.length, 3);
  assert.equal(reader.cameras[0].name, 'frame_000.jpg');
  assert.deepEqual(reader.cameras[0].distortion.slice(0, 2), [-0.125, 0.0625]);
  assert.equal(reader.quality.get('coverage_percent'), 97.5);
  assert.equal(reader.metadata.get('captured_utc'), '2026-01-02T03:04:05Z');
  assert.equal(reader.thumbnail.length, 316);
});

test('the images told of are those that colours are decoded from', async () => {
  for (const file of goldenFiles) {
    const reader = new LdpReader(file);
    for (let layer = 0; layer < reader.layers.length; layer++) {
      const asked = [];
      await reader.readLayer(layer, { decodeImage: (bytes, type) => {
        asked.push({ bytes, type });
        return pillow.decodeImage(bytes);
      } });
      assert.deepEqual(reader.imagesOf(layer), asked);
    }
  }
});

test('an image larger than its strip is not told of', () => {
  const file = goldenFiles[goldenNames.indexOf('tiny.ldp')].slice();
  assert.equal(new LdpReader(file).imagesOf(0).length, 1);
  file.set([0xff, 0x3f], 1669);
  assert.equal(new LdpReader(seal(file)).imagesOf(0).length, 0);
});

test('400 damaged files are refused in words, or read as the C++ reader reads them', async () => {
  const files = damagedCopies(goldenFiles, 400, 31);
  const expected = judgedByCpp(files);
  assert.equal(expected.length, files.length);
  const tally = { refused: 0, read: 0 };
  for (let i = 0; i < files.length; i++) {
    const began = performance.now();
    let planes = null;
    try {
      planes = await planesOf(files[i]);
    } catch (error) {
      assert.ok(error instanceof LdpError, `file ${i}: ${error.stack}`);
      assert.match(error.message, /^(chunk \w{4}|header|table of chunks).*: .+/);
      // Of a damaged picture two decoders may judge differently; of everything else two readers may not.
      if (!(error instanceof ImageError)) assert.ok(expected[i].refused, `file ${i} is read in C++: ${error.message}`);
    }
    assert.ok(performance.now() - began < MOST_MS, `file ${i} takes ${performance.now() - began} ms`);
    if (planes !== null) assertSameDepths(planes, expected[i], i);
    tally[planes === null ? 'refused' : 'read']++;
  }
  assert.ok(tally.refused > 100 && tally.read > 10, JSON.stringify(tally));
});

function assertSameDepths(planes, expected, i) {
  if (expected.refused) assert.match(expected.refused, /image/, `file ${i}: ${expected.refused}`);
  else assert.equal(withoutColour(planes), withoutColour(expected.planes), `file ${i}`);
}

const withoutColour = (planes) => planes.replace(/^layer \d+ (colour|even) .*\n/gm, '');

test('more pixels than the caller allows are refused before anything is allocated', () => {
  const file = goldenFiles[goldenNames.indexOf('tiny.ldp')].slice();
  assert.throws(() => new LdpReader(file, { mostPixels: 14 }), /width x height: expected at most 14, found 15/);
  new DataView(file.buffer).setUint32(384, 65535, true);
  new DataView(file.buffer).setUint32(388, 16368, true);
  assert.throws(() => new LdpReader(seal(file)), /width x height: expected at most 268435456/);
});

test('an unknown chunk is skipped when its first letter is small, refused when it is not', () => {
  const file = goldenFiles[goldenNames.indexOf('tiny.ldp')].slice();
  const entryOf = (type) => [...Array(11).keys()].map((i) => 32 + 32 * i)
    .find((at) => new TextDecoder().decode(file.subarray(at, at + 4)) === type);
  const at = entryOf('meta');
  file[at] = 'n'.charCodeAt(0);
  assert.equal(new LdpReader(seal(file)).metadata.size, 0);
  file[at] = 'N'.charCodeAt(0);
  assert.throws(() => new LdpReader(seal(file)), /chunk Neta: needed to read the file, but unknown/);
});

test('the verdict is read from the figures; one that makes no sense is none', () => {
  const figures = new Map([['verdict', 2], ['expected_view_psnr_db', 17.5], ['reason.00.code', 2],
                           ['reason.00.from_deg', 10], ['reason.00.to_deg', 45]]);
  const verdict = verdictOf(figures);
  assert.equal(verdict.verdict, 'sweep_again');
  assert.deepEqual(verdict.reasons.map((r) => [r.code, r.fromDeg, r.toDeg]), [['little_overlap', 10, 45]]);
  assert.equal(verdictOf(new Map([['verdict', 3]])), null);
  assert.equal(verdictOf(new Map()), null);
});

test('the words of the verdict are those of the programs', () => {
  const words = readFileSync(path.join(GOLDEN, '../../core/verdict/words.cpp'), 'utf8');
  const entries = [...words.matchAll(/^ {4}\{"(\w+)", "([^"]+)", "([^"]+)"\},$/gm)];
  assert.equal(entries.length, 13);
  entries.forEach(([, code, wrong, advice], i) => {
    const [reason] = verdictOf(new Map([['verdict', 1], ['reason.00.code', i], ['reason.00.from_deg', 7],
                                        ['reason.00.to_deg', 7]])).reasons;
    assert.equal(reason.code, code);
    assert.equal(reason.text, `${wrong.replace('%s', ' near 7 degrees')}: ${advice}`);
  });
});

test('a place across the join of a full turn goes on from 0', () => {
  const place = (from, to) => verdictOf(new Map([['verdict', 1], ['reason.00.code', 0], ['reason.00.from_deg', from],
                                                 ['reason.00.to_deg', to]])).reasons[0].text.split(' are blurred')[0];
  assert.equal(place(343, 377), 'the photos between 343 and 17 degrees');
  assert.equal(place(400, 450), 'the photos between 40 and 90 degrees');
  assert.equal(place(0, 360), 'the photos between 0 and 360 degrees');
});

// Offsets are those of the example in FORMAT.md, section 8.
const FORGERIES = [
  [12, [0], /number of chunks: expected 1 to \d+, found 0/],
  [72, [77], /chunk LAYR of layer 1: its offset: expected 588, found 589/],
  [60, [1], /chunk HEAD: reserved field of the table: expected 0/],
  [392, [0], /number of layers: expected 1 to 8, found 0/],
  [393, [2], /kind of rays: expected 0 to 1, found 2/],
  [394, [1], /theta_pitch x width of a panorama that wraps: expected a full turn/],
  [418, [0xf0, 0x7f], /arc centre: expected a finite number/],
  [427, [0x40], /arc axes: expected a rotation/],
  [499, [0xbf], /arc radius: expected at least 0/],
  [515, [0xbf], /theta_end: expected at least/],
  [592, [17], /strip width: expected a multiple of 16/],
  [596, [16], /number of present pixels: expected at most 15, found 16/],
  [604, [9, 5], /range: expected low <= high, found 9 and 5/],
  [606, [1], /chunk ALPH of layer 1, strip 1: expected one, found none/],
  [1503, [0x7a], /chunk qual: order of keys: expected ascending/],
  [1642, [3], /codec: expected 0 to 2, found 3/],
  [1642, [0], /codec: expected 1 or more/],
  [1642, [1], /its image: expected image\/jpeg, found image\/webp/],
  [1669, [32], /size of its image: expected 16 x 16, found 32 x 16/],
];

FORGERIES.forEach(([offset, bytes, words]) => {
  test(`byte ${offset} forged is refused: ${words.source}`, async () => {
    const file = goldenFiles[goldenNames.indexOf('tiny.ldp')].slice();
    file.set(bytes, offset);
    assert.ok(judgedByCpp([seal(file)])[0].refused, 'and so does the C++ reader');
    await assert.rejects(planesOf(file), (error) => error instanceof LdpError && words.test(error.message));
  });
});
