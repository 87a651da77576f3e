import { TORN_VERTEX_BYTES } from '../surfaces/torn_vertex.js';
import { EXPOSURE_FRAGMENT, makeExposureTexture, responseOf } from './exposure.js';
import { makeProgram, makeTexture } from './gl.js';

const DIRECTIONS_ACROSS = 2048; // texels of a row of the texture of columns' directions
const QUAD_CORNERS = [0, 2, 1, 1, 2, 3]; // split from upper right to lower left
const NEAR_SHARE = 0.02; // of the arc's radius: nothing nearer to the eye is drawn

/**
 * A pinhole camera in the arc's axes (x = u(0), y = u(90 degrees), z = up, origin at the arc's centre).
 * @typedef {object} ViewCamera
 * @property {number} width pixels
 * @property {number} height
 * @property {number} fx pixels
 * @property {number} fy
 * @property {number} cx pixel centres are at .5
 * @property {number} cy
 * @property {number[]} eye 3 numbers, the capture's unit
 * @property {number[]} axes 9 numbers row by row: the camera's right, down and forward axes
 */

// The point of ray (theta, v) at inverse depth w, up to the factor w, which keeps points at infinity finite. Inverse
// z-depth is linear in depth buffers so written, as it is on the screen.
const PROJECTION = `
uniform sampler2D directions;   // of column x: cos and sin of theta
uniform vec4 grid;              // v of row 0, pitch of v, radius of the rays' origins, scale of inverse z-depth
uniform vec3 eye;
uniform mat3 axes;              // right, down, forward from the arc's axes
uniform vec4 lens;              // fx, fy, cx, cy in halves of the picture
uniform vec2 size;              // of the panorama
out vec2 inPanorama;            // shares of its size
invariant gl_Position;
vec4 project(ivec2 place, float w) {
  vec2 u = texelFetch(directions, ivec2(place.x % ${DIRECTIONS_ACROSS}, place.x / ${DIRECTIONS_ACROSS}), 0).xy;
  float v = grid.x - (float(place.y) + 0.5) * grid.y;
  inPanorama = (vec2(place) + 0.5) / size;
  vec3 p = axes * (vec3(u, v) + w * (vec3(grid.z * u, 0.0) - eye));
  return vec4(lens.x * p.x + lens.z * p.z, lens.y * p.y + lens.w * p.z, 0.999999 * p.z - grid.w * w, p.z);
}`;

const CELL_VERTEX = `${PROJECTION}
uniform ivec2 origin;           // the strip's first column, the layer's first row
uniform vec4 picture;           // place of the texture's corner from there, 1 / its size
layout(location = 0) in uvec2 place;
layout(location = 1) in float w;
out vec2 at;
void main() {
  gl_Position = project(ivec2(place) + origin, w);
  at = (vec2(place) - picture.xy + 0.5) * picture.zw;
}`;

const CELL_FRAGMENT = `${EXPOSURE_FRAGMENT}
uniform sampler2D colours;
in vec2 at;
in vec2 inPanorama;
out vec4 colour;
void main() { colour = vec4(shownColour(texture(colours, at).rgb, inPanorama), 1.0); }`;

const TORN_VERTEX = `${PROJECTION}
uniform ivec2 origin;
layout(location = 0) in ivec2 place;
layout(location = 1) in float w;
layout(location = 2) in vec4 colour;
out vec4 own;
void main() {
  gl_Position = project(place + origin, w);
  own = colour;
}`;

// Colours are multiplied by opacity only here, after they were interpolated.
const TORN_FRAGMENT = `${EXPOSURE_FRAGMENT}
in vec4 own;
in vec2 inPanorama;
out vec4 colour;
void main() { colour = vec4(shownColour(own.rgb, inPanorama) * own.a, own.a); }`;

/**
 * Draws the strips of a mesh into whatever is bound, the picture's first row first: colours multiplied by opacity, depth
 * from inverse z-depth.
 */
export class SurfaceRenderer {
  /**
   * @param {WebGL2RenderingContext} gl
   * @param {import('../reader/records.js').Head} head
   * @param {import('../reader/records.js').Exposure|null} exposure
   */
  constructor(gl, head, exposure) {
    Object.assign(this, { gl, head });
    this.exposure = makeExposureTexture(gl, exposure, head.wraps);
    this.light = responseOf(exposure);
    /** 0: colours as stored; 1: at even exposure; between them a part of the way */
    this.even = 0;
    this.cells = makeProgram(gl, CELL_VERTEX, CELL_FRAGMENT);
    this.torn = makeProgram(gl, TORN_VERTEX, TORN_FRAGMENT);
    this.rayRadius = head.rays === 'pushbroom' ? head.radius : 0;
    this.near = NEAR_SHARE * (head.radius > 0 ? head.radius : 1 / Math.max(head.wNear, 1e-6));
    this.directions = this.makeDirections();
    this.corners = { quads: 0, buffer: gl.createBuffer() };
    /** by their number */
    this.strips = new Map();
  }

