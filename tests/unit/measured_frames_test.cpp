// Photographs that are measured when they are first read.
#include "core/verdict/measured_frames.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <optional>
#include <string>

namespace ldp {
namespace {

RgbImage plain(uint8_t level) {
  RgbImage image(32, 24);
  for (Rgb& pixel : image.samples) pixel = {level, level, level};
  return image;
}

// Two photographs of one brightness, which rises with each reading.
class Brightening final : public FrameSource {
 public:
  int size() const override { return 2; }
  std::string name(int index) const override { return std::to_string(index); }
  RgbImage load(int) const override { return plain(level_ = static_cast<uint8_t>(level_ + 10)); }
  std::optional<double> focal_hint(int) const override { return {}; }

 private:
  mutable uint8_t level_ = 0;
};

TEST(MeasuredFrames, APhotographIsMeasuredWhenItIsReadFirst) {
  const Brightening frames;
  const MeasuredFrames measured(frames);
  EXPECT_EQ(measured.load(1).samples, plain(10).samples);
  EXPECT_THROW(measured.of(0), std::bad_optional_access);
  EXPECT_EQ(measured.load(0).samples, plain(20).samples);
  EXPECT_EQ(measured.load(1).samples, plain(30).samples);
  EXPECT_NEAR(measured.of(1).brightness, 10, 1);
  EXPECT_NEAR(measured.of(0).brightness, 20, 1);
}

}  // namespace
}  // namespace ldp
