// The reader of .ldp files as other programs import it; see README.md.
export { DISPARITY_STEPS, NO_DISPARITY } from './reader/depth_codes.js';
export { ImageError, LdpError } from './reader/errors.js';
export { decodeImageInBrowser } from './reader/browser_images.js';
export { LdpReader, MOST_PIXELS } from './reader/ldp_reader.js';
export { verdictOf } from './reader/verdict.js';
export { evenedColour } from './reader/exposure.js';
