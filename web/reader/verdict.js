/** By the codes of FORMAT.md, section 4: name, what is wrong (%s: where), advice. The words are core/verdict/words.cpp's. */
const REASONS = [
  ['blurred', 'the photos%s are blurred', 'turn more slowly there'],
  ['dark', 'the photos%s are dark and noisy', 'take them in more light, or turn more slowly at a longer exposure'],
  ['little_overlap', 'the photos%s show too little in common', 'take more of them, three quarters overlapping'],
  ['no_parallax', 'the camera only turned and did not move', 'hold it at arm\'s length and turn on the spot'],
  ['moved_forward', 'the camera moved forward instead of around', 'stay on the spot and turn'],
  ['moved_straight', 'the camera moved along a line instead of around', 'stay on the spot and turn'],
  ['poses_doubtful', 'where the camera was is doubtful', 'turn slowly, past things that differ and stand still'],
  ['photos_left_out', 'many photos were left out', 'take one sweep alone, without haste'],
  ['exposure_jumps', 'the exposure jumps between the photos%s', 'lock the exposure'],
  ['contradicted', 'the photos%s contradict each other', 'wait until nothing moves, and keep away from what is near'],
  ['holes', 'views%s have holes', 'sweep all of it'],
  ['lens_doubtful', 'the photos do not fit the lens', 'give its true field of view, or none'],
  ['looked_inward', 'the camera went around a thing and looked at it', 'stay on the spot, turn, and look outward'],
];
const GRADES = ['good', 'fair', 'sweep_again'];
const MOST_REASONS = 100;

/**
 * @typedef {object} Verdict
 * @property {'good'|'fair'|'sweep_again'} verdict
 * @property {number|undefined} expectedViewPsnrDb of new views from within the arm's reach
 * @property {{code: string, text: string, fromDeg: number, toDeg: number}[]} reasons the weightiest first; degrees of turn
 *   from the sweep's first photo
 */

/**
 * The verdict on the sweep among the figures of a `qual` chunk.
 * @param {Map<string, number>} figures
 * @returns {Verdict|null} null where the sweep was not judged or a figure makes no sense
 */
export function verdictOf(figures) {
  const grade = GRADES[figures.get('verdict')];
  if (!grade) return null;
  const reasons = [];
  for (let i = 0; i < MOST_REASONS; i++) {
    const figure = (name) => figures.get(`reason.${String(i).padStart(2, '0')}.${name}`);
    if (figure('code') === undefined) break;
    const [fromDeg, toDeg] = [figure('from_deg'), figure('to_deg')];
    if (!REASONS[figure('code')] || !Number.isFinite(fromDeg) || !Number.isFinite(toDeg)) return null;
    const [code, wrong, advice] = REASONS[figure('code')];
    reasons.push({ code, text: `${wrong.replace('%s', placeOf(fromDeg, toDeg))}: ${advice}`, fromDeg, toDeg });
  }
  return { verdict: grade, expectedViewPsnrDb: figures.get('expected_view_psnr_db'), reasons };
}

/** Beyond a turn angles begin anew; those before the first photo's are negative. */
function placeOf(fromDeg, toDeg) {
  const before = 360 * Math.max(0, Math.floor(fromDeg / 360));
  const behind = toDeg - before > 360 ? before + 360 : before;
  const [from, to] = [Math.round(fromDeg - before), Math.round(toDeg - behind)];
  return from === to ? ` near ${from} degrees` : ` between ${from} and ${to} degrees`;
}
