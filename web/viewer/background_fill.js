import { makeProgram, Target } from './gl.js';

const RIM_PX = 2; // rim pixels are this near to a hole
const FADE = [0.15, 0.6]; // radians beyond the panorama's border where it begins to darken, and ends
// Outlines, as in core/view/outlines.h: inverse depths side by side bend by more than this share of themselves plus so
// many pixels of parallax over the arc's radius; a pixel with at most so many neighbours on its surface is a speck.
const OUTLINE_SHARE = 0.06, OUTLINE_PARALLAX_PX = 0.75, SPECK_NEIGHBOURS = 1;
const FARTHER = 1e-4; // inverse z-depth, 1 / unit, by which background may be nearer than what surrounds a hole

const SCREEN_VERTEX = `
void main() {
  vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1);
  gl_Position = vec4(4.0 * corner - 1.0, 0.0, 1.0);
}`;

// Rounding of soft edges that cover each other leaves some pixels just under 255.
const COMMON = `
const float SOLID = 249.5 / 255.0;
const float NONE = -1.0;
ivec2 clamped(ivec2 at, ivec2 size) { return clamp(at, ivec2(0), size - 1); }`;

const BEGIN_FRAGMENT = `${COMMON}
uniform sampler2D colours; uniform sampler2D depths;
out vec4 nearest;               // inverse z-depth of the first solid pixel to the left, right, above, below
void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  bool solid = texelFetch(colours, at, 0).a >= SOLID;
  nearest = vec4(solid ? 1.0 - texelFetch(depths, at, 0).r : NONE);
}`;

const SPREAD_FRAGMENT = `${COMMON}
uniform sampler2D before; uniform int apart;
out vec4 nearest;
float from(ivec2 at, int channel) {
  ivec2 size = textureSize(before, 0);
  return at == clamped(at, size) ? texelFetch(before, at, 0)[channel] : NONE;
}
void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  nearest = texelFetch(before, at, 0);
  if (nearest.r < 0.0) nearest.r = from(at - ivec2(apart, 0), 0);
  if (nearest.g < 0.0) nearest.g = from(at + ivec2(apart, 0), 1);
  if (nearest.b < 0.0) nearest.b = from(at - ivec2(0, apart), 2);
  if (nearest.a < 0.0) nearest.a = from(at + ivec2(0, apart), 3);
}`;

// Of a hole the largest inverse z-depth that may still be its background; of a hole with nothing around it any may.
const FARTHEST_FRAGMENT = `${COMMON}
uniform sampler2D colours; uniform sampler2D nearest; uniform float slack;
out vec4 farthest;
void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  farthest = vec4(NONE);
  if (texelFetch(colours, at, 0).a >= SOLID) return;
  vec4 n = texelFetch(nearest, at, 0);
  float least = 2.0;
  for (int k = 0; k < 4; k++) if (n[k] >= 0.0) least = min(least, n[k]);
  farthest = vec4(1.1 * least + slack);
}`;

const WIDEN_FRAGMENT = `${COMMON}
uniform sampler2D farthest;
out vec4 widest;
void main() {
  ivec2 at = ivec2(gl_FragCoord.xy), size = textureSize(farthest, 0);
  widest = vec4(NONE);
  for (int k = -${RIM_PX}; k <= ${RIM_PX}; k++)
    widest = max(widest, texelFetch(farthest, clamped(at + ivec2(k, 0), size), 0));
}`;

// Solid pixels near a hole whose depth is that of the hole's background: colour, weight 1.
const RIM_FRAGMENT = `${COMMON}
uniform sampler2D colours; uniform sampler2D depths; uniform sampler2D farthest;
out vec4 rim;
void main() {
  ivec2 at = ivec2(gl_FragCoord.xy), size = textureSize(farthest, 0);
  vec4 colour = texelFetch(colours, at, 0);
  rim = vec4(0.0);
  if (colour.a < SOLID) return;
  float most = NONE;
  for (int k = -${RIM_PX}; k <= ${RIM_PX}; k++)
    most = max(most, texelFetch(farthest, clamped(at + ivec2(0, k), size), 0).r);
  if (most >= 0.0 && 1.0 - texelFetch(depths, at, 0).r <= most) rim = vec4(colour.rgb / colour.a, 1.0);
}`;

