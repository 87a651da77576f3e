// Parts of the renderer, each alone, against dumber ones.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/view/inpainting.h"
#include "core/view/mesh/code_smoother.h"
#include "core/view/mesh/torn_quads.h"
#include "core/view/mesh/underlay.h"
#include "core/view/outlines.h"
#include "core/view/raster/occlusion.h"
#include "core/view/raster/raster.h"
#include "core/view/raster/view_frustum.h"
#include "core/view/view_tuning.h"
#include "tests/unit/simple_capture.h"

namespace ldp::view {
namespace {

// --- inpainting ------------------------------------------------------------------------------------------------------

struct Picture {
  Picture(int width, int height, Rgb shown)
      : inverse_z(width, height, 0.5F), colour(width, height, shown), alpha(width, height, 255) {}
  void hole(int x0, int x1, int y0, int y1) {
    for (int y = y0; y < y1; ++y)
      for (int x = x0; x < x1; ++x) alpha.at(x, y) = 0, inverse_z.at(x, y) = -1, colour.at(x, y) = {255, 0, 255};
  }
  double fill() { return fill_background(inverse_z, colour, alpha); }

  Plane<float> inverse_z;
  RgbImage colour;
  Plane<uint8_t> alpha;
};

TEST(Inpainting, AWholePictureStaysAsItIs) {
  Picture picture(20, 10, {10, 20, 30});
  picture.alpha.at(3, 3) = kSolidAlpha;
  EXPECT_EQ(picture.fill(), 0);
  for (const Rgb& c : picture.colour.samples) EXPECT_EQ(c, (Rgb{10, 20, 30}));
  for (const uint8_t a : picture.alpha.samples) EXPECT_EQ(a, 255);
}

TEST(Inpainting, AHoleInOneColourGetsThatColour) {
  Picture picture(40, 30, {10, 20, 30});
  picture.hole(10, 20, 5, 25);
  EXPECT_DOUBLE_EQ(picture.fill(), 10.0 * 20 / (40 * 30));
  for (const Rgb& c : picture.colour.samples) {
    EXPECT_NEAR(c.r, 10, 1);
    EXPECT_NEAR(c.g, 20, 1);
    EXPECT_NEAR(c.b, 30, 1);
  }
  for (const uint8_t a : picture.alpha.samples) EXPECT_EQ(a, 255);
}

TEST(Inpainting, AHoleBesideSomethingNearGetsTheFarSidesColour) {
  Picture picture(40, 30, {200, 0, 0});
  for (int y = 0; y < 30; ++y)
    for (int x = 20; x < 40; ++x) picture.colour.at(x, y) = {0, 0, 200}, picture.inverse_z.at(x, y) = 0.1F;
  picture.hole(15, 20, 0, 30);  // beside what is near, on its left
  picture.fill();
  for (int y = 4; y < 26; ++y)
    for (int x = 15; x < 20; ++x) EXPECT_GT(picture.colour.at(x, y).b, 180) << x << ", " << y;
  EXPECT_EQ(picture.colour.at(14, 10), (Rgb{200, 0, 0})) << "what is there stays";
}

TEST(Inpainting, WhatIsHalfThereIsMixedInThatProportion) {
  Picture picture(20, 20, {100, 100, 100});
  picture.alpha.at(10, 10) = 51;
  picture.colour.at(10, 10) = {200, 0, 100};
  EXPECT_DOUBLE_EQ(picture.fill(), 1.0 / 400);
  EXPECT_NEAR(picture.colour.at(10, 10).r, 0.2 * 200 + 0.8 * 100, 1);
  EXPECT_NEAR(picture.colour.at(10, 10).g, 0.8 * 100, 1);
  EXPECT_NEAR(picture.colour.at(10, 10).b, 100, 1);
}

TEST(Inpainting, NothingAtAllBecomesGreyAtAnySize) {
  for (const int width : {1, 2, 3, 17})
    for (const int height : {1, 2, 5}) {
      Picture picture(width, height, {});
      picture.hole(0, width, 0, height);
      EXPECT_EQ(picture.fill(), 1);
      for (const Rgb& c : picture.colour.samples) EXPECT_EQ(c, (Rgb{127, 127, 127}));
    }
}

// --- outlines --------------------------------------------------------------------------------------------------------

constexpr Rgb kFarColour{10, 10, 10}, kNearColour{210, 110, 10};
constexpr float kFarZ = 0.1F, kNearZ = 0.5F, kLeastStep = 0.002F;

// A far wall, and what shows in it.
struct Scenery : Picture {
  Scenery() : Picture(12, 9, kFarColour) { std::fill(inverse_z.samples.begin(), inverse_z.samples.end(), kFarZ); }
  void stand(int x, int y) { inverse_z.at(x, y) = kNearZ, colour.at(x, y) = kNearColour; }
  void soften() {
    close_cracks(kLeastStep, inverse_z, colour, alpha);
    soften_outlines(kLeastStep, inverse_z, alpha, {}, colour);
  }
  int red(int x, int y) const { return colour.at(x, y).r; }
};

TEST(Outlines, PixelsOnBothSidesOfAStepAreMixed) {
  Scenery picture;
  for (int y = 0; y < 9; ++y)
    for (int x = 6; x < 12; ++x) picture.stand(x, y);
  picture.soften();
  EXPECT_EQ(picture.red(6, 0), 210);  // at the picture's edge
  for (int y = 1; y < 8; ++y) {
    EXPECT_EQ(picture.red(4, y), 10);
    EXPECT_EQ(picture.red(5, y), 50);  // 4 parts in 20 of the near one
    EXPECT_EQ(picture.red(6, y), 170);
    EXPECT_EQ(picture.red(7, y), 210);
  }
  EXPECT_EQ(picture.inverse_z.at(5, 4), kFarZ);
  EXPECT_EQ(picture.inverse_z.at(6, 4), kNearZ);
}

TEST(Outlines, ASlantedPlaneStaysSharp) {
  Scenery picture;
  for (int y = 0; y < 9; ++y)
    for (int x = 0; x < 12; ++x) {
      picture.inverse_z.at(x, y) = 0.05F + 0.03F * static_cast<float>(x) + 0.02F * static_cast<float>(y);
      picture.colour.at(x, y).r = static_cast<uint8_t>(x % 2 * 200);
    }
  const RgbImage before = picture.colour;
  picture.soften();
  EXPECT_EQ(picture.colour, before);
}

TEST(Outlines, SpecksVanishAndThreadsStay) {
  Scenery picture;
  picture.stand(2, 4);
  for (int y = 0; y < 9; ++y) picture.stand(8, y);
  picture.soften();
  EXPECT_EQ(picture.red(2, 4), 10);
  for (int y = 1; y < 8; ++y) EXPECT_EQ(picture.red(8, y), 130);  // 12 parts in 20
}

TEST(Outlines, HolesStayButForCracks) {
  Scenery picture;
  picture.hole(0, 4, 0, 9);
  picture.hole(8, 9, 0, 9);
  for (int y = 0; y < 9; ++y)
    for (int x = 9; x < 12; ++x) picture.stand(x, y);
  picture.soften();
  for (int y = 0; y < 9; ++y) {
    for (int x = 0; x < 4; ++x) EXPECT_EQ(picture.alpha.at(x, y), 0);
    EXPECT_EQ(picture.colour.at(4, y), kFarColour);  // the hole's own colour counts for nothing
  }
  for (int y = 2; y < 7; ++y) {
    EXPECT_EQ(picture.alpha.at(8, y), 255);
    EXPECT_EQ(picture.red(8, y), 50);  // far, mixed with the near one beside it
    EXPECT_EQ(picture.inverse_z.at(8, y), kFarZ);
  }
}

TEST(Outlines, AHoleBetweenSoftRimsOfNoSurfaceIsNoCrack) {
  Scenery picture;
  picture.hole(3, 8, 0, 9);
  for (int y = 0; y < 9; ++y) picture.alpha.at(4, y) = picture.alpha.at(6, y) = 60;
  picture.soften();
  for (int y = 0; y < 9; ++y) EXPECT_EQ(picture.alpha.at(5, y), 0);
}

TEST(Outlines, AFarSurfaceBesideAHoleStaysSharp) {
  Scenery picture;
  picture.hole(0, 6, 0, 9);
  for (int y = 0; y < 9; ++y) picture.colour.at(6, y) = kNearColour;
  picture.soften();
  for (int y = 0; y < 9; ++y) EXPECT_EQ(picture.red(6, y), 210);
}

TEST(Outlines, WhatAHoleHoldsIsNotMixedIn) {
  Scenery picture;
  for (int y = 0; y < 9; ++y)
    for (int x = 6; x < 12; ++x) picture.stand(x, y);
  picture.hole(2, 5, 3, 6);
  picture.soften();
  EXPECT_EQ(picture.red(5, 2), 52);  // 4 parts of the near one in 19
}

TEST(Outlines, AHoleIsNoNeighbourOfASpeckInAnyUnit) {
  Picture picture(12, 9, kNearColour);
  std::fill(picture.inverse_z.samples.begin(), picture.inverse_z.samples.end(), 50.0F);
  picture.inverse_z.at(6, 4) = 1, picture.colour.at(6, 4) = kFarColour;
  picture.hole(3, 6, 3, 6);
  soften_outlines(3, picture.inverse_z, picture.alpha, {}, picture.colour);
  EXPECT_EQ(picture.colour.at(6, 4), kNearColour);
}

TEST(Outlines, PicturesOfOnePixelAreNoTrouble) {
  for (const auto& [width, height] : {std::pair(1, 1), {1, 3}, {3, 1}}) {
    Picture picture(width, height, kFarColour);
    close_cracks(kLeastStep, picture.inverse_z, picture.colour, picture.alpha);
    soften_outlines(kLeastStep, picture.inverse_z, picture.alpha, {}, picture.colour);
    for (const Rgb& c : picture.colour.samples) EXPECT_EQ(c, kFarColour);
  }
}

// --- layers made ready -----------------------------------------------------------------------------------------------

PreparedLayer prepared(int width, int height, const CodedDepths& depths, uint16_t code, uint8_t step) {
  return {Plane<float>(width, height, depths.w(code)), Plane<Rgba>(width, height, pack({9, 9, 9}, 255)),
          Plane<uint16_t>(width, height, code), Plane<uint8_t>(width, height, step)};
}

void put(PreparedLayer& layer, const CodedDepths& depths, int x, int y, uint16_t code) {
  layer.code.at(x, y) = code;
  layer.w.at(x, y) = depths.w(code);
}

constexpr float kParallax = 0.01F;

TEST(CodedDepths, AreThoseOfTheGrid) {
  const PanoramaGrid grid = test::simple_grid(0.5);
  const CodedDepths depths(grid);
  for (const int code : {0, 1, 1000, kDisparitySteps})
    EXPECT_FLOAT_EQ(depths.w(static_cast<uint16_t>(code)), static_cast<float>(grid.inverse_depth(code)));
  EXPECT_EQ(depths.w(kNoDisparity), kAbsent);
  EXPECT_FLOAT_EQ(depths.step(255), static_cast<float>(0.5 * 255 / kDisparitySteps));
}

TEST(Connected, NeitherWithWhatIsAbsentNorAcrossAJump) {
  EXPECT_TRUE(connected(0.2F, 0, 0.2F, 0, kParallax));
  EXPECT_FALSE(connected(kAbsent, 0, 0.2F, 0, kParallax));
  EXPECT_FALSE(connected(0.2F, 0, kAbsent, 0, kParallax));
  EXPECT_FALSE(connected(0.2F, 0, 0.4F, 0, kParallax));
  EXPECT_TRUE(connected(0.2F, 0.2F, 0.4F, 0.2F, kParallax)) << "codes as coarse as the jump";
  for (const float a : {0.1F, 0.2F, 0.21F, 0.3F})
    for (const float b : {0.1F, 0.19F, 0.22F, 0.3F})
      EXPECT_EQ(connected(a, 0.01F, b, 0.02F, kParallax), connected(b, 0.02F, a, 0.01F, kParallax));
}

TEST(CodeSmoother, TakesStepsOutWithoutLeavingWhatCodesMean) {
  const CodedDepths depths(test::simple_grid(0.5));
  constexpr uint8_t kStep = 150;
  PreparedLayer layer = prepared(60, 20, depths, 1000, kStep);
  for (int y = 0; y < 20; ++y)
    for (int x = 0; x < 60; ++x) put(layer, depths, x, y, static_cast<uint16_t>(1000 + (x / 15) * kStep));
  const PreparedLayer before = layer;
  smooth_codes(layer, depths, kParallax);
  float before_most = 0, most = 0;
  for (int y = 0; y < 20; ++y)
    for (int x = 0; x < 60; ++x) {
      EXPECT_LE(std::abs(layer.w.at(x, y) - before.w.at(x, y)), 0.501F * depths.step(kStep));
      if (x == 0) continue;
      before_most = std::max(before_most, std::abs(before.w.at(x, y) - before.w.at(x - 1, y)));
      most = std::max(most, std::abs(layer.w.at(x, y) - layer.w.at(x - 1, y)));
    }
  EXPECT_LT(most, 0.5F * before_most);
  EXPECT_EQ(layer.code, before.code);
  EXPECT_EQ(layer.colour, before.colour);
}

TEST(CodeSmoother, MovesASpikeByHalfACodeAtMostEitherWay) {
  const CodedDepths depths(test::simple_grid(0.5));
  constexpr uint8_t kStep = 100;
  for (const int spike : {-1, 1}) {
    PreparedLayer layer = prepared(9, 9, depths, 2000, kStep);
    put(layer, depths, 4, 4, static_cast<uint16_t>(2000 + spike * kStep));
    const float before = layer.w.at(4, 4);
    smooth_codes(layer, depths, kParallax);
    EXPECT_NEAR((before - layer.w.at(4, 4)) * static_cast<float>(spike), 0.5F * depths.step(kStep), 1e-6F);
  }
}

TEST(CodeSmoother, LeavesFineCodesJumpsAndWhatIsAbsent) {
  const CodedDepths depths(test::simple_grid(0.5));
  PreparedLayer fine = prepared(20, 20, depths, 1000, 1);
  put(fine, depths, 7, 7, 1001);
  const Plane<float> as_it_was = fine.w;
  smooth_codes(fine, depths, kParallax);
  EXPECT_EQ(fine.w, as_it_was);
  PreparedLayer jump = prepared(20, 20, depths, 500, 100);
  for (int y = 0; y < 20; ++y)
    for (int x = 10; x < 20; ++x) put(jump, depths, x, y, 3500);
  put(jump, depths, 3, 3, kNoDisparity);
  const Plane<float> two_surfaces = jump.w;
  smooth_codes(jump, depths, kParallax);
  for (size_t i = 0; i < jump.w.samples.size(); ++i)
    EXPECT_NEAR(jump.w.samples[i], two_surfaces.samples[i], 1e-6) << "one side drew the other";
}

TEST(Underlay, GoesOnUnderneathByItsReachOnlyAndAtTheFarSurfacesDepth) {
  const CodedDepths depths(test::simple_grid(0.5));
  PreparedLayer layer = prepared(120, 3, depths, 500, 1);
  for (int y = 0; y < 3; ++y)
    for (int x = 60; x < 120; ++x) put(layer, depths, x, y, 3500), layer.colour.at(x, y) = pack({200, 0, 0}, 255);
  const PreparedLayer underlay = make_underlay({layer}, depths, kParallax);
  for (int x = 0; x < 120; ++x) {
    const bool under = x >= 60 && x < 60 + kReachPx;
    EXPECT_EQ(underlay.w.at(x, 1) >= 0, under) << x;
    if (!under) continue;
    EXPECT_FLOAT_EQ(underlay.w.at(x, 1), depths.w(500));
    EXPECT_EQ(underlay.colour.at(x, 1), pack({9, 9, 9}, 255));
  }
}

TEST(Underlay, OfOneSurfaceIsNothing) {
  const CodedDepths depths(test::simple_grid(0.5));
  const PreparedLayer flat = prepared(50, 5, depths, 500, 1);
  for (const float w : make_underlay({flat}, depths, kParallax).w.samples) EXPECT_EQ(w, kAbsent);
}

// --- torn quads ------------------------------------------------------------------------------------------------------

TEST(TornQuads, ComeBackByTheirIndicesSortedByCellAndSoftOnesLast) {
  std::mt19937 random(3);
  std::vector<TornQuad> quads;
  for (int i = 0; i < 400; ++i) {
    const auto x = static_cast<uint8_t>(random() % kTilePx), y = static_cast<uint8_t>(random() % kTilePx);
    const auto alpha = static_cast<uint8_t>(random() % 3 == 0 ? 100 : 255);
    const float w = static_cast<float>(random() % 3);
    TornQuad quad;
    for (int k = 0; k < 4; ++k)
      quad.corners[k] = {static_cast<uint8_t>(x + k % 2), static_cast<uint8_t>(y + k / 2), w, pack({1, 2, 3}, alpha)};
    quads.push_back(quad);
  }
  MeshTile tile;
  store_torn(quads, tile);
  ASSERT_EQ(tile.torn.size(), quads.size());
  const auto corner = [&](size_t quad, int k) { return tile.torn_vertices[tile.torn[quad].corner[k]]; };
  std::vector<bool> found(quads.size(), false);
  size_t begin = 0;
  for (int group = 0; group < 2 * kCells; ++group) {
    for (size_t i = begin; i < tile.torn_end[group]; ++i) {
      EXPECT_EQ(cell_of(corner(i, 0).x_in_tile, corner(i, 0).y_in_tile), group % kCells);
      EXPECT_EQ(alpha_of(corner(i, 0).colour) != 255, group >= kCells);
      for (size_t q = 0; q < quads.size(); ++q) {
        bool same = !found[q];
        for (int k = 0; same && k < 4; ++k) same = corner(i, k) == quads[q].corners[k];
        if (same) {
          found[q] = true;
          break;
        }
      }
    }
    begin = tile.torn_end[group];
  }
  EXPECT_EQ(std::count(found.begin(), found.end(), false), 0);
  EXPECT_LT(tile.torn_vertices.size(), 4 * quads.size()) << "corners of one group are shared";
}

// --- occlusion -------------------------------------------------------------------------------------------------------

CellBounds nowhere() {
  CellBounds bounds{};
  for (int i = 0; i < kCells; ++i) bounds.x0[i] = 0, bounds.x1[i] = -1, bounds.y0[i] = 0, bounds.y1[i] = 0;
  return bounds;
}

TEST(Occlusion, HidesNoCellThatAnyPixelWouldShow) {
  std::mt19937 random(8);
  const auto part = [&](int most) { return static_cast<float>(random() % static_cast<unsigned>(most * 10)) / 10; };
  int hidden = 0;
  for (int round = 0; round < 300; ++round) {
    StripTarget target;
    const int x0 = 200 * static_cast<int>(random() % 2), width = 1 + static_cast<int>(random() % 30),
              height = 1 + static_cast<int>(random() % 20);
    target.clear(x0, width, height);
    for (int y = 0; y < height; ++y)
      for (int x = x0; x < x0 + width; ++x) target.opaque[target.pixel(x, y)].inverse_z = 0.3F + part(1) / 10;
    CellBounds bounds = nowhere();
    for (int i = 0; i < kCells; ++i) {
      bounds.x0[i] = static_cast<float>(x0) + part(40) - 5, bounds.x1[i] = bounds.x0[i] + part(8);
      bounds.y0[i] = part(30) - 5, bounds.y1[i] = bounds.y0[i] + part(8);
      bounds.nearest[i] = 0.25F + part(2) / 10;
    }
    const uint32_t visible = Occlusion(target).visible_cells(bounds);
    for (int i = 0; i < kCells; ++i) {
      bool shows = false;
      for (int y = 0; y < height; ++y)
        for (int x = x0; x < x0 + width; ++x) {
          const auto fx = static_cast<float>(x), fy = static_cast<float>(y);
          const bool inside = fx >= bounds.x0[i] && fx <= bounds.x1[i] && fy >= bounds.y0[i] && fy <= bounds.y1[i];
          shows = shows || (inside && target.opaque[target.pixel(x, y)].inverse_z < bounds.nearest[i]);
        }
      const bool kept = (visible >> i & 1) != 0;
      EXPECT_TRUE(kept || !shows) << "round " << round << ", cell " << i;
      hidden += kept ? 0 : 1;
    }
  }
  EXPECT_GT(hidden, 500) << "it hides next to nothing";
}

TEST(Occlusion, BehindAWallNothingShowsAndBeforeItEverything) {
  StripTarget target;
  target.clear(0, 33, 17);
  for (Fragment& f : target.opaque) f.inverse_z = 0.5F;
  CellBounds bounds = nowhere();
  bounds.x0[0] = bounds.x0[1] = 2, bounds.x1[0] = bounds.x1[1] = 32, bounds.y1[0] = bounds.y1[1] = 16;
  bounds.nearest[0] = 0.49F;
  bounds.nearest[1] = 0.51F;
  EXPECT_EQ(Occlusion(target).visible_cells(bounds), 2U);
  target.opaque[target.pixel(32, 16)].inverse_z = kNothing;
  EXPECT_EQ(Occlusion(target).visible_cells(bounds), 3U) << "through a gap of one pixel in the corner";
}

// --- what a camera sees ----------------------------------------------------------------------------------------------

TEST(ViewFrustum, SeesEveryTileThatHasACornerInItsPicture) {
  const PanoramaGrid grid = test::simple_grid(0.5);
  std::mt19937 random(12);
  int unseen = 0;
  for (int round = 0; round < 60; ++round) {
    Camera camera = test::camera_at(-0.6 + 1.2 * static_cast<double>(random() % 100) / 100);
    camera.intrinsics.fx = camera.intrinsics.fy = 100 + static_cast<double>(random() % 300);
    const ViewFrustum frustum(grid, 0, grid.height, camera);
    const Window window = frustum.window(0, camera.intrinsics.width);
    MeshTile tile;
    tile.x0 = static_cast<int>(random() % 60), tile.y0 = static_cast<int>(random() % 20);
    tile.w_min = 0.05F, tile.w_max = 0.4F;
    bool shows = false;
    for (int y = tile.y0; y <= tile.y0 + kTilePx; y += 4)
      for (int x = tile.x0; x <= tile.x0 + kTilePx; x += 4)
        for (const double w : {0.05, 0.4}) {
          const Eigen::Vector3d point = grid.point(grid.theta(x), grid.v(y), w);
          const Eigen::Vector3d in_camera = camera.pose.world_from_camera.transpose() * (point - camera.pose.centre);
          if (in_camera.z() <= 0) continue;
          const Eigen::Vector2d at = project(camera.intrinsics, in_camera);
          shows = shows ||
                  (at.x() >= 0 && at.x() < camera.intrinsics.width && at.y() >= 0 && at.y() < camera.intrinsics.height);
        }
    const bool seen = frustum.sees(tile, window);
    EXPECT_TRUE(seen || !shows) << round;
    unseen += seen ? 0 : 1;
  }
  EXPECT_GT(unseen, 2);
}

}  // namespace
}  // namespace ldp::view
