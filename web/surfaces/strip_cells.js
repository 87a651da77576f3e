import { ABSENT, joinedInViews } from './prepared_layer.js';

const LARGEST_CELL = 16; // quads a side: over more the cylinder's curvature would show
const FLATNESS_PX = 0.4; // parallax over one arc radius by which a cell may leave its pixels

/**
 * Flat parts of one layer's surfaces: indexed triangles over pixel centres, without cracks. Each vertex has 8 bytes: x
 * from the strip's x0 (u16), row from the layer's top (u16), inverse depth w (f32).
 * @typedef {object} Cells
 * @property {ArrayBuffer} vertices
 * @property {Uint32Array} triangles three indices each
 * @property {number} top the panorama's row of row 0
 * @property {{x: number, y: number, width: number, height: number, scale?: number, data: Uint8Array}} texture RGBA of the
 *   pixels x, y and so on (x from the strip's x0, y from the layer's top); a pixel's colour belongs at its centre; scale:
 *   of how many pixels each is, along either axis
 * @property {{wMin: number, wMax: number, top: number, bottom: number}} bounds
 */

/** The quads of one layer in columns x0 .. x1, and the cells of the solid ones. */
export class StripCells {
  constructor(layer, depths, head, x0, x1) {
    Object.assign(this, { layer, depths, x0 });
    this.columns = x1 - x0;
    this.rows = layer.rows - 1;
    this.tolerance = (FLATNESS_PX * head.vPitch) / (head.radius > 0 ? head.radius : 1);
    /** 1 where the quad is solid and opaque, columns x rows */
    this.solid = new Uint8Array(this.columns * this.rows);
    this.findSolid();
    /** of the merged cells, null if there are none */
    this.bounds = null;
  }

  /** Index into the layer's planes of the quad's upper left pixel. */
  pixel(x, y) { return y * this.layer.columns + this.x0 + x; }

  findSolid() {
    const { w, colour, columns } = this.layer;
    for (let y = 0, quad = 0; y < this.rows; y++)
      for (let x = 0, i = this.pixel(0, y); x < this.columns; x++, i++, quad++) {
        if (w[i] < 0 || w[i + 1] < 0 || w[i + columns] < 0 || w[i + columns + 1] < 0) continue;
        if ((colour[i] & colour[i + 1] & colour[i + columns] & colour[i + columns + 1]) >>> 24 !== 255) continue;
        if (this.isOneSurface(i, i + 1, i + columns, i + columns + 1)) this.solid[quad] = 1;
      }
  }

  /** a b above c d: joined along enough of six ways that nobody is left apart. */
  isOneSurface(a, b, c, d) {
    const sides = this.joins(a, b) + this.joins(a, c) + this.joins(b, d) + this.joins(c, d);
    if (sides >= 3) return true;
    const diagonals = this.joins(a, d) + this.joins(b, c);
    if (sides + diagonals < 3) return false;
    if (sides + diagonals === 4) return true;
    // Three ways leave a corner alone only if they are a triangle.
    const ofCorner = (k, l, m, n) => this.joins(k, l) + this.joins(k, m) + this.joins(k, n);
    return ofCorner(a, b, c, d) > 0 && ofCorner(b, a, c, d) > 0 && ofCorner(c, a, b, d) > 0 && ofCorner(d, a, b, c) > 0;
  }

  joins(i, j) { return joinedInViews(this.layer, this.depths, i, j) ? 1 : 0; }

  /** @param {CellScratch} scratch @returns {Cells|null} null if no quad is solid */
  merge(scratch) {
    const corners = this.cornersOfCells();
    if (corners.length === 0) return null;
    const cells = new CellMesh(this, corners, scratch).take();
    this.bounds = cells.bounds;
    return cells;
  }

  /** x, y, size of every cell, one after the other. */
  cornersOfCells() {
    const cells = [];
    const solidOf = this.solidCells();
    const split = (x, y, size, level) => {
      if (x >= this.columns || y >= this.rows) return;
      const { across, solid } = solidOf[level];
      if (solid[(y >> level) * across + (x >> level)] && this.isFlat(x, y, size)) {
        cells.push(x, y, size);
      } else if (size > 1) {
        const half = size / 2;
        split(x, y, half, level - 1);
        split(x + half, y, half, level - 1);
        split(x, y + half, half, level - 1);
        split(x + half, y + half, half, level - 1);
      }
    };
    for (let y = 0; y < this.rows; y += LARGEST_CELL)
      for (let x = 0; x < this.columns; x += LARGEST_CELL) split(x, y, LARGEST_CELL, solidOf.length - 1);
    return cells;
  }

