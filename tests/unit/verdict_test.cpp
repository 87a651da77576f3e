// The verdict: what photographs alone tell, the panorama seen by its cameras, reasons with their places, the figures of
// a file.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/verdict/colour_quality.h"
#include "core/verdict/expectation.h"
#include "core/verdict/judge.h"
#include "core/verdict/photo_measures.h"
#include "core/verdict/rephotography.h"
#include "core/verdict/track_flow.h"
#include "core/verdict/words.h"

namespace ldp {
namespace {

using testing::HasSubstr;

RgbImage checks(int width, int height, int side) {
  RgbImage image(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const uint8_t grey = (x / side + y / side) % 2 == 0 ? 60 : 200;
      image.at(x, y) = {grey, grey, grey};
    }
  return image;
}

RgbImage smeared(const RgbImage& image, int length) {
  RgbImage result = image;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      int sum = 0;
      for (int i = 0; i < length; ++i) sum += image.at(std::min(image.width - 1, x + i), y).r;
      const auto grey = static_cast<uint8_t>(sum / length);
      result.at(x, y) = {grey, grey, grey};
    }
  return result;
}

TEST(PhotoMeasures, ASmearIsToldOnItsAxisAlone) {
  const RgbImage sharp = checks(160, 120, 12);
  const PhotoMeasures before = measure(sharp), after = measure(smeared(sharp, 8));
  EXPECT_GT(after.blur_x, before.blur_x + 0.2);
  EXPECT_NEAR(after.blur_y, before.blur_y, 0.1);
  EXPECT_LT(after.detail, before.detail);
}

TEST(PhotoMeasures, BrightnessIsTheMeanGrey) {
  const RgbImage grey(64, 48, {90, 90, 90});
  EXPECT_NEAR(measure(grey).brightness, 90, 0.5);
  EXPECT_EQ(measure(RgbImage(8, 8)).brightness, 0) << "too small to be measured";
}

Plane<uint8_t> random_greys(int width, int height) {
  Plane<uint8_t> greys(width, height);
  uint32_t state = 1;
  for (uint8_t& grey : greys.samples)
    grey = static_cast<uint8_t>(30 + ((state = state * 1664525U + 1013904223U) >> 24) * 3 / 4);
  return greys;
}

// Sums of twelve even distributions; of a deviation of 256 / `scale` levels.
RgbImage noisy(int scale) {
  RgbImage image(256, 192);
  uint32_t state = 1;
  for (Rgb& p : image.samples) {
    int sum = 0;
    for (int i = 0; i < 12; ++i) sum += static_cast<int>((state = state * 1664525U + 1013904223U) >> 24);
    const auto grey = static_cast<uint8_t>((120 * scale + sum - 12 * 127) / scale);
    p = {grey, grey, grey};
  }
  return image;
}

TEST(PhotoMeasures, NoiseIsMeasuredWhereItIsPlain) {
  const double some = measure(noisy(64)).noise, twice = measure(noisy(32)).noise;
  EXPECT_NEAR(some, 4, 0.6);
  EXPECT_NEAR(twice / some, 2, 0.1);
}

// Leaves: patches of three pixels of any grey, all over the picture but for a strip of sky.
TEST(PhotoMeasures, FoliageIsNoNoise) {
  RgbImage leaves(256, 192);
  const RgbImage sky = noisy(256);
  const Plane<uint8_t> greys = random_greys(86, 64);
  for (int y = 0; y < leaves.height; ++y)
    for (int x = 0; x < leaves.width; ++x) {
      const uint8_t grey = greys.at(x / 3, y / 3);
      leaves.at(x, y) = y < 10 ? sky.at(x, y) : Rgb{grey, grey, grey};
    }
  EXPECT_NEAR(measure(leaves).noise, 1, 0.5) << "of the sky";
}

// A sweep without faults: fourteen photos, 12 degrees apart, 58 degrees wide, rendered back at 28 dB.
SweepEvidence clean_sweep() {
  SweepEvidence evidence;
  evidence.photos_taken = 14;
  evidence.field_deg = 58;
  evidence.reprojection = 0.0005;
  evidence.first_deg = -30;
  for (int i = 0; i < 14; ++i) {
    PhotoEvidence photo;
    photo.heading_deg = 12 * i;
    if (i > 0) photo.turn_deg = 12, photo.step = 0.15, photo.forward = 0.01;
    photo.measures = {125, 0.24, 0.23, 0.9, 13};
    photo.shared_points = 300;
    photo.shift = photo.far_shift = i == 0 ? 0 : 12.0 / 58;
    photo.outward = 0.1, photo.sideward = 3, photo.parallax_squares = 0.03, photo.parallax_points = 300;
    photo.directions.resize(15);
    for (size_t d = 0; d < 15; ++d) {
      if (std::abs(-30 + 15 * static_cast<double>(d) + 7.5 - 12 * i) > 29) continue;
      DirectionEvidence& part = photo.directions[d];
      part.pixels = part.compared = 10000;
      part.unexplained = 50;
      part.back = {103 * 30000, 30000};
      part.neighbour = {130 * 7500, 7500};
    }
    evidence.photos.push_back(photo);
  }
  return evidence;
}

std::vector<QualityReason> reasons(const SweepQuality& quality) {
  std::vector<QualityReason> all;
  for (const QualityFinding& finding : quality.reasons) all.push_back(finding.reason);
  return all;
}

TEST(Judge, ACleanSweepIsGoodAndHasNoReasons) {
  const SweepQuality quality = judge(clean_sweep());
  EXPECT_EQ(quality.grade, Grade::good);
  EXPECT_TRUE(quality.reasons.empty());
  EXPECT_NEAR(quality.photos_back_psnr_db, 28, 0.05);
  EXPECT_NEAR(quality.expected_view_psnr_db, 25.5, 2);
  EXPECT_NEAR(quality.unexplained_share, 0.005, 1e-9);
  ASSERT_GE(quality.by_direction.size(), 12U);
  for (const DirectionQuality& direction : quality.by_direction) {
    EXPECT_EQ(direction.grade, Grade::good);
    EXPECT_EQ(direction.to_deg - direction.from_deg, kDirection_deg);
  }
}

TEST(Judge, BlurIsToldWhereItIs) {
  SweepEvidence evidence = clean_sweep();
  for (const size_t i : {4U, 5U}) evidence.photos[i].measures.blur_x = 0.45;
  const SweepQuality quality = judge(evidence);
  EXPECT_EQ(quality.grade, Grade::fair);
  ASSERT_EQ(reasons(quality), std::vector{QualityReason::blurred});
  EXPECT_EQ(quality.reasons[0].from_deg, 42);
  EXPECT_EQ(quality.reasons[0].to_deg, 66);
  EXPECT_EQ(text_of(quality.reasons[0]), "the photos between 42 and 66 degrees are blurred: turn more slowly there");
  for (const DirectionQuality& direction : quality.by_direction) {
    const bool there = direction.from_deg < 66 && direction.to_deg > 42;
    EXPECT_EQ(direction.grade, there ? Grade::fair : Grade::good) << direction.from_deg;
  }
}

// Two rows of photos, each all the way round, the second one on from where the first ended.
TEST(Judge, PlacesOfASecondRoundAreThoseOfTheTurn) {
  SweepEvidence clean = clean_sweep();
  const PhotoEvidence usual = clean.photos[5];
  clean.first_deg = 0;
  clean.photos_taken = 60;
  clean.photos.assign(60, usual);
  for (size_t i = 0; i < 60; ++i) {
    PhotoEvidence& photo = clean.photos[i];
    photo.heading_deg = 12 * static_cast<double>(i);
    photo.directions.assign(kFullTurn, DirectionEvidence{});
    const auto there = static_cast<size_t>(photo.heading_deg / kDirection_deg);
    for (const size_t beside : {0U, 1U, 2U})
      photo.directions[(there + beside + kFullTurn - 1) % kFullTurn] = usual.directions[6];
  }
  ASSERT_TRUE(judge(clean).reasons.empty());
  const auto blurred = [&clean](size_t first, size_t last) {
    SweepEvidence evidence = clean;
    for (size_t i = first; i <= last; ++i) evidence.photos[i].measures.blur_x = 0.45;
    return judge(evidence);
  };
  const auto fair = [](const SweepQuality& quality, double from_deg) {
    return quality.by_direction[static_cast<size_t>(from_deg / kDirection_deg)].grade == Grade::fair;
  };
  const SweepQuality second = blurred(33, 34);
  ASSERT_EQ(second.reasons.size(), 1U);
  EXPECT_EQ(second.reasons[0], (QualityFinding{QualityReason::blurred, 30, 54}));
  EXPECT_TRUE(fair(second, 30) && fair(second, 45));
  EXPECT_FALSE(fair(second, 15) || fair(second, 60) || fair(second, 0));
  const SweepQuality across = blurred(29, 30);
  EXPECT_EQ(across.reasons[0], (QualityFinding{QualityReason::blurred, 342, 366}));
  EXPECT_TRUE(fair(across, 330) && fair(across, 345) && fair(across, 0));
  EXPECT_FALSE(fair(across, 15) || fair(across, 315));
  EXPECT_EQ(blurred(0, 59).reasons[0], (QualityFinding{QualityReason::blurred, 0, 360}));
}

TEST(Judge, WhatPosesAndPhotosTellIsKnownBeforeThereIsAPanorama) {
  SweepEvidence evidence = clean_sweep();
  for (PhotoEvidence& photo : evidence.photos) photo.directions.clear();
  EXPECT_EQ(text_of(judge_sweep(evidence)), "good");
  evidence.motion = SweepMotion::rotation;
  for (const size_t i : {4U, 5U}) evidence.photos[i].measures.blur_x = 0.45;
  const SweepQuality quality = judge_sweep(evidence);
  EXPECT_EQ(reasons(quality), reasons(judge(evidence)));
  EXPECT_EQ(quality.grade, Grade::fair);
  EXPECT_TRUE(quality.by_direction.empty());
  EXPECT_THAT(text_of(quality), testing::StartsWith("fair: the "));
  EXPECT_EQ(judge_sweep({}).grade, Grade::good);
}

TEST(Judge, OneReasonInTwoPlacesIsToldOnce) {
  SweepQuality quality;
  quality.reasons = {{QualityReason::blurred, 50, 60}, {QualityReason::dark, 30, 40}, {QualityReason::blurred, 10, 20}};
  EXPECT_EQ(text_of(quality),
            "good: the photos between 10 and 20 degrees and between 50 and 60 degrees are "
            "blurred: turn more slowly there; the photos between 30 and 40 degrees are dark and noisy: take them in "
            "more light, or turn more slowly at a longer exposure");
}

TEST(Judge, PlacesOfOneReasonThatTouchOrHoldEachOtherAreTheNarrowestOnes) {
  SweepQuality quality;
  const auto places = [&](const std::vector<std::pair<double, double>>& of) {
    quality.reasons.clear();
    for (const auto& [from, to] : of) quality.reasons.push_back({QualityReason::blurred, from, to});
    const std::string text = text_of(quality);
    const std::string before = "good: the photos ", behind = " are blurred: turn more slowly there";
    EXPECT_THAT(text, testing::AllOf(testing::StartsWith(before), testing::EndsWith(behind)));
    return text.substr(before.size(), text.size() - before.size() - behind.size());
  };
  EXPECT_EQ(places({{187, 342}, {343, 377}, {0, 360}}), "between 187 and 17 degrees");
  EXPECT_EQ(places({{343, 377}, {0, 360}}), "between 343 and 17 degrees");
  EXPECT_EQ(places({{10, 200}, {199, 371}}), "between 0 and 360 degrees");
  EXPECT_EQ(places({{0, 15}, {100, 120}, {343, 361}}), "between 100 and 120 degrees and between 343 and 15 degrees");
  EXPECT_EQ(places({{5, 15}, {350, 380}}), "between 5 and 15 degrees");
  EXPECT_EQ(places({{400, 450}}), "between 40 and 90 degrees");
  EXPECT_EQ(places({{-10, 20}}), "between -10 and 20 degrees");
  EXPECT_EQ(places({{10, 30}, {20, 40}, {42, 60}}), "between 10 and 40 degrees and between 42 and 60 degrees");
  EXPECT_EQ(places({{0, 360}}), "between 0 and 360 degrees");
}

TEST(Judge, OfWhoSweepsToAndFroEveryPlaceIsTold) {
  SweepEvidence evidence = clean_sweep();
  for (int i = 0; i < 14; ++i) evidence.photos[static_cast<size_t>(i)].heading_deg = 10 * std::min(i, 13 - i);
  for (const size_t i : {8U, 9U}) evidence.photos[i].measures.blur_x = 0.45;
  evidence.motion = SweepMotion::rotation;
  const SweepQuality quality = judge(evidence);
  const auto of = [&](QualityReason reason) {
    return *std::find_if(quality.reasons.begin(), quality.reasons.end(),
                         [&](const QualityFinding& finding) { return finding.reason == reason; });
  };
  EXPECT_EQ(of(QualityReason::blurred), (QualityFinding{QualityReason::blurred, 35, 55}));
  EXPECT_EQ(of(QualityReason::no_parallax), (QualityFinding{QualityReason::no_parallax, 0, 60}));
}

TEST(Judge, WhatMostPhotosHaveIsToldOnceForTheWholeSweep) {
  SweepEvidence evidence = clean_sweep();
  for (size_t i = 0; i < 8; ++i) evidence.photos[i].measures.blur_x = 0.45;
  const SweepQuality quality = judge(evidence);
  ASSERT_EQ(reasons(quality), std::vector{QualityReason::blurred});
  EXPECT_EQ(quality.reasons[0].from_deg, 0);
  EXPECT_EQ(quality.reasons[0].to_deg, 156);
  evidence.photos[7].measures.blur_x = 0.24;  // half of them are not most
  ASSERT_EQ(reasons(judge(evidence)), std::vector{QualityReason::blurred});
  EXPECT_EQ(judge(evidence).reasons[0].to_deg, 78);
}

TEST(Judge, EveryFaultHasItsReason) {
  const auto of = [](auto spoil) {
    SweepEvidence evidence = clean_sweep();
    spoil(evidence);
    return reasons(judge(evidence));
  };
  using Reasons = std::vector<QualityReason>;
  EXPECT_EQ(of([](SweepEvidence& e) {
              for (auto& p : e.photos) p.measures.brightness = 40, p.measures.noise = 4;
            }),
            Reasons{QualityReason::dark});
  EXPECT_EQ(of([](SweepEvidence& e) { e.motion = SweepMotion::rotation; }), Reasons{QualityReason::no_parallax});
  EXPECT_EQ(of([](SweepEvidence& e) {
              for (auto& p : e.photos) p.parallax_squares = 1e-4;
            }),
            Reasons{QualityReason::no_parallax});
  EXPECT_EQ(of([](SweepEvidence& e) {
              for (auto& p : e.photos) p.outward = 2.5, p.forward = 0.9 * p.step;
            }),
            Reasons{QualityReason::moved_forward});
  EXPECT_EQ(of([](SweepEvidence& e) { e.motion = SweepMotion::straight; }), Reasons{QualityReason::moved_straight});
  EXPECT_EQ(of([](SweepEvidence& e) { e.motion = SweepMotion::straight, e.inward = 0.9; }),
            Reasons{QualityReason::looked_inward});
  EXPECT_EQ(of([](SweepEvidence& e) { e.reprojection = 0.002; }), Reasons{QualityReason::lens_doubtful});
  EXPECT_EQ(of([](SweepEvidence& e) { e.agreement = 0.95; }), Reasons{QualityReason::contradicted});
  EXPECT_EQ(of([](SweepEvidence& e) { e.agreement = 0.966; }), Reasons{});
  EXPECT_EQ(of([](SweepEvidence& e) { e.photos_taken = 22; }), Reasons{QualityReason::photos_left_out});
  EXPECT_EQ(of([](SweepEvidence& e) { e.photos[7].gain = 3; }), Reasons{QualityReason::exposure_jumps});
  EXPECT_EQ(of([](SweepEvidence& e) { e.doubt = DoubtfulPoses::contradicted; }),
            Reasons{QualityReason::poses_doubtful});
  EXPECT_EQ(of([](SweepEvidence& e) { e.doubt = DoubtfulPoses::loose; }), Reasons{QualityReason::little_overlap});
  EXPECT_EQ(of([](SweepEvidence& e) { e.doubt = DoubtfulPoses::lens; }), Reasons{QualityReason::lens_doubtful});
  EXPECT_EQ(of([](SweepEvidence& e) {
              for (auto& p : e.photos)
                for (auto& d : p.directions) d.unexplained *= 16;
            }),
            Reasons{QualityReason::contradicted});
  EXPECT_EQ(of([](SweepEvidence& e) {
              for (auto& p : e.photos)
                for (auto& d : p.directions) d.holes = d.pixels / 10;
            }),
            Reasons{QualityReason::holes});
}

TEST(Judge, DoubtfulPosesWhosePhotosContradictThePanoramaAskForAnotherSweep) {
  SweepEvidence evidence = clean_sweep();
  const auto contradict = [&] {
    for (PhotoEvidence& photo : evidence.photos)
      for (DirectionEvidence& part : photo.directions) part.unexplained = part.compared / 10;
  };
  evidence.doubt = DoubtfulPoses::contradicted;
  EXPECT_EQ(judge(evidence).grade, Grade::fair);
  contradict();
  EXPECT_EQ(judge(evidence).grade, Grade::sweep_again);
  EXPECT_EQ(judge(evidence).reasons.front().reason, QualityReason::poses_doubtful);
  evidence.doubt = DoubtfulPoses::no;
  EXPECT_EQ(judge(evidence).grade, Grade::fair);
}

TEST(Judge, FineLinesAlongOneAxisAreNoBlurAlongTheOther) {
  SweepEvidence evidence = clean_sweep();
  for (PhotoEvidence& photo : evidence.photos) photo.measures.blur_x = 0.3, photo.measures.blur_y = 0.15;
  EXPECT_EQ(judge(evidence).grade, Grade::good);
  for (PhotoEvidence& photo : evidence.photos) photo.measures.blur_x = 0.35;
  EXPECT_EQ(reasons(judge(evidence)), std::vector{QualityReason::blurred});
}

TEST(Judge, FoliageInMostPhotosIsNoNoise) {
  SweepEvidence evidence = clean_sweep();
  for (size_t i = 0; i < 10; ++i) evidence.photos[i].measures.noise = 5;
  EXPECT_EQ(judge(evidence).grade, Grade::good);
  for (auto& photo : evidence.photos) photo.measures.noise = 5;
  EXPECT_EQ(reasons(judge(evidence)), std::vector{QualityReason::dark});
}

TEST(Judge, AStepAsideThatIsAlsoForwardIsNoWalk) {
  SweepEvidence evidence = clean_sweep();
  for (auto& photo : evidence.photos) photo.outward = 2, photo.forward = 0.3 * photo.step;
  EXPECT_EQ(judge(evidence).grade, Grade::good);
  evidence.doubt = DoubtfulPoses::contradicted;
  EXPECT_THAT(reasons(judge(evidence)), testing::Contains(QualityReason::moved_forward)) << "its poses do not count";
}

TEST(Judge, StepsThatAreWideThroughoutAreToldOnceSingleOnesAreNot) {
  const auto with = [](int wide) {
    SweepEvidence evidence = clean_sweep();
    for (int i = 1; i <= wide; ++i) evidence.photos[static_cast<size_t>(i)].shift = 0.42;
    return evidence;
  };
  EXPECT_TRUE(judge(with(5)).reasons.empty());
  SweepEvidence all = with(13);
  const std::vector<QualityFinding> throughout{{QualityReason::little_overlap, 0, 12 * 13}};
  EXPECT_EQ(judge(all).reasons, throughout);
  all.photos[4].shift = 0.5;
  EXPECT_EQ(judge(all).reasons, throughout);
  EXPECT_EQ(judge(all).grade, Grade::fair);
}

TEST(Judge, StepsToAndFroAreNoWalk) {
  SweepEvidence evidence = clean_sweep();
  for (size_t i = 1; i < evidence.photos.size(); ++i) {
    PhotoEvidence& photo = evidence.photos[i];
    photo.outward = 2.5, photo.forward = (i % 2 == 0 ? 0.9 : -0.9) * photo.step;
  }
  EXPECT_EQ(judge(evidence).grade, Grade::good);
  for (PhotoEvidence& photo : evidence.photos) photo.forward = -0.9 * photo.step;
  EXPECT_EQ(reasons(judge(evidence)), std::vector{QualityReason::moved_forward}) << "backward is one";
}

TEST(Judge, PosesThatTurnOtherwiseThanThePhotosShiftAreDoubtful) {
  SweepEvidence evidence = clean_sweep();
  for (PhotoEvidence& photo : evidence.photos) photo.turn_deg *= 0.4;
  const SweepQuality quality = judge(evidence);
  EXPECT_EQ(quality.grade, Grade::sweep_again);
  EXPECT_EQ(reasons(quality).front(), QualityReason::poses_doubtful);
}

TEST(Judge, WorseEvidenceNeverRaisesTheExpectation) {
  const double clean = expected_view_psnr(features_of(clean_sweep()));
  const auto with = [](auto spoil) {
    SweepEvidence evidence = clean_sweep();
    spoil(evidence);
    return expected_view_psnr(features_of(evidence));
  };
  EXPECT_LT(with([](SweepEvidence& e) {
              for (auto& p : e.photos) p.measures.blur_x = 0.5;
            }),
            clean - 1);
  EXPECT_LT(with([](SweepEvidence& e) {
              e.motion = SweepMotion::rotation;
              for (auto& p : e.photos) p.parallax_points = 0;
            }),
            clean - 3);
  EXPECT_LT(with([](SweepEvidence& e) {
              for (auto& p : e.photos) p.shift = p.far_shift = 0.5, p.turn_deg *= 2.4;
            }),
            clean - 1);
  EXPECT_LT(with([](SweepEvidence& e) { e.doubt = DoubtfulPoses::loose; }), clean - 0.3);
  EXPECT_LT(with([](SweepEvidence& e) {
              for (auto& p : e.photos)
                for (auto& d : p.directions) d.back.sum *= 4;
            }),
            clean - 0.3);
  EXPECT_LT(with([](SweepEvidence& e) {
              for (auto& p : e.photos)
                for (auto& d : p.directions) d.back.sum *= 4, d.neighbour.sum *= 4;
            }),
            clean - 3);
}

TEST(Judge, AJumpOfExposureIsAgainstThePhotoBefore) {
  SweepEvidence evidence;
  evidence.photos.resize(5);
  for (size_t i = 0; i < 5; ++i) evidence.photos[i].gain = std::array{1.0, 4.0, 2.0, 2.0, 0.0}[i];
  const std::array<double, 5> jumps = {0, 2, 1, 0, 0};
  for (size_t i = 0; i < 5; ++i) EXPECT_NEAR(exposure_jump(evidence, i), jumps[i], 1e-9) << i;
}

TEST(Judge, NoPhotosGiveNoReasons) { EXPECT_EQ(judge(SweepEvidence{}), SweepQuality{}); }

TEST(SweepQuality, FiguresOfAFileGiveItBack) {
  SweepEvidence evidence = clean_sweep();
  evidence.photos_taken = 22;
  evidence.photos[4].measures.blur_x = 0.6;
  const SweepQuality quality = judge(evidence);
  std::map<std::string, double> figures = figures_of(quality);
  EXPECT_EQ(quality_from(figures), quality);
  figures["psnr_leave_one_out_db"] = 24;
  EXPECT_EQ(quality_from(figures), quality) << "other figures stand beside them";
  for (const auto& [name, value] : figures_of(quality)) EXPECT_TRUE(is_of_verdict(name)) << name;
  EXPECT_FALSE(is_of_verdict("psnr_leave_one_out_db"));
}

TEST(SweepQuality, FiguresThatItCannotHaveAreNone) {
  const std::map<std::string, double> sound = figures_of(judge(clean_sweep()));
  EXPECT_FALSE(quality_from({}));
  for (const double wrong : {-1.0, 3.0, 0.5, std::numeric_limits<double>::quiet_NaN()}) {
    std::map<std::string, double> figures = sound;
    figures["verdict"] = wrong;
    EXPECT_FALSE(quality_from(figures)) << wrong;
  }
  std::map<std::string, double> figures = sound;
  figures.erase("direction.03.to_deg");
  EXPECT_FALSE(quality_from(figures));
}

TEST(Words, EveryReasonHasACodeOfItsOwnAndSaysWhatToDo) {
  std::vector<std::string> codes;
  for (int i = 0; i < kQualityReasons; ++i) {
    const QualityFinding finding{static_cast<QualityReason>(i), 10, 20};
    codes.emplace_back(code_of(finding.reason));
    EXPECT_THAT(text_of(finding), HasSubstr(": "));
    EXPECT_THAT(text_of(finding), testing::Not(HasSubstr("%")));
  }
  std::sort(codes.begin(), codes.end());
  EXPECT_EQ(std::unique(codes.begin(), codes.end()), codes.end());
}

TEST(Words, OnePlaceIsNoRange) {
  EXPECT_THAT(text_of({QualityReason::blurred, -2.2, -1.9}), HasSubstr("the photos near -2 degrees are"));
}

Camera outward_camera(double theta) {
  Camera camera;
  camera.intrinsics = {80, 60, 100, 100, 40, 30};
  const Eigen::Vector3d forward(std::cos(theta), std::sin(theta), 0), down(0, 0, -1);
  camera.pose.world_from_camera << down.cross(forward), down, forward;
  camera.pose.centre = 0.6 * forward;
  return camera;
}

// What two cameras that stand side by side take of a wall of `depth`, and what a panorama shows instead.
struct TwoPhotos {
  std::vector<Camera> cameras{outward_camera(0), outward_camera(0)};
  consistency::Held held[2];
  consistency::Rendering shown[2];
  SweepEvidence evidence;