const PULL_FRAGMENT = `
uniform sampler2D fine;
out vec4 coarse;                // mean colour of what was averaged, weight at most 1
void main() {
  ivec2 at = 2 * ivec2(gl_FragCoord.xy), size = textureSize(fine, 0);
  vec4 sum = vec4(0.0);
  for (int k = 0; k < 4; k++) {
    ivec2 from = at + ivec2(k & 1, k >> 1);
    if (from.x >= size.x || from.y >= size.y) continue;
    vec4 cell = texelFetch(fine, from, 0);
    sum += vec4(cell.rgb * cell.a, cell.a);
  }
  coarse = sum.a > 0.0 ? vec4(sum.rgb / sum.a, min(1.0, sum.a)) : vec4(0.0);
}`;

// Bilinear sample of the coarse level at the centre of a fine cell.
const SAMPLE = `
vec3 sampled(sampler2D coarse, ivec2 at) {
  ivec2 size = textureSize(coarse, 0), first = (at - 1) >> 1;
  vec2 s = vec2((at.x & 1) != 0 ? 0.25 : 0.75, (at.y & 1) != 0 ? 0.25 : 0.75);
  vec3 sum = vec3(0.0);
  for (int k = 0; k < 4; k++) {
    ivec2 step = ivec2(k & 1, k >> 1);
    vec2 weight = mix(1.0 - s, s, vec2(step));
    sum += weight.x * weight.y * texelFetch(coarse, clamp(first + step, ivec2(0), size - 1), 0).rgb;
  }
  return sum;
}`;

const PUSH_FRAGMENT = `${SAMPLE}
uniform sampler2D fine; uniform sampler2D coarse;
out vec4 filled;
void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  vec4 own = texelFetch(fine, at, 0);
  filled = vec4(own.a >= 1.0 ? own.rgb : mix(sampled(coarse, at), own.rgb, own.a), 1.0);
}`;