  /** Of cells of 1, 2, 4 .. LARGEST_CELL quads a side whether all of their quads are there and solid. */
  solidCells() {
    const levels = [{ across: this.columns, down: this.rows, solid: this.solid }];
    for (let size = 2; size <= LARGEST_CELL; size *= 2) {
      const fine = levels[levels.length - 1];
      const [across, down] = [Math.ceil(fine.across / 2), Math.ceil(fine.down / 2)];
      const solid = new Uint8Array(across * down);
      for (let y = 0; y < fine.down >> 1; y++)
        for (let x = 0; x < fine.across >> 1; x++) {
          const i = 2 * y * fine.across + 2 * x;
          solid[y * across + x] = fine.solid[i] & fine.solid[i + 1] & fine.solid[i + fine.across] & fine.solid[i + fine.across + 1];
        }
      levels.push({ across, down, solid });
    }
    return levels;
  }

  /** Whether the pixels of a cell of solid quads lie near the bilinear surface of its corners. */
  isFlat(x0, y0, size) {
    if (size === 1) return true;
    const { w, columns } = this.layer;
    const i = this.pixel(x0, y0);
    const [a, b, c, d] = [w[i], w[i + size], w[i + size * columns], w[i + size * columns + size]];
    for (let y = 0; y <= size; y++) {
      const left = a + ((c - a) * y) / size;
      const slope = (b + ((d - b) * y) / size - left) / size;
      for (let x = 0, at = i + y * columns; x <= size; x++)
        if (Math.abs(left + slope * x - w[at + x]) > this.tolerance) return false;
    }
    return true;
  }
}

/** Memory of one mesh of cells after another. */
export class CellScratch {
  constructor() {
    /** of each pixel: 1 where it is a vertex of something */
    this.used = new Uint8Array(0);
    /** of each pixel: which vertex it is, -1: none */
    this.indexOf = new Int32Array(0);
    /** of each vertex: which pixel it is */
    this.places = new Uint32Array(0);
    this.triangles = new Uint32Array(0);
  }

  /** @param {number} pixels @param {number} indices of triangles */
  clear(pixels, indices) {
    if (this.used.length < pixels) {
      this.used = new Uint8Array(pixels);
      this.indexOf = new Int32Array(pixels);
      this.places = new Uint32Array(pixels);
    }
    this.used.fill(0);
    this.indexOf.fill(-1);
    if (this.triangles.length < indices) this.triangles = new Uint32Array(indices);
  }
}

/** Triangles of cells of different size: where a cell's side has vertices of smaller neighbours it takes them in. */
class CellMesh {
  constructor(quads, cells, scratch) {
    Object.assign(this, { quads, cells });
    this.across = quads.columns + 1;
    scratch.clear(this.across * (quads.rows + 1), roomFor(cells));
    Object.assign(this, scratch);
    this.placeCount = 0;
    this.triangleCount = 0; // three numbers each
    this.markUsed();
    for (let k = 0; k < cells.length; k += 3) this.addCell(cells[k], cells[k + 1], cells[k + 2]);
  }

  /** Corners of cells, and of torn quads beside them; every vertex on the strip's borders, where the next one begins. */
  markUsed() {
    const { columns, rows, solid } = this.quads;
    const mark = (x, y, size) => {
      for (const at of [this.at(x, y), this.at(x + size, y), this.at(x, y + size), this.at(x + size, y + size)])
        this.used[at] = 1;
    };
    for (let k = 0; k < this.cells.length; k += 3) mark(this.cells[k], this.cells[k + 1], this.cells[k + 2]);
    for (let y = 0, quad = 0; y < rows; y++)
      for (let x = 0; x < columns; x++, quad++)
        if (!solid[quad] && this.isTouched(this.quads.pixel(x, y))) mark(x, y, 1);
    for (let y = 0; y <= rows; y++) this.used[this.at(0, y)] = this.used[this.at(columns, y)] = 1;
  }

