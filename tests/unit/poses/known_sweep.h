// What tests of poses share: small turns, and scenes whose cameras and points are known.
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "core/poses/adjust/bundle_adjustment.h"
#include "core/poses/pose_doubt.h"
#include "core/poses/tracks/bundle.h"
#include "core/poses/tracks/match_graph.h"
#include "core/poses/tracks/reconstruction.h"

namespace ldp::sfm {

constexpr double kDegree = std::numbers::pi / 180;

inline double uniform(std::mt19937& random, double low, double high) {
  return low + (high - low) * static_cast<double>(random()) / 4294967296.0;
}

inline Eigen::Matrix3d turn(double x_deg, double y_deg, double z_deg) {
  return (Eigen::AngleAxisd(y_deg * kDegree, Eigen::Vector3d::UnitY()) *
          Eigen::AngleAxisd(x_deg * kDegree, Eigen::Vector3d::UnitX()) *
          Eigen::AngleAxisd(z_deg * kDegree, Eigen::Vector3d::UnitZ()))
      .toRotationMatrix();
}

inline double angle_deg(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  return Eigen::AngleAxisd(Eigen::Matrix3d(a.transpose() * b)).angle() / kDegree;
}

inline Bundle true_bundle(MotionModel model) {
  std::mt19937 random(6);
  Bundle bundle;
  bundle.lens = {700, 0.02, -0.01};
  for (int i = 0; i < 8; ++i) {
    const Eigen::Matrix3d r = turn(i % 2, 8.0 * i, 0.5 * (i % 3));
    const double x = uniform(random, -0.03, 0.03), y = uniform(random, -0.03, 0.03);
    bundle.cameras.push_back({r, model == MotionModel::free ? Eigen::Vector3d(r.col(2) + Eigen::Vector3d(x, y, -x))
                                                            : Eigen::Vector3d(r.col(2))});
  }
  for (int i = 0; i < 400; ++i) {
    const double azimuth = uniform(random, -20, 76), elevation = uniform(random, -20, 20),
                 w = uniform(random, 0.05, 0.5);
    bundle.points.push_back({turn(elevation, azimuth, 0).col(2), model == MotionModel::rotation ? 0 : w});
    for (int c = 0; c < 8; ++c) {
      const Projection p = project_point(bundle.cameras[static_cast<size_t>(c)], bundle.lens, bundle.points.back());
      if (p.in_front && p.position_px.cwiseAbs().maxCoeff() < 400) bundle.observations.push_back({c, i, p.position_px});
    }
  }
  return bundle;
}

// Sixteen cameras all round, the last of which sees half of what the first one does (at 700 px).
inline Bundle full_turn_bundle(double focal_px = 700) {
  std::mt19937 random(7);
  Bundle bundle;
  bundle.lens = {focal_px, 0, 0};
  for (int i = 0; i < 16; ++i) {
    const Eigen::Matrix3d r = turn(0, 22.5 * i, 0);
    bundle.cameras.push_back({r, r.col(2)});
  }
  for (int i = 0; i < 1500; ++i) {
    const double azimuth = uniform(random, 0, 360), elevation = uniform(random, -20, 20);
    bundle.points.push_back({turn(elevation, azimuth, 0).col(2), uniform(random, 0.05, 0.2)});
    for (int c = 0; c < 16; ++c) {
      const Projection p = project_point(bundle.cameras[static_cast<size_t>(c)], bundle.lens, bundle.points.back());
      if (p.in_front && p.position_px.cwiseAbs().maxCoeff() < 400) bundle.observations.push_back({c, i, p.position_px});
    }
  }
  return bundle;
}

// A sweep whose features and matches are those of a known bundle.
struct KnownSweep {
  MatchedSweep sweep;
  Reconstruction found;
  std::vector<std::string> names;

  explicit KnownSweep(Bundle bundle = true_bundle(MotionModel::free)) {
    found.bundle = std::move(bundle);
    const size_t frames = found.bundle.cameras.size();
    found.left_out.resize(frames);
    found.tracks.resize(found.bundle.points.size());
    sweep.features.resize(frames);
    for (size_t i = 0; i < frames; ++i) {
      sweep.features[i].width = sweep.features[i].height = 800;
      names.push_back("photo " + std::to_string(i));
    }
    for (const BundleObservation& o : found.bundle.observations) {
      Features& features = sweep.features[static_cast<size_t>(o.camera)];
      features.positions.emplace_back(o.position_px + Eigen::Vector2d(400, 400));
      found.tracks[static_cast<size_t>(o.point)].push_back({o.camera, features.size() - 1, o.position_px});
    }
    for (int b = 1; b < static_cast<int>(frames); ++b) sweep.pairs.push_back({b - 1, b, matches(b - 1, b)});
  }

  std::vector<Match> matches(int a, int b) const {
    std::vector<Match> result;
    for (const Track& track : found.tracks) {
      for (const Observation& p : track) {
        for (const Observation& q : track) {
          if (p.frame == a && q.frame == b) result.push_back({p.feature, q.feature, 0});
        }
      }
    }
    return result;
  }
  std::string doubted() const { return doubt(sweep, found, names, false).text; }
};

}  // namespace ldp::sfm