  explicit TwoPhotos(double depth) {
    cameras[1].pose.centre += 0.1 * cameras[1].pose.world_from_camera.col(0);
    for (int i = 0; i < 2; ++i) {
      const Intrinsics& k = cameras[0].intrinsics;
      RgbImage photo(k.width, k.height);
      for (int y = 0; y < k.height; ++y)
        for (int x = 0; x < k.width; ++x)  // 0.1 aside at a depth of 2 is 5 pixels
          photo.at(x, y) = {static_cast<uint8_t>((x + 5 * i) / 10 % 2 * 200), 100, 50};
      held[i] = {&cameras[static_cast<size_t>(i)], photo, Plane<float>(k.width, k.height, static_cast<float>(depth))};
      shown[i] = {photo, Plane<uint8_t>(k.width, k.height, 255)};
    }
  }

  // Of all directions and both photos.
  DirectionEvidence compare() {
    PanoramaGrid grid;
    grid.width = 300, grid.height = 120, grid.theta_pitch = grid.v_pitch = 0.01, grid.theta_left = 1.5;
    Job job;
    job.threads = 2;
    Rephotography rephotography(grid, cameras, {{1, 1, 1}, {1, 2, 1}}, job, evidence);
    for (size_t i = 0; i < 2; ++i) {
      rephotography.rendered(i, held[i], shown[i], i == 0 ? nullptr : &held[0]);
    }
    DirectionEvidence all;
    for (const PhotoEvidence& photo : evidence.photos)
      for (const DirectionEvidence& part : photo.directions) all.add(part);
    return all;
  }
};

TEST(Rephotography, WhatIsShownAsItWasTakenHasNoError) {
  TwoPhotos two(2);
  const DirectionEvidence all = two.compare();
  EXPECT_EQ(all.pixels, 2 * 80 * 60);
  EXPECT_EQ(all.compared, all.pixels);
  EXPECT_EQ(all.holes + all.unexplained + all.back.sum, 0);
  EXPECT_EQ(all.back.samples, 3 * all.pixels);
  EXPECT_EQ(all.neighbour.sum, 0) << "each photo shows the wall where the other has it";
  EXPECT_GT(all.neighbour.samples, 3 * all.pixels / 4 * 9 / 10);
  EXPECT_NEAR(two.evidence.field_deg, 43.6, 0.1);
  EXPECT_EQ(two.evidence.photos[1].gain, 2);
}

TEST(Rephotography, CamerasThatTurnOnAndOnTakeNoMoreThanTwoRoundsOfDirections) {
  PanoramaGrid grid;
  grid.width = 100, grid.height = 50;
  std::vector<Camera> cameras(300);
  for (size_t i = 0; i < cameras.size(); ++i) {
    cameras[i].intrinsics = {40, 30, 40, 40, 20, 15, 0, 0, 0, 0};
    cameras[i].pose.world_from_camera =
        Eigen::AngleAxisd(2.0 * static_cast<double>(i), Eigen::Vector3d::UnitZ()).toRotationMatrix() *
        (Eigen::Matrix3d() << 0, 0, 1, -1, 0, 0, 0, -1, 0).finished();
  }
  SweepEvidence evidence;
  const Job job;
  const Rephotography rephotography(grid, cameras, std::vector<Gain>(300, Gain{1, 1, 1}), job, evidence);
  EXPECT_NEAR(evidence.photos[1].heading_deg, 2 * 180 / 3.14159265, 0.01);
  EXPECT_LE(evidence.photos[0].directions.size(), static_cast<size_t>(2 * 360 / kDirection_deg) + 1);
}

TEST(Rephotography, AWrongDepthIsToldByThePhotoBeside) {
  TwoPhotos two(1);
  const DirectionEvidence all = two.compare();
  EXPECT_EQ(all.back.sum, 0);
  EXPECT_GT(psnr_of(all.back) - psnr_of(all.neighbour), 40);
}

TEST(Rephotography, WhatIsNearerInThePhotoBesideIsNotCompared) {
  TwoPhotos two(2);
  for (float& z : two.held[1].depth.samples) z = 1;
  two.compare();
  SquaredError first;
  for (const DirectionEvidence& part : two.evidence.photos[0].directions) first.add(part.neighbour);
  EXPECT_EQ(first.samples, 0);
}

TEST(Rephotography, HolesAreGreyAndOtherColoursUnexplained) {
  TwoPhotos two(2);
  two.shown[0].alpha.at(12, 7) = 0;
  two.held[0].depth.at(12, 7) = 0;
  for (int y = 20; y < 25; ++y)
    for (int x = 27; x < 32; ++x) two.shown[1].colour.at(x, y) = {0, 255, 255};
  const DirectionEvidence all = two.compare();
  EXPECT_EQ(all.holes, 1);
  EXPECT_EQ(all.compared, all.pixels - 1);
  EXPECT_EQ(all.unexplained, 9) << "all but those beside a pixel that explains them";
  EXPECT_GT(all.back.sum, 25 * (155 * 155 + 205 * 205));
}

// Points around a camera, moved by `way` in its axes from photo to photo.
SweepEvidence flow_of(const Eigen::Vector3d& way) {
  std::vector<Camera> cameras;
  for (int i = 0; i < 3; ++i) {
    cameras.push_back(outward_camera(0));
    cameras.back().pose.centre += i * (cameras.back().pose.world_from_camera * way);
  }
  std::vector<ScenePoint> points;
  std::vector<std::vector<Eigen::Vector2d>> sightings;
  for (int i = 0; i < 60; ++i) {
    const double depth = 2 + i % 7;
    const Eigen::Vector3d local((i % 10 - 4.5) / 15 * depth, (i / 10 - 2.5) / 12 * depth, depth);
    ScenePoint point;
    point.position = cameras[0].pose.centre + cameras[0].pose.world_from_camera * local;
    point.cameras = {0, 1, 2};
    sightings.emplace_back();
    for (const Camera& camera : cameras)
      sightings.back().push_back(project(
          camera.intrinsics, camera.pose.world_from_camera.transpose() * (point.position - camera.pose.centre)));
    points.push_back(point);
  }
  SweepEvidence evidence;
  evidence.field_deg = 43;
  evidence.photos.resize(3);
  measure_flow(points, sightings, cameras, evidence);
  return evidence;
}

TEST(TrackFlow, TheShiftIsTheMeanWayOfThePoints) {
  const SweepEvidence aside = flow_of({0.1, 0, 0});
  double mean_inverse_depth = 0;
  for (int i = 0; i < 60; ++i) mean_inverse_depth += 1.0 / (2 + i % 7) / 60;
  const Intrinsics k = outward_camera(0).intrinsics;
  for (size_t i = 1; i < 3; ++i) {
    EXPECT_EQ(aside.photos[i].shared_points, 60);
    EXPECT_NEAR(aside.photos[i].shift, 0.1 * mean_inverse_depth * k.fx / k.width, 1e-9);
  }
  EXPECT_EQ(aside.photos[0].shift, 0);
}

// A step aside shifts what is near much more than a small turn would, and what is far hardly.
TEST(TrackFlow, ThePointsFarthestAwayTellTheTurnsShift) {
  const SweepEvidence aside = flow_of({0.1, 0, 0});
  const Intrinsics k = outward_camera(0).intrinsics;
  for (size_t i = 1; i < 3; ++i) {
    EXPECT_LT(aside.photos[i].far_shift, 0.1 / 7 * k.fx / k.width + 1e-9);
    EXPECT_GT(aside.photos[i].far_shift, 0.1 / 8 * k.fx / k.width - 1e-9);
  }
}

TEST(TrackFlow, AStepForwardPointsOutwardAndAStepAsideDoesNot) {
  const MotionMeasures forward = motion_of(flow_of({0, 0, 0.1})), aside = motion_of(flow_of({0.1, 0, 0}));
  EXPECT_GT(forward.outward, 0.8);
  EXPECT_LT(aside.outward, 0.2);
  EXPECT_GT(aside.parallax, 0.004);
  EXPECT_LT(motion_of(flow_of({0, 0, 0})).parallax, 1e-9);
}

TEST(TrackFlow, StepsAreThoseOfThePoses) {
  const SweepEvidence slanted = flow_of({0.4, 0, 0.3});
  EXPECT_EQ(slanted.photos[0].step, 0);
  EXPECT_NEAR(slanted.photos[1].step, 0.5, 1e-9);
  EXPECT_NEAR(slanted.photos[1].forward, 0.3, 1e-9);
  EXPECT_EQ(slanted.photos[1].turn_deg, 0);
  std::vector<Camera> turned{outward_camera(0), outward_camera(0.5)};
  SweepEvidence evidence;
  evidence.photos.resize(2);
  measure_flow({}, {}, turned, evidence);
  EXPECT_NEAR(evidence.photos[1].turn_deg, 0.5 * 180 / M_PI, 0.01);
}

TEST(TrackFlow, WhoGoesAroundAThingLooksInward) {
  std::vector<Camera> cameras;
  SweepEvidence evidence;
  const auto measured = [&](double from_middle, double step_rad) {
    cameras.clear();
    for (int i = 0; i < 5; ++i) {
      cameras.push_back(outward_camera(step_rad * i));
      cameras.back().pose.centre = from_middle * cameras.back().pose.world_from_camera.col(2);
    }
    evidence.photos.resize(cameras.size());
    measure_flow({}, {}, cameras, evidence);
    return evidence.inward;
  };
  EXPECT_NEAR(measured(-2, 0.2), 1, 1e-9);
  EXPECT_EQ(measured(0.5, 0.2), 0);
  EXPECT_EQ(measured(-2, 0.01), 0) << "a path that hardly turns is a line";
  EXPECT_EQ(measured(0, 0.2), 0);
}

TEST(ColourQuality, GrowsWithWhatIsExplained) {
  EXPECT_EQ(colour_quality_for(0), 90);  // also where nothing is known
  EXPECT_EQ(colour_quality_for(28), 90);
  EXPECT_EQ(colour_quality_for(29.2), 92);
  EXPECT_EQ(colour_quality_for(31), 95);
  EXPECT_EQ(colour_quality_for(99), 95);
}

}  // namespace
}  // namespace ldp