  makeDirections() {
    const { gl, head } = this;
    const rows = Math.ceil((head.width + 1) / DIRECTIONS_ACROSS);
    const data = new Float32Array(2 * DIRECTIONS_ACROSS * rows);
    for (let x = 0; x <= head.width; x++) {
      const theta = this.theta(head.wraps && x === head.width ? 0 : x);
      data.set([Math.cos(theta), Math.sin(theta)], 2 * x);
    }
    return makeTexture(gl, { internal: gl.RG32F, format: gl.RG, type: gl.FLOAT, width: DIRECTIONS_ACROSS, height: rows,
                             filter: gl.NEAREST, data });
  }

  theta(x) { return this.head.thetaLeft - (x + 0.5) * this.head.thetaPitch; }

  /**
   * Of a strip that comes again cells are added and torn quads take the earlier ones' place.
   * @param {number} number
   * @param {import('../surfaces/mesh.js').MeshStrip} strip
   */
  addStrip(number, strip) {
    const { x0, x1, wMin, wMax, top, bottom } = strip;
    const earlier = this.strips.get(number);
    if (earlier) [earlier.opaque, earlier.soft].forEach((quads) => this.freePart(quads));
    this.strips.set(number, { x0, x1, wMin, wMax, top, bottom,
                              cells: [...(earlier?.cells ?? []), ...strip.cells.map((c) => this.uploadCells(c))],
                              opaque: this.uploadTorn(strip.opaque), soft: this.uploadTorn(strip.soft) });
  }

