// Panoramas seen all around: known directions of what is seen, one eye and two.
#include "core/export/around.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <md5.h>

#include <cctype>
#include <cmath>
#include <numbers>

#include "core/export/export.h"
#include "core/export/picture_metadata.h"
#include "core/photos/images.h"
#include "tests/golden/synthetic_panorama.h"

namespace ldp {
namespace {

using ::testing::HasSubstr;

constexpr double kPitch = 2 * std::numbers::pi / 1440;
constexpr double kWall_m = 2;  // from the axis
constexpr double kArm_m = 0.6;

// A cylinder about the arc's axis, grey, with a white stripe of three columns to either side of an angle of the arc.
LayeredPanorama stripe_on_a_wall(int columns_from_middle) {
  const double stripe_rad = columns_from_middle * kPitch;
  LayeredPanorama panorama = synthetic_panorama({600, 240, 0, 1});
  PanoramaGrid& grid = panorama.grid;
  grid.arc.centre = {0.3, -0.2, 0.1};
  grid.arc.world_from_arc = Eigen::Matrix3d::Identity();
  grid.arc.radius = kArm_m;
  grid.theta_pitch = grid.v_pitch = kPitch;
  grid.theta_left = 300 * kPitch;  // the sweep's middle is angle 0
  grid.v_top = 120 * kPitch;
  grid.w_far = 0;
  grid.w_near = 1 / (kWall_m - kArm_m);
  panorama.layers[0].depth = encode_depth(DisparityMap(600, 240, kDisparitySteps), 0);
  for (int y = 0; y < 240; ++y)
    for (int x = 0; x < 600; ++x) {
      const bool is_white = std::abs(grid.theta(x + 0.5) - stripe_rad) < 3 * kPitch;
      panorama.layers[0].colour.at(x, y) = is_white ? Rgb{250, 250, 250} : Rgb{40, 40, 40};
      panorama.layers[0].coverage.at(x, y) = 1;
    }
  return panorama;
}

// The angle at which the stripe is seen in the middle row.
double seen_at(const FlatPanorama& flat) {
  double sum = 0, weights = 0;
  const int row = flat.full_height / 2 - flat.top;
  for (int x = 0; x < flat.image.width; ++x) {
    const double weight = std::max(0, flat.image.at(x, row).g - 60);
    sum += weight * (flat.image.width / 2.0 - x - 0.5) * kPitch;
    weights += weight;
  }
  return sum / weights;
}

// Of a point of the wall, from a place at a height of 0: in the arc's axes.
double direction_of(double wall_rad, const Eigen::Vector2d& at) {
  return std::atan2(kWall_m * std::sin(wall_rad) - at.y(), kWall_m * std::cos(wall_rad) - at.x());
}

TEST(Around, FromTheAxisEverythingIsWhereItStands) {
  for (const int columns : {-206, -46, 0, 80, 229}) {
    const LayeredPanorama panorama = stripe_on_a_wall(columns);
    const FlatPanorama flat = see_around(panorama, Renderer(panorama), Eigen::Vector3d::Zero());
    EXPECT_EQ(flat.full_width, 1440);
    EXPECT_NEAR(seen_at(flat), columns * kPitch, kPitch / 4) << columns;
  }
}

TEST(Around, FromBesideItNearThingsMoveAsTheyShould) {
  for (const Eigen::Vector2d& at : {Eigen::Vector2d(0.2, 0.0), {0.0, 0.2}, {-0.1, -0.15}}) {
    const LayeredPanorama panorama = stripe_on_a_wall(92);
    const FlatPanorama flat = see_around(panorama, Renderer(panorama), {at.x(), at.y(), 0});
    EXPECT_NEAR(seen_at(flat), direction_of(92 * kPitch, at), kPitch / 4) << at.transpose();
    for (const int x : {0, 599}) EXPECT_NEAR(flat.image.at(x, 120).g, 40, 5) << "the wall goes on where it is not seen";
  }
}

// A tangent ray that touches the circle of the eyes meets the wall asin(e / 2 / wall) further on.
TEST(Around, TwoEyesSeeItApartByTheirDistance) {
  const double eyes = 0.2, half = std::asin(eyes / 2 / kWall_m);
  for (const int columns : {-160, 0, 115}) {
    const double stripe = columns * kPitch;
    const LayeredPanorama panorama = stripe_on_a_wall(columns);
    const auto [left, right] = see_around_in_stereo(panorama, Renderer(panorama), {.eyes = eyes});
    EXPECT_NEAR(seen_at(left), stripe - half, kPitch / 4) << "further to the right";
    EXPECT_NEAR(seen_at(right), stripe + half, kPitch / 4);
  }
}

TEST(Around, RowsLieAtTheirElevation) {
  LayeredPanorama panorama = stripe_on_a_wall(0);
  const PanoramaGrid& grid = panorama.grid;
  const int row = 60;  // as high above the wall's foot as its v says, at unit depth from the arc
  for (int y = 0; y < 240; ++y)
    for (int x = 0; x < 600; ++x) panorama.layers[0].colour.at(x, y) = y < row ? Rgb{250, 250, 250} : Rgb{40, 40, 40};
  const FlatPanorama flat = see_around(panorama, Renderer(panorama), Eigen::Vector3d::Zero());
  const double elevation = std::atan((kWall_m - kArm_m) * grid.v(row) / kWall_m);
  const double expected = (std::numbers::pi / 2 - elevation) / kPitch - flat.top;
  for (const int x : {100, 300, 305, 500}) {
    EXPECT_GT(flat.image.at(x, static_cast<int>(std::lround(expected)) - 2).g, 200) << x;
    EXPECT_LT(flat.image.at(x, static_cast<int>(std::lround(expected)) + 2).g, 80) << x;
  }
}

TEST(Around, TheLeftEyeIsAboveTheRightOne) {
  FlatPanorama left{RgbImage(4, 2), 8, 4, 2, 1}, right = left;
  left.image.at(0, 0) = {1, 1, 1};
  right.image.at(3, 1) = {2, 2, 2};
  const RgbImage both = top_bottom(left, right);
  EXPECT_EQ(both.width, 8);
  EXPECT_EQ(both.height, 8);
  EXPECT_EQ(both.at(2, 1).r, 1);
  EXPECT_EQ(both.at(5, 4 + 2).r, 2);
}

TEST(Around, FilesTellPlayersWhatTheyHold) {
  const auto file_of = [](const char* name, Kind kind) {
    const std::vector<uint8_t> bytes = export_seen(name, stripe_on_a_wall(0), kind, {});
    return std::string(bytes.begin(), bytes.end());
  };
  for (const char* name : {"a.jpg", "a.png"}) {
    const std::string stereo = file_of(name, Kind::stereo), one = file_of(name, Kind::panorama);
    EXPECT_THAT(stereo, HasSubstr("GSpherical:StereoMode=\"top-bottom\"")) << name;
    EXPECT_THAT(stereo, HasSubstr("GPano:ProjectionType=\"equirectangular\"")) << name;
    EXPECT_THAT(one, HasSubstr("GPano:CroppedAreaImageWidthPixels=\"600\"")) << name;
    EXPECT_THAT(one, HasSubstr("GPano:FullPanoWidthPixels=\"1440\"")) << name;
  }
  EXPECT_THROW(export_seen("a.glb", stripe_on_a_wall(0), Kind::stereo, {}), std::runtime_error);
}

TEST(Around, DepthIsTheDistanceFromTheEyeAlongEachRay) {
  for (const Eigen::Vector2d& at : {Eigen::Vector2d(0, 0), {0.2, 0.0}, {-0.1, -0.15}}) {
    const LayeredPanorama panorama = stripe_on_a_wall(0);
    const FlatPanorama flat = see_around(panorama, Renderer(panorama), {at.x(), at.y(), 0});
    ASSERT_EQ(flat.inverse_distance.width, flat.image.width);
    for (const int x : {150, 300, 420})
      for (const int row : {-50, 0, 50}) {
        const double turn = (flat.image.width / 2.0 - x - 0.5) * kPitch, elevation = -(row + 0.5) * kPitch;
        const Eigen::Vector2d forward(std::cos(turn), std::sin(turn));
        const double along = at.dot(forward);
        const double to_wall = -along + std::sqrt(along * along + kWall_m * kWall_m - at.squaredNorm());
        const float found = flat.inverse_distance.at(x, flat.full_height / 2 - flat.top + row);
        EXPECT_NEAR(1 / found, to_wall / std::cos(elevation), 0.004) << at.transpose() << ", " << x << ", " << row;
      }
  }
}

TEST(Around, AClosedPanoramaFillsItsSphereAtAnyWidth) {
  for (const int width : {242, 243, 245}) {
    const LayeredPanorama panorama = synthetic_panorama({width, 60, 0, 1, false, Rays::pushbroom, true});
    const FlatPanorama flat = see_around(panorama, Renderer(panorama), Eigen::Vector3d::Zero());
    EXPECT_EQ(flat.image.width, flat.full_width);
    EXPECT_EQ(flat.full_width, 2 * flat.full_height);
    EXPECT_EQ(flat.left, 0);
  }
}

TEST(Around, DepthGoesOnBehindWhatIsNotSeen) {
  LayeredPanorama panorama = stripe_on_a_wall(0);
  for (int y = 0; y < 240; ++y)
    for (int x = 300; x < 340; ++x) panorama.layers[0].coverage.at(x, y) = 0;
  const FlatPanorama flat = see_around(panorama, Renderer(panorama), Eigen::Vector3d::Zero());
  EXPECT_NEAR(flat.inverse_distance.at(320, 120), 1 / kWall_m, 1e-3);
  for (const float w : flat.inverse_distance.samples) EXPECT_GE(w, 0);
}

TEST(Around, DepthCodesRunFromTheNearestToTheFarthest) {
  FlatPanorama flat{RgbImage(4, 1), 8, 4, 2, 1};
  flat.inverse_distance = Plane<float>(4, 1);
  flat.inverse_distance.samples = {0.5F, 0.3125F, 0.125F, 0.0F};
  const RangeInverse depth = range_inverse(flat);
  EXPECT_NEAR(depth.nearest, 2, 1e-6);
  EXPECT_NEAR(depth.farthest, 8, 1e-6);
  EXPECT_THAT(depth.codes.samples, ::testing::ElementsAre(0, 32768, 65535, 65535));
  flat.inverse_distance.samples = {0, 0, 0, 0};
  EXPECT_THAT(range_inverse(flat).codes.samples, ::testing::Each(65535)) << "all at infinity";
}

// What stands in the extended XMP of a JPEG, put together again from its segments.
std::string extended_xmp(const std::string& file) {
  const std::string mark("http://ns.adobe.com/xmp/extension/\0", 35);
  std::string extended;
  for (size_t at = file.find(mark); at != std::string::npos; at = file.find(mark, at + 1)) {
    const auto byte = [&](size_t i) { return static_cast<size_t>(static_cast<uint8_t>(file[i])); };
    const size_t length = byte(at - 2) << 8 | byte(at - 1);
    const size_t content = at + mark.size() + 40;
    EXPECT_EQ(byte(content - 2) << 8 | byte(content - 1), extended.size() & 0xFFFF) << "segments in order";
    extended += file.substr(content, at - 2 + length - content);
  }
  return extended;
}

TEST(Around, AJpegHoldsItsDepth) {
  const std::vector<uint8_t> bytes = export_seen("a.jpg", stripe_on_a_wall(0), Kind::depth, {});
  const std::string file(bytes.begin(), bytes.end());
  EXPECT_EQ(image_size(bytes, "a.jpg").width, 600);
  EXPECT_THAT(file, HasSubstr("GDepth:Format=\"RangeInverse\""));
  EXPECT_THAT(file, HasSubstr("GDepth:MeasureType=\"OpticRay\""));
  EXPECT_THAT(file, HasSubstr("GPano:FullPanoWidthPixels=\"1440\""));
  const std::string extended = extended_xmp(file);
  char digest[MD5_DIGEST_STRING_LENGTH];
  MD5Data(reinterpret_cast<const uint8_t*>(extended.data()), extended.size(), digest);
  for (char& digit : digest) digit = static_cast<char>(std::toupper(digit));
  EXPECT_THAT(file, HasSubstr("xmpNote:HasExtendedXMP=\"" + std::string(digest) + "\""));
  EXPECT_THAT(extended, HasSubstr("GDepth:Data=\"iVBORw0KGgo")) << "a PNG in base64";
}

TEST(Around, APngIsItsDepthAlone) {
  const std::vector<uint8_t> bytes = export_seen("a.png", stripe_on_a_wall(0), Kind::depth, {});
  EXPECT_EQ(image_size(bytes, "a.png").width, 600);
  EXPECT_EQ(bytes[24], 16) << "bits";
  EXPECT_EQ(bytes[25], 0) << "grey";
  EXPECT_THAT(std::string(bytes.begin(), bytes.end()), HasSubstr("GDepth:Far=\""));
}

}  // namespace
}  // namespace ldp
