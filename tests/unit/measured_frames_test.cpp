// Photographs that are measured when they are first read.
#include "core/verdict/measured_frames.h"

#include <gtest/gtest.h>

#include "tests/unit/simple_capture.h"

namespace ldp {
namespace {

TEST(MeasuredFrames, APhotographIsMeasuredWhenItIsRead) {
  RgbImage grey(32, 24), dark(32, 24);
  for (Rgb& pixel : grey.samples) pixel = {100, 100, 100};
  for (Rgb& pixel : dark.samples) pixel = {10, 10, 10};
  const test::FramesInMemory frames({grey, dark});
  const MeasuredFrames measured(frames);
  EXPECT_EQ(measured.load(1).samples, dark.samples);
  EXPECT_NEAR(measured.of(1).brightness, 10, 1);
  EXPECT_ANY_THROW(measured.of(0));
  measured.load(0);
  EXPECT_NEAR(measured.of(0).brightness, 100, 1);
}

}  // namespace
}  // namespace ldp
