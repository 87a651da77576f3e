// The pictures that a build draws of its steps, pixel by pixel.
#include "core/pipeline/debug_pictures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "core/photos/images.h"

namespace ldp {
namespace {

using testing::ElementsAre;
using testing::ElementsAreArray;

constexpr Rgb kAbsent{20, 20, 70};

class DebugPicturesTest : public testing::Test {
 protected:
  DebugPicturesTest() {
    std::string name = testing::TempDir() + "debug_pictures_XXXXXX";
    folder_ = mkdtemp(name.data());
  }
  ~DebugPicturesTest() override { std::filesystem::remove_all(folder_); }

  DebugPictures pictures() const { return DebugPictures((folder_ / "steps").string()); }
  RgbImage drawn(const std::string& name) const { return read_image(folder_ / "steps" / (name + ".png")); }

  std::filesystem::path folder_;
};

TEST_F(DebugPicturesTest, AreNoneWithoutAFolder) {
  const DebugPictures none("");
  EXPECT_FALSE(none.wanted());
  none.labels("a", Plane<uint8_t>(2, 2), 3);
  none.colour("b", RgbImage(2, 2));
  EXPECT_TRUE(pictures().wanted());
  EXPECT_TRUE(std::filesystem::is_empty(folder_)) << "the folder is made with the first of them";
}

TEST_F(DebugPicturesTest, LabelsAreGreyUpToTheLargest) {
  Plane<uint8_t> labels(3, 2);
  labels.samples = {5, 1, 0, 10, 11, 255};
  pictures().labels("labels", labels, 10);
  const RgbImage image = drawn("labels");
  const std::vector<uint8_t> expected = {127, 25, 0, 255, 0, 0};
  for (size_t i = 0; i < 6; ++i) EXPECT_EQ(image.samples[i], (Rgb{expected[i], expected[i], expected[i]})) << i;
}

TEST_F(DebugPicturesTest, DisparitiesAreGreyAndAbsentOnesDarkBlue) {
  DisparityMap disparity(2, 2);
  disparity.samples = {kDisparitySteps, 0, kNoDisparity, kDisparitySteps / 3};
  pictures().disparity("disparity", disparity);
  const RgbImage image = drawn("disparity");
  EXPECT_THAT(image.samples, ElementsAreArray(std::vector<Rgb>{{255, 255, 255}, {0, 0, 0}, kAbsent, {85, 85, 85}}));
}

TEST_F(DebugPicturesTest, SourcesAreOneHueAFrameAndBlackWhereNone) {
  SourceMap sources(3, 2, 4);
  sources.set(0, 0, 3), sources.set(2, 0, 3), sources.set(1, 1, 2);
  pictures().sources("sources", sources);
  const RgbImage image = drawn("sources");
  const Rgb third = {60 + 3 * 97 % 196, 60 + 3 * 57 % 196, 60 + 3 * 151 % 196};
  EXPECT_EQ(image.at(0, 0), third);
  EXPECT_EQ(image.at(2, 0), third);
  EXPECT_EQ(image.at(1, 1), (Rgb{60 + 2 * 97 % 196, 60 + 2 * 57 % 196, 60 + 2 * 151 % 196}));
  EXPECT_EQ(image.at(1, 0), (Rgb{0, 0, 0}));
}

TEST_F(DebugPicturesTest, WhatACameraSeesIsTurnedUpright) {
  std::vector<VisibilityMap> maps(2);
  maps[1].inverse_z = Plane<uint16_t>(3, 2);  // column by column: 2 of 3 rows
  maps[1].inverse_z.samples = {64, 128, 0, 65535, 640, 6400};
  maps[0].inverse_z = Plane<uint16_t>(1, 1);
  pictures().visibility("seen", maps);
  EXPECT_THAT(drawn("seen camera 000").samples, ElementsAre(kAbsent));
  const RgbImage image = drawn("seen camera 001");
  ASSERT_EQ(image.width, 2);
  ASSERT_EQ(image.height, 3);
  EXPECT_THAT(image.samples, ElementsAreArray(std::vector<Rgb>{
                                 {1, 1, 1}, {255, 255, 255}, {2, 2, 2}, {10, 10, 10}, kAbsent, {100, 100, 100}}));
}

TEST_F(DebugPicturesTest, AgreementHasAColourAClassAndColoursAreThemselves) {
  Plane<uint8_t> agreement(2, 1);
  agreement.samples = {1, 0};
  pictures().agreement("agreement", agreement);
  EXPECT_THAT(drawn("agreement").samples, ElementsAreArray(std::vector<Rgb>{{0, 0, 0}, {255, 255, 255}}));
  RgbImage colour(2, 1);
  colour.samples = {{1, 2, 3}, {250, 9, 0}};
  pictures().colour("colour", colour);
  EXPECT_EQ(drawn("colour").samples, colour.samples);
}

}  // namespace
}  // namespace ldp