  /** Whether any corner of the quad whose upper left pixel is i is present. */
  isTouched(i) {
    const { w, columns } = this.quads.layer;
    return w[i] !== ABSENT || w[i + 1] !== ABSENT || w[i + columns] !== ABSENT || w[i + columns + 1] !== ABSENT;
  }

  at(x, y) { return y * this.across + x; }

  addCell(x, y, size) {
    const border = size === 1 ? null : this.borderOf(x, y, size);
    if (border === null || border.length === 4) {
      const a = this.vertex(this.at(x, y));
      const b = this.vertex(this.at(x + size, y));
      const c = this.vertex(this.at(x, y + size));
      const d = this.vertex(this.at(x + size, y + size));
      this.addTriangle(a, c, b);
      this.addTriangle(b, c, d);
      return;
    }
    const centre = this.vertex(this.at(x + size / 2, y + size / 2));
    for (let k = 0; k < border.length; k++)
      this.addTriangle(centre, this.vertex(border[k]), this.vertex(border[(k + 1) % border.length]));
  }

  addTriangle(a, b, c) {
    const { triangles } = this;
    triangles[this.triangleCount++] = a;
    triangles[this.triangleCount++] = b;
    triangles[this.triangleCount++] = c;
  }

  /** Vertices along a cell's border, anticlockwise on the grid as seen (y down) from its upper left corner. */
  borderOf(x, y, size) {
    const border = [];
    const add = (at, always) => {
      if (always || this.used[at]) border.push(at);
    };
    for (let k = 0; k < size; k++) add(this.at(x, y + k), k === 0);
    for (let k = 0; k < size; k++) add(this.at(x + k, y + size), k === 0);
    for (let k = size; k > 0; k--) add(this.at(x + size, y + k), k === size);
    for (let k = size; k > 0; k--) add(this.at(x + k, y), k === size);
    return border;
  }

  vertex(at) {
    if (this.indexOf[at] < 0) {
      this.indexOf[at] = this.placeCount;
      this.places[this.placeCount++] = at;
    }
    return this.indexOf[at];
  }

  /** @returns {Cells} */
  take() {
    const { layer, x0 } = this.quads;
    const vertices = new ArrayBuffer(8 * this.placeCount);
    const [places, ws] = [new Uint16Array(vertices), new Float32Array(vertices)];
    const box = { left: Infinity, right: 0, first: Infinity, last: 0, wMin: Infinity, wMax: 0 };
    for (let k = 0; k < this.placeCount; k++) {
      const x = this.places[k] % this.across;
      const y = (this.places[k] - x) / this.across;
      places[4 * k] = x;
      places[4 * k + 1] = y;
      ws[2 * k + 1] = layer.w[y * layer.columns + x0 + x];
      include(box, x, y, ws[2 * k + 1]);
    }
    return { vertices, triangles: this.triangles.slice(0, this.triangleCount), top: layer.top, texture: this.texture(box),
             bounds: { wMin: box.wMin, wMax: box.wMax, top: layer.top + box.first, bottom: layer.top + box.last } };
  }

  texture({ left, right, first, last }) {
    const { layer, x0 } = this.quads;
    const [width, height] = [right - left + 1, last - first + 1];
    const data = new Uint32Array(width * height);
    for (let y = 0; y < height; y++) {
      const from = (first + y) * layer.columns + x0 + left;
      data.set(layer.colour.subarray(from, from + width), y * width);
    }
    return { x: left, y: first, width, height, data: new Uint8Array(data.buffer) };
  }
}

/** Numbers of the triangles that cells may become at most. */
function roomFor(cells) {
  let room = 0;
  for (let k = 2; k < cells.length; k += 3) room += cells[k] === 1 ? 6 : 12 * cells[k];
  return room;
}

function include(box, x, y, w) {
  if (x < box.left) box.left = x;
  if (x > box.right) box.right = x;
  if (y < box.first) box.first = y;
  if (y > box.last) box.last = y;
  if (w < box.wMin) box.wMin = w;
  if (w > box.wMax) box.wMax = w;
}