// The picture over its background, which beyond the panorama's border darkens softly; outlines of surfaces are mixed.
const COMPOSE_FRAGMENT = `${COMMON}
uniform sampler2D colours; uniform sampler2D depths; uniform sampler2D farthest; uniform sampler2D background;
uniform float slack;
uniform float leastStep;              // of inverse z-depth
uniform mat3 axes; uniform vec4 lens; // right, down, forward from the arc's axes; fx, fy, cx, cy [pixels]
uniform vec4 border;                  // theta in the middle, half its extent; v of the top, of the bottom
uniform vec2 fade;
uniform ivec2 corner;                 // of the picture in what is drawn into
out vec4 shown;
float beyond(vec2 place) {
  vec3 ray = transpose(axes) * vec3((place - lens.zw) / lens.xy, 1.0);
  float theta = atan(ray.y, ray.x) - border.x, slope = atan(ray.z, length(ray.xy));
  theta = abs(theta - 6.283185307 * round(theta / 6.283185307));
  return max(theta - border.y, max(slope - atan(border.z), atan(border.w) - slope));
}
vec3 composed(ivec2 at) {
  vec4 own = texelFetch(colours, at, 0);
  if (own.a >= SOLID) return own.rgb / own.a;
  float light = mix(1.0, 0.3, smoothstep(fade.x, fade.y, beyond(vec2(at) + 0.5)));
  return own.rgb + (1.0 - own.a) * light * texelFetch(background, at, 0).rgb;
}
float inverseZ(ivec2 at) {
  float depth = texelFetch(depths, at, 0).r, behind = (texelFetch(farthest, at, 0).r - slack) / 1.1;
  return depth < 1.0 ? 1.0 - depth : behind <= 1.0 ? max(behind, 0.0) : 0.0;
}
bool isBeside(float z, float other) { return abs(other - z) <= ${OUTLINE_SHARE} * z + leastStep; }
bool isBend(ivec2 a, ivec2 middle, ivec2 b) {
  vec3 z = vec3(inverseZ(a), inverseZ(middle), inverseZ(b));
  return abs(z.x + z.z - 2.0 * z.y) > ${OUTLINE_SHARE} * max(max(z.x, z.z), z.y) + leastStep;
}
void main() {
  ivec2 at = ivec2(gl_FragCoord.xy) - corner, size = textureSize(colours, 0);
  at.y = size.y - 1 - at.y;  // the picture's first row is shown at the top
  ivec2 low = at - 1, high = at + 1;
  bool inside = low == clamped(low, size) && high == clamped(high, size);
  bool outline = inside && (isBend(ivec2(low.x, at.y), at, ivec2(high.x, at.y)) ||
                            isBend(ivec2(at.x, low.y), at, ivec2(at.x, high.y)) ||
                            isBend(low, at, high) || isBend(ivec2(low.x, high.y), at, ivec2(high.x, low.y)));
  if (!outline) {
    shown = vec4(composed(at), 1.0);
    return;
  }
  float own = inverseZ(at);
  int beside = -1;  // of its neighbours, on its surface
  for (int k = 0; k < 9; k++) beside += isBeside(own, inverseZ(low + ivec2(k % 3, k / 3))) ? 1 : 0;
  vec4 sum = vec4(0.0);
  for (int k = 0; k < 9; k++) {
    ivec2 by = ivec2(k % 3, k / 3) - 1, from = at + by;
    if (beside <= ${SPECK_NEIGHBOURS} && isBeside(own, inverseZ(from))) continue;
    float weight = by == ivec2(0) ? 8.0 : by.x * by.y == 0 ? 2.0 : 1.0;
    sum += weight * vec4(composed(from), 1.0);
  }
  shown = vec4(sum.rgb / sum.a, 1.0);
}`;

/**
 * Continues the background over what a picture leaves open, as `ldp render --fill background` does (core/view/inpainting):
 * from the pixels beside a hole that are as far as what lies behind it, averaged to coarser and coarser levels and back.
 */
export class BackgroundFill {
  /** @param {WebGL2RenderingContext} gl @param {import('../reader/records.js').Head} head */
  constructor(gl, head) {
    Object.assign(this, { gl, head });
    const program = (fragment) => makeProgram(gl, SCREEN_VERTEX, fragment);
    this.begin = program(BEGIN_FRAGMENT);
    this.spread = program(SPREAD_FRAGMENT);
    this.farthest = program(FARTHEST_FRAGMENT);
    this.widen = program(WIDEN_FRAGMENT);
    this.rim = program(RIM_FRAGMENT);
    this.pull = program(PULL_FRAGMENT);
    this.push = program(PUSH_FRAGMENT);
    this.compose = program(COMPOSE_FRAGMENT);
    this.array = gl.createVertexArray();
    const floats = gl.getExtension('EXT_color_buffer_float') || gl.getExtension('EXT_color_buffer_half_float');
    this.format = floats ? { internal: gl.RGBA16F, format: gl.RGBA, type: gl.HALF_FLOAT } : null;
    this.targets = null;
  }

  /** Whether this graphics chip can; if not, pictures are shown as they are. */
  get works() { return this.format !== null; }

  resize(width, height) {
    if (this.targets?.width === width && this.targets.height === height) return;
    this.free();
    const make = (w, h) => new Target(this.gl, w, h, this.format);
    const levels = [];
    for (let [w, h] = [width, height]; ; [w, h] = [(w + 1) >> 1, (h + 1) >> 1]) {
      levels.push({ pulled: make(w, h), pushed: make(w, h) });
      if (w === 1 && h === 1) break;
    }
    this.targets = { width, height, levels, spare: [make(width, height), make(width, height)] };
  }

