import { decodeImageInBrowser } from '../reader/browser_images.js';
import { LdpReader } from '../reader/ldp_reader.js';
import { verdictOf } from '../reader/verdict.js';
import { MeshBuilder } from '../surfaces/mesh.js';
import { TORN_VERTEX_BYTES } from '../surfaces/torn_vertex.js';

const HORIZON = 1000; // what is at infinity is so many arms' lengths away
const QUAD_CORNERS = [0, 2, 1, 1, 2, 3]; // split from upper right to lower left

const CELL_VERTEX = `
varying vec2 at;
void main() {
  at = uv;
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
}`;
const CELL_FRAGMENT = `
uniform sampler2D colours;
varying vec2 at;
void main() { gl_FragColor = vec4(texture2D(colours, at).rgb, 1.0); }`;

const TORN_VERTEX = `
attribute vec4 own;
varying vec4 shown;
void main() {
  shown = own;
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
}`;
const TORN_FRAGMENT = `
varying vec4 shown;
void main() { gl_FragColor = vec4(shown.rgb * shown.a, shown.a); }`;

/**
 * Panoramas as objects of a three.js scene: the mesh of the viewer, which tears where depth jumps, in the colours of the
 * file. Axes as in .glb files: y is up, x points to angle 0 of the arc, the arc's centre is the origin.
 *
 *   const panorama = await new LdpLoader(THREE).load('room.ldp');
 *   scene.add(panorama);
 */
export class LdpLoader {
  /** @param {object} THREE the library, from r111 on */
  constructor(THREE) { this.THREE = THREE; }

  /** @param {string} url @returns {Promise<object>} a THREE.Group */
  async load(url) {
    const response = await fetch(url);
    if (!response.ok) throw new Error(`${url} cannot be loaded: the server answered ${response.status}`);
    return this.parse(await response.arrayBuffer());
  }

  /**
   * @param {ArrayBuffer} file
   * @returns {Promise<object>} a THREE.Group; userData has head, verdict, metadata and groupFromWorld, a THREE.Matrix4
   *   from the world of the source cameras
   */
  async parse(file) {
    const reader = new LdpReader(file);
    const builder = new MeshBuilder(reader.head, reader.cameras);
    for (let layer = 0; layer < reader.layers.length; layer++)
      builder.addLayer(await reader.readLayer(layer, { decodeImage: decodeImageInBrowser }), reader.layers[layer].blockPx > 0);
    builder.addMadeUp();
    const group = new this.THREE.Group();
    for (let number = 0; number < builder.stripCount; number++)
      for (const mesh of this.meshesOf(reader.head, builder.buildStrip(number))) group.add(mesh);
    group.userData = { head: reader.head, verdict: verdictOf(reader.quality), metadata: Object.fromEntries(reader.metadata),
                       groupFromWorld: this.groupFromWorld(reader.head) };
    return group;
  }

  /** @param {import('../surfaces/mesh.js').MeshStrip} strip */
  meshesOf(head, { x0, cells, opaque, soft }) {
    const meshes = cells.map((part) => this.cellMesh(head, x0, part));
    if (opaque.byteLength > 0) meshes.push(this.tornMesh(head, x0, opaque, false));
    if (soft.byteLength > 0) meshes.push(this.tornMesh(head, x0, soft, true));
    return meshes;
  }

  cellMesh(head, x0, { vertices, triangles, top, texture }) {
    const { THREE } = this;
    const [places, ws] = [new Uint16Array(vertices), new Float32Array(vertices)];
    const count = ws.length / 2;
    const { x, y, width, height, data } = texture;
    const [positions, uvs] = [new Float32Array(3 * count), new Float32Array(2 * count)];
    for (let i = 0; i < count; i++) {
      const [column, row] = [places[4 * i], places[4 * i + 1]];
      placeOf(head, x0 + column, top + row, ws[2 * i + 1], positions, 3 * i);
      uvs[2 * i] = (column - x + 0.5) / width;
      uvs[2 * i + 1] = (row - y + 0.5) / height;
    }
    const geometry = this.geometry(positions, triangles);
    geometry.setAttribute('uv', new THREE.BufferAttribute(uvs, 2));
    const colours = new THREE.DataTexture(data, width, height, THREE.RGBAFormat);
    Object.assign(colours, { magFilter: THREE.LinearFilter, minFilter: THREE.LinearFilter, generateMipmaps: false, needsUpdate: true });
    return new THREE.Mesh(geometry, this.material(CELL_VERTEX, CELL_FRAGMENT, { uniforms: { colours: { value: colours } } }));
  }

  tornMesh(head, x0, vertices, isSoft) {
    const { THREE } = this;
    const [places, ws, bytes] = [new Int16Array(vertices), new Float32Array(vertices), new Uint8Array(vertices)];
    const count = vertices.byteLength / TORN_VERTEX_BYTES;
    const [positions, own] = [new Float32Array(3 * count), new Uint8Array(4 * count)];
    for (let i = 0; i < count; i++) {
      placeOf(head, x0 + places[6 * i], places[6 * i + 1], ws[3 * i + 1], positions, 3 * i);
      own.set(bytes.subarray(TORN_VERTEX_BYTES * i + 8, TORN_VERTEX_BYTES * (i + 1)), 4 * i);
    }
    const triangles = new Uint32Array(1.5 * count);
    for (let quad = 0, at = 0; quad < count; quad += 4) for (const corner of QUAD_CORNERS) triangles[at++] = quad + corner;
    const geometry = this.geometry(positions, triangles);
    geometry.setAttribute('own', new THREE.BufferAttribute(own, 4, true));
    const blended = isSoft ? { transparent: true, premultipliedAlpha: true, depthWrite: false } : {};
    return new THREE.Mesh(geometry, this.material(TORN_VERTEX, TORN_FRAGMENT, blended));
  }

  geometry(positions, triangles) {
    const { THREE } = this;
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(positions, 3));
    geometry.setIndex(new THREE.BufferAttribute(triangles, 1));
    return geometry;
  }

  material(vertexShader, fragmentShader, options) {
    return new this.THREE.ShaderMaterial({ vertexShader, fragmentShader, side: this.THREE.DoubleSide, ...options });
  }

  groupFromWorld({ axes, centre }) {
    const { THREE } = this;
    const column = (k) => [axes[k], axes[3 + k], axes[6 + k]];
    const [x, z, y] = [column(0), column(1).map((value) => -value), column(2)];
    const turn = new THREE.Matrix4();
    turn.set(...x, 0, ...y, 0, ...z, 0, 0, 0, 0, 1);
    return turn.multiply(new THREE.Matrix4().makeTranslation(-centre[0], -centre[1], -centre[2]));
  }
}

/** The point of a pixel at inverse depth w: three numbers of `positions` from `at` on. */
function placeOf(head, column, row, w, positions, at) {
  const unit = head.radius > 0 ? head.radius : 1;
  const depth = 1 / Math.max(w, 1 / (HORIZON * unit));
  const theta = head.thetaLeft - (column + 0.5) * head.thetaPitch;
  const horizontal = (head.rays === 'pushbroom' ? head.radius : 0) + depth;
  positions[at] = horizontal * Math.cos(theta);
  positions[at + 1] = depth * (head.vTop - (row + 0.5) * head.vPitch);
  positions[at + 2] = -horizontal * Math.sin(theta);
}