  uploadCells({ vertices, triangles, top, texture }) {
    const { gl } = this;
    const array = gl.createVertexArray();
    const buffers = [gl.createBuffer(), gl.createBuffer()];
    gl.bindVertexArray(array);
    gl.bindBuffer(gl.ARRAY_BUFFER, buffers[0]);
    gl.bufferData(gl.ARRAY_BUFFER, vertices, gl.STATIC_DRAW);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribIPointer(0, 2, gl.UNSIGNED_SHORT, 8, 0);
    gl.enableVertexAttribArray(1);
    gl.vertexAttribPointer(1, 1, gl.FLOAT, false, 8, 4);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, buffers[1]);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, triangles, gl.STATIC_DRAW);
    gl.bindVertexArray(null);
    const { x, y, width, height, scale = 1, data } = texture;
    const colours = makeTexture(gl, { internal: gl.RGBA8, format: gl.RGBA, type: gl.UNSIGNED_BYTE, width, height,
                                      filter: gl.LINEAR, data });
    return { array, buffers, colours, count: triangles.length, top, picture: [x, y, 1 / (scale * width), 1 / (scale * height)] };
  }

  uploadTorn(vertices) {
    if (vertices.byteLength === 0) return null;
    const { gl } = this;
    const quads = vertices.byteLength / TORN_VERTEX_BYTES / 4;
    this.makeCorners(quads);
    const array = gl.createVertexArray();
    const buffer = gl.createBuffer();
    gl.bindVertexArray(array);
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, vertices, gl.STATIC_DRAW);
    gl.vertexAttribIPointer(0, 2, gl.SHORT, TORN_VERTEX_BYTES, 0);
    gl.vertexAttribPointer(1, 1, gl.FLOAT, false, TORN_VERTEX_BYTES, 4);
    gl.vertexAttribPointer(2, 4, gl.UNSIGNED_BYTE, true, TORN_VERTEX_BYTES, 8);
    for (let k = 0; k < 3; k++) gl.enableVertexAttribArray(k);
    gl.bindVertexArray(null);
    return { array, buffers: [buffer], count: 6 * quads };
  }

  /** Indices of quads' corners, the same for all torn quads: at least so many quads. */
  makeCorners(quads) {
    if (this.corners.quads >= quads) return;
    const { gl } = this;
    const indices = new Uint32Array(6 * quads);
    for (let i = 0, at = 0; i < quads; i++) for (const corner of QUAD_CORNERS) indices[at++] = 4 * i + corner;
    gl.bindVertexArray(null);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.corners.buffer);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, indices, gl.STATIC_DRAW);
    this.corners.quads = quads;
  }

  freeStrip(number) {
    const strip = this.strips.get(number);
    if (!strip) return;
    for (const part of [...strip.cells, strip.opaque, strip.soft]) this.freePart(part);
    this.strips.delete(number);
  }

  /** @param part null: nothing */
  freePart(part) {
    if (!part) return;
    this.gl.deleteVertexArray(part.array);
    part.buffers.forEach((buffer) => this.gl.deleteBuffer(buffer));
    if (part.colours) this.gl.deleteTexture(part.colours);
  }

  /** @param {ViewCamera} camera */
  draw(camera) {
    const { gl } = this;
    const seen = [...this.strips.values()].filter((strip) => this.sees(camera, strip));
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LESS);
    gl.depthMask(true);
    gl.disable(gl.BLEND);
    gl.activeTexture(gl.TEXTURE0);
    this.use(this.cells, camera);
    for (const strip of seen) for (const part of strip.cells) this.drawCells(strip, part);
    this.use(this.torn, camera);
    for (const strip of seen) this.drawTorn(strip, strip.opaque);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.depthMask(false);
    for (const strip of seen) this.drawTorn(strip, strip.soft);
    gl.depthMask(true);
    gl.disable(gl.BLEND);
    gl.disable(gl.DEPTH_TEST);
    gl.bindVertexArray(null);
  }

  use({ program, uniforms }, camera) {
    const { gl, head } = this;
    gl.useProgram(program);
    for (const [unit, name] of [[1, 'directions'], [2, 'exposure']]) {
      gl.uniform1i(uniforms[name], unit);
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(gl.TEXTURE_2D, this[name]);
    }
    gl.activeTexture(gl.TEXTURE0);
    gl.uniform1f(uniforms.even, this.even);
    gl.uniform1fv(uniforms['light[0]'], this.light);
    gl.uniform2f(uniforms.size, head.width, head.height);
    gl.uniform4f(uniforms.grid, head.vTop, head.vPitch, this.rayRadius, 2 * this.near);
    gl.uniform3f(uniforms.eye, ...camera.eye);
    gl.uniformMatrix3fv(uniforms.axes, true, camera.axes);
    const { width, height, fx, fy, cx, cy } = camera;
    gl.uniform4f(uniforms.lens, (2 * fx) / width, (2 * fy) / height, (2 * cx) / width - 1, (2 * cy) / height - 1);
  }

  drawCells(strip, { array, colours, count, top, picture }) {
    const { gl, cells: { uniforms } } = this;
    gl.bindTexture(gl.TEXTURE_2D, colours);
    gl.uniform2i(uniforms.origin, strip.x0, top);
    gl.uniform4f(uniforms.picture, ...picture);
    gl.bindVertexArray(array);
    gl.drawElements(gl.TRIANGLES, count, gl.UNSIGNED_INT, 0);
  }

  drawTorn(strip, quads) {
    if (!quads) return;
    const { gl } = this;
    gl.uniform2i(this.torn.uniforms.origin, strip.x0, 0);
    gl.bindVertexArray(quads.array);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.corners.buffer);
    gl.drawElements(gl.TRIANGLES, quads.count, gl.UNSIGNED_INT, 0);
  }

  /** Whether the camera may see a strip: not all of it lies outside one side of the picture. */
  sees(camera, strip) {
    const points = this.pointsOf(strip, camera);
    const { width, height, fx, fy, cx, cy } = camera;
    const room = 8; // pixels, for what a strip bulges between the points asked
    const sides = [([x, , z]) => fx * x + (cx + room) * z, ([x, , z]) => (width + room - cx) * z - fx * x,
                   ([, y, z]) => fy * y + (cy + room) * z, ([, y, z]) => (height + room - cy) * z - fy * y];
    return sides.every((side) => points.some((point) => side(point) > 0));
  }

  pointsOf({ x0, x1, wMin, wMax, top, bottom }, { eye, axes }) {
    const points = [];
    const steps = 8;
    for (let step = 0; step <= steps; step++) {
      const theta = this.theta(x0 + ((x1 - x0) * step) / steps);
      const [c, s] = [Math.cos(theta), Math.sin(theta)];
      for (const row of [top, bottom])
        for (const w of [wMin, wMax]) {
          const v = this.head.vTop - (row + 0.5) * this.head.vPitch;
          const p = [c + w * (this.rayRadius * c - eye[0]), s + w * (this.rayRadius * s - eye[1]), v - w * eye[2]];
          points.push([0, 3, 6].map((k) => axes[k] * p[0] + axes[k + 1] * p[1] + axes[k + 2] * p[2]));
        }
    }
    return points;
  }
}
