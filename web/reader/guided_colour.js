// FORMAT.md, section 7: lossy WebP keeps colour at half resolution; guided by luma it gets back most of the rest.
const BLOCKS = 9; // 3 across and 3 down, from which a slope is estimated
const PLAIN_VARIANCE = 1 << 14;
const MOST_SLOPE = 512;

const lumaOf = (r, g, b) => (77 * r + 150 * g + 29 * b + 128) >> 8;
const ofGreen = (ofRed, ofBlue) => -Math.trunc((77 * ofRed + 29 * ofBlue) / 150);

/** @param {Uint8Array} file @returns {boolean} whether it is a WebP image of the kind that is to be guided */
export function isLossyWebp(file) {
  return file.length >= 16 && String.fromCharCode(...file.subarray(12, 16)) === 'VP8 ';
}

/**
 * @param {{width: number, height: number, data: Uint8Array|Uint8ClampedArray}} image RGBA, of even sides
 * @returns {{width: number, height: number, data: Uint8ClampedArray}}
 */
export function guidedColour({ width, height, data }) {
  const blocks = blocksOf(width, height, data);
  const slopes = slopesOf(blocks);
  const out = new Uint8ClampedArray(data);
  const [luma, red, blue] = [0, 1, 2].map(() => new Int32Array(width));
  for (let y = 0; y < height; y++) {
    interpolate(blocks, blocks.luma, y, luma);
    interpolate(blocks, slopes.red, y, red);
    interpolate(blocks, slopes.blue, y, blue);
    for (let x = 0, i = 4 * y * width; x < width; x++, i += 4) {
      const rise = 64 * lumaOf(data[i], data[i + 1], data[i + 2]) - luma[x];
      out[i] += (red[x] * rise + (1 << 17)) >> 18;
      out[i + 1] += (ofGreen(red[x], blue[x]) * rise + (1 << 17)) >> 18;
      out[i + 2] += (blue[x] * rise + (1 << 17)) >> 18;
    }
  }
  return { width, height, data: out };
}

/** Of blocks of 2 x 2 pixels the sums of luma and of what red and blue differ from it. */
function blocksOf(width, height, data) {
  const [across, down] = [width / 2, height / 2];
  const [luma, red, blue] = [0, 1, 2].map(() => new Int16Array(across * down));
  for (let y = 0, i = 0; y < height; y++)
    for (let x = 0; x < width; x++, i += 4) {
      const grey = lumaOf(data[i], data[i + 1], data[i + 2]);
      const block = (y >> 1) * across + (x >> 1);
      luma[block] += grey;
      red[block] += data[i] - grey;
      blue[block] += data[i + 2] - grey;
    }
  return { across, down, luma, red, blue };
}

/** How much red and blue differ more from luma where luma is a level more, in 256ths. */
function slopesOf({ across, down, luma, red, blue }) {
  const slopes = { red: new Int16Array(across * down), blue: new Int16Array(across * down) };
  const slope = (sum, product, lumaSum, variance) => {
    const covariance = BLOCKS * product - lumaSum * sum;
    const ratio = Math.trunc((5 * covariance) / ((variance + PLAIN_VARIANCE) >> 6));
    return Math.max(-MOST_SLOPE, Math.min(ratio, MOST_SLOPE));
  };
  for (let y = 0; y < down; y++)
    for (let x = 0; x < across; x++) {
      let [sum, square, redSum, redProduct, blueSum, blueProduct] = [0, 0, 0, 0, 0, 0];
      for (let dy = -1; dy <= 1; dy++) {
        const row = Math.max(0, Math.min(y + dy, down - 1)) * across;
        for (let dx = -1; dx <= 1; dx++) {
          const i = row + Math.max(0, Math.min(x + dx, across - 1));
          sum += luma[i];
          square += luma[i] * luma[i];
          redSum += red[i];
          redProduct += luma[i] * red[i];
          blueSum += blue[i];
          blueProduct += luma[i] * blue[i];
        }
      }
      const variance = BLOCKS * square - sum * sum;
      slopes.red[y * across + x] = slope(redSum, redProduct, sum, variance);
      slopes.blue[y * across + x] = slope(blueSum, blueProduct, sum, variance);
    }
  return slopes;
}

/** Of blocks, for each pixel of row y, in sixteenths. */
function interpolate({ across, down }, values, y, out) {
  const near = (y >> 1) * across;
  const far = Math.max(0, Math.min((y >> 1) + (y & 1 ? 1 : -1), down - 1)) * across;
  const between = (x) => 3 * values[near + x] + values[far + x];
  for (let x = 0; x < across; x++) {
    const here = 3 * between(x);
    out[2 * x] = here + between(Math.max(x - 1, 0));
    out[2 * x + 1] = here + between(Math.min(x + 1, across - 1));
  }
}
