// Which pixels the viewer's surfaces join: the rule of core/view/tears.h.
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { CodedDepths, emptyLayer, joinedInViews } from '../../web/surfaces/prepared_layer.js';
import { DISPARITY_STEPS } from '../../web/reader/depth_codes.js';

// A step of so many pixels of parallax over one arc radius, between pixels whose red and blue differ by so many levels.
function isJoined(stepPx, red, blue = 0) {
  const head = { wFar: 0, wNear: 1, vPitch: 0.001, radius: 1 };
  const depths = new CodedDepths(head);
  const layer = emptyLayer(2, 1, 0);
  layer.code.set([0, Math.round(stepPx * head.vPitch * DISPARITY_STEPS)]);
  for (let i = 0; i < 2; i++) layer.w[i] = depths.w[layer.code[i]];
  layer.colour.set([90 | (90 << 16), (90 + red) | ((90 + blue) << 16)]);
  return joinedInViews(layer, depths, 0, 1);
}

test('surfaces are joined up to 6 px of parallax, where they look alike up to 24', () => {
  assert.ok(isJoined(5, 40));
  assert.ok(!isJoined(12, 40));
  assert.ok(!isJoined(12, 9));
  assert.ok(!isJoined(12, 0, -9));
  assert.ok(isJoined(12, 8, -8));
  assert.ok(isJoined(22, 0));
  assert.ok(!isJoined(30, 0));
});