  free() {
    for (const { pulled, pushed } of this.targets?.levels ?? []) [pulled, pushed].forEach((target) => target.free());
    this.targets?.spare.forEach((target) => target.free());
    this.targets = null;
  }

  /**
   * @param {Target} picture with depth: colours multiplied by opacity, inverse z-depth
   * @param {import('./surface_renderer.js').ViewCamera} camera
   * @param {number} near depth buffers hold 1 - near x inverse z-depth
   * @param {{framebuffer: WebGLFramebuffer|null, x: number, y: number}} into null: the canvas; lower left corner there
   */
  run(picture, camera, near, into) {
    this.gl.bindVertexArray(this.array);
    this.resize(picture.width, picture.height);
    const farthest = this.makeRim(picture, FARTHER * near);
    this.pullAndPush();
    this.gl.bindFramebuffer(this.gl.FRAMEBUFFER, into.framebuffer);
    this.gl.viewport(into.x, into.y, picture.width, picture.height);
    this.pass(this.compose, null, { colours: picture.texture, depths: picture.depth, farthest: farthest.texture,
                                     background: this.targets.levels[0].pushed.texture },
              (uniforms) => this.setCompose(uniforms, camera, near, into));
    this.gl.bindVertexArray(null);
  }

  /** @returns {Target} of holes, how near their background may be */
  makeRim(picture, slack) {
    const { levels, spare: [a, b] } = this.targets;
    this.pass(this.begin, a, { colours: picture.texture, depths: picture.depth });
    let [from, to] = [a, b];
    for (let apart = 1; apart < Math.max(picture.width, picture.height); apart *= 2) {
      this.pass(this.spread, to, { before: from.texture }, ({ apart: at }) => this.gl.uniform1i(at, apart));
      [from, to] = [to, from];
    }
    this.pass(this.farthest, to, { colours: picture.texture, nearest: from.texture },
              (uniforms) => this.gl.uniform1f(uniforms.slack, slack));
    this.pass(this.widen, from, { farthest: to.texture });
    this.pass(this.rim, levels[0].pulled, { colours: picture.texture, depths: picture.depth, farthest: from.texture });
    return to;
  }

  pullAndPush() {
    const { levels } = this.targets;
    for (let i = 1; i < levels.length; i++) this.pass(this.pull, levels[i].pulled, { fine: levels[i - 1].pulled.texture });
    for (let i = levels.length - 2; i >= 0; i--) {
      const coarse = i === levels.length - 2 ? levels[i + 1].pulled : levels[i + 1].pushed;
      this.pass(this.push, levels[i].pushed, { fine: levels[i].pulled.texture, coarse: coarse.texture });
    }
  }

  setCompose(uniforms, camera, near, { x, y }) {
    const { gl, head } = this;
    gl.uniform1f(uniforms.slack, FARTHER * near);
    gl.uniform1f(uniforms.leastStep, (near * OUTLINE_PARALLAX_PX * head.vPitch) / (head.radius > 0 ? head.radius : 1));
    gl.uniform2i(uniforms.corner, x, y);
    gl.uniformMatrix3fv(uniforms.axes, true, camera.axes);
    gl.uniform4f(uniforms.lens, camera.fx, camera.fy, camera.cx, camera.cy);
    const half = (head.width * head.thetaPitch) / 2;
    gl.uniform4f(uniforms.border, head.thetaLeft - half, head.wraps ? 10 : half, head.vTop, head.vTop - head.height * head.vPitch);
    gl.uniform2f(uniforms.fade, ...FADE);
  }

  /** One pass over a target's pixels (null: what is bound). */
  pass({ program, uniforms }, target, textures, set = () => {}) {
    const { gl } = this;
    target?.bind();
    gl.useProgram(program);
    Object.entries(textures).forEach(([name, texture], unit) => {
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(gl.TEXTURE_2D, texture);
      gl.uniform1i(uniforms[name], unit);
    });
    set(uniforms);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.activeTexture(gl.TEXTURE0);
  }
}
