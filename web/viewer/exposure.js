import { makeTexture } from './gl.js';

/**
 * Takes local exposure back (FORMAT.md, `expo`): shownColour(colour, at) of a place in shares of the panorama's size.
 * `even` 0: as stored; 1: at even exposure; between them a part of the way.
 */
export const EXPOSURE_FRAGMENT = `
uniform sampler2D exposure;     // factors of light by direction, over the panorama
uniform float light[17];        // at levels 0, 16 .. 256
uniform float even;
float evenLevel(float level, float factor, float fade) {
  float at = level / 16.0;
  int knot = int(at);
  float of = mix(light[knot], light[knot + 1], at - float(knot)) / factor;
  knot = 0;
  while (knot < 15 && of >= light[knot + 1]) knot++;
  float to = min(255.0, 16.0 * (float(knot) + (of - light[knot]) / (light[knot + 1] - light[knot])));
  return factor > 1.0 ? mix(to, level, fade) : to;
}
vec3 shownColour(vec3 colour, vec2 at) {
  if (even == 0.0) return colour;
  vec3 factor = pow(texture(exposure, at).rgb, vec3(even)), level = 255.0 * colour;
  float t = max(0.0, max(level.r, max(level.g, level.b)) - 224.0) / 31.0, fade = t * t;
  return vec3(evenLevel(level.r, factor.r, fade), evenLevel(level.g, factor.g, fade), evenLevel(level.b, factor.b, fade)) / 255.0;
}`;

/** The response as the fragment shader wants it: any that rises where there is none. */
export function responseOf(exposure) {
  const most = exposure ? exposure.light[16] : 16;
  return Float32Array.from({ length: 17 }, (_, knot) => (exposure ? exposure.light[knot] : knot) / most);
}

/**
 * The factors as a texture that is read as FORMAT.md has it: bilinear between nodes, the same beyond the outermost ones,
 * around the turn where the panorama wraps. Without any, of one node that is 1.
 * @param {WebGL2RenderingContext} gl
 * @param {import('../reader/records.js').Exposure|null} exposure
 * @param {boolean} wraps
 */
export function makeExposureTexture(gl, exposure, wraps) {
  const { columns, rows, factors } = exposure ?? { columns: 1, rows: 1, factors: [4096, 4096, 4096] };
  const data = new Float32Array(4 * columns * rows);
  for (let node = 0; node < columns * rows; node++)
    for (let channel = 0; channel < 3; channel++) data[4 * node + channel] = factors[3 * node + channel] / 4096;
  const texture = makeTexture(gl, { internal: gl.RGBA16F, format: gl.RGBA, type: gl.FLOAT, width: columns, height: rows,
                                    filter: gl.LINEAR, data });
  if (wraps) gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.REPEAT);
  return texture;
}
