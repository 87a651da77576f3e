import { ByteReader } from './byte_reader.js';
import { crc32c } from './crc32c.js';
import { LdpError, refuse } from './errors.js';

const MAGIC = [0xab, 0x4c, 0x44, 0x50, 0x0d, 0x0a, 0x1a, 0x0a];
const HEADER_BYTES = 32;
const ENTRY_BYTES = 32;
const MOST_CHUNKS = 1 << 20;
const NEWEST_VERSION = 2;
const NO_INDEX = 65535;

/**
 * @typedef {object} Chunk
 * @property {string} type four letters
 * @property {number|null} layer null: belongs to the whole file
 * @property {number|null} strip null: belongs to the whole layer or file
 * @property {number} offset bytes from the file's beginning
 * @property {number} length bytes
 * @property {number} crc CRC-32C of its bytes
 */

/** @param {Chunk} chunk @returns {string} how messages name it; layers and strips are counted from 1 there */
export function nameOfChunk(chunk) {
  const layer = chunk.layer === null ? '' : ` of layer ${chunk.layer + 1}`;
  const strip = chunk.strip === null ? '' : `, strip ${chunk.strip + 1}`;
  return `chunk ${chunk.type}${layer}${strip}`;
}

/**
 * The table of chunks (FORMAT.md, section 1), its header and table checked, the chunks themselves not yet.
 * @param {Uint8Array} file
 * @returns {{version: number, chunks: Chunk[]}}
 */
export function readContainer(file) {
  if (file.length < HEADER_BYTES || MAGIC.some((byte, i) => file[i] !== byte))
    throw new LdpError('header: not an .ldp file, or changed on its way');
  const header = new ByteReader(file.subarray(0, HEADER_BYTES), 'header');
  header.skip(MAGIC.length);
  const version = header.u32();
  const count = header.u32();
  const length = header.u64('length of the file');
  const tableCrc = header.u32();
  if (header.u32() !== crc32c(file.subarray(0, HEADER_BYTES - 4))) refuse('header', 'checksum', 'the right one', 'another');
  if (version < 1 || version > NEWEST_VERSION) refuse('header', 'version', `1 to ${NEWEST_VERSION}`, version);
  if (length !== file.length) refuse('header', 'length of the file', `${length} bytes`, file.length);
  const most = Math.min(MOST_CHUNKS, Math.floor((length - HEADER_BYTES) / ENTRY_BYTES));
  if (count < 1 || count > most) refuse('header', 'number of chunks', `1 to ${most}`, count);
  const table = file.subarray(HEADER_BYTES, HEADER_BYTES + ENTRY_BYTES * count);
  if (crc32c(table) !== tableCrc) refuse('table of chunks', 'checksum', 'the right one', 'another');
  return { version, chunks: readTable(table, count, length) };
}

function readTable(bytes, count, fileLength) {
  const table = new ByteReader(bytes, 'table of chunks');
  const chunks = [];
  let end = HEADER_BYTES + bytes.length;
  for (let i = 0; i < count; i++) {
    const chunk = readEntry(table);
    if (chunk.offset !== end) refuse(nameOfChunk(chunk), 'its offset', end, chunk.offset);
    if (chunk.length > fileLength - end)
      refuse(nameOfChunk(chunk), 'its end', `within ${fileLength} bytes`, `a length of ${chunk.length}`);
    end += chunk.length;
    chunks.push(chunk);
  }
  if (end !== fileLength) refuse('table of chunks', 'end of the last chunk', fileLength, end);
  return chunks;
}

function readEntry(table) {
  const type = String.fromCharCode(...table.take(4));
  if (!/^[A-Za-z]{4}$/.test(type)) refuse(table.place, 'chunk type', 'four letters', 'other bytes');
  const [layer, strip] = [table.u16(), table.u16()].map((index) => (index === NO_INDEX ? null : index));
  const chunk = { type, layer, strip, offset: table.u64('offset'), length: table.u64('length'), crc: table.u32() };
  if (table.u32() !== 0) refuse(nameOfChunk(chunk), 'reserved field of the table', 0, 'another');
  return chunk;
}

/**
 * @param {Uint8Array} file
 * @param {Chunk} chunk
 * @returns {Uint8Array} the chunk's bytes, not copied, after their checksum was found right
 */
export function bytesOfChunk(file, chunk) {
  const bytes = file.subarray(chunk.offset, chunk.offset + chunk.length);
  if (crc32c(bytes) !== chunk.crc) refuse(nameOfChunk(chunk), 'checksum', 'the right one', 'another');
  return bytes;
}
