#include "device/tool/commands/build_report.h"

#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/base/markup_text.h"
#include "core/geometry/degrees.h"
#include "core/panorama/file/ldp_file.h"
#include "core/photos/left_out.h"
#include "device/tool/json/quality_json.h"
#include "device/tool/switches.h"

namespace ldp {
namespace {

using Json = nlohmann::ordered_json;

const char* name_of(Motion motion) {
  switch (motion) {
    case Motion::arc:
      return "arc";
    case Motion::straight:
      return "straight";
    case Motion::rotation:
      return "rotation";
  }
  return "";
}

double root_mean_square(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value * value;
  return values.empty() ? 0 : std::sqrt(sum / static_cast<double>(values.size()));
}

Json arc_json(const ArcFit& fit) {
  Json json;
  json["radius"] = fit.arc.radius;
  json["covered_degrees"] = (fit.arc.theta_end - fit.arc.theta_begin) * kDegreesPerRadian;
  json["closed"] = fit.arc.closed;
  json["straight"] = fit.straight;
  json["radial_rms"] = root_mean_square(fit.radial_residuals);
  json["height_rms"] = root_mean_square(fit.height_residuals);
  return json;
}

Json seconds_json(const std::vector<std::pair<std::string, double>>& of_stages) {
  Json json;
  double total = 0;
  for (const auto& [stage, seconds] : of_stages) {
    json[stage] = seconds;
    total += seconds;
  }
  json["total"] = total;
  return json;
}

Json solve_json(const SolveEntry& solve) {
  return {{"name", solve.name},
          {"data_energy", solve.report.data_energy},
          {"smoothness_energy", solve.report.smoothness_energy},
          {"initial_energy", solve.report.initial_energy},
          {"passes", solve.report.passes},
          {"peak_bytes", solve.report.peak_bytes}};
}

}  // namespace

Json poses_json(const PosesReport& poses) {
  Json json;
  json["motion"] = name_of(poses.motion);
  json["closed"] = poses.closed;
  json["posed"] = std::count_if(poses.frames.begin(), poses.frames.end(), [](const FrameReport& f) { return f.posed; });
  json["points"] = poses.points;
  json["reprojection_px"] = poses.reprojection_px;
  json["agreement"] = poses.agreement;
  json["doubt"] = with_switches(poses.doubt);
  json["frames"] = Json::array();
  for (const FrameReport& frame : poses.frames) {
    json["frames"].push_back({{"name", frame.name},
                              {"posed", frame.posed},
                              {"features", frame.features},
                              {"matches", frame.matches},
                              {"inliers", frame.inliers},
                              {"reprojection_px", frame.reprojection_px},
                              {"reason", words_of(frame.left_out)}});
  }
  return json;
}

void print_left_out(const PosesReport& poses) {
  int needless = 0;
  for (const FrameReport& frame : poses.frames) {
    if (frame.left_out.cause == LeftOutCause::needless)
      ++needless;
    else if (!frame.posed)
      std::printf("%s: left out: %s\n", printable(frame.name).c_str(), words_of(frame.left_out).c_str());
  }
  if (needless > 0) std::printf("%d left out: they show next to nothing that the others do not\n", needless);
}

Json residuals_json(const ResidualStatistics& of) {
  Json json = {{"pixels", of.pixels},
               {"psnr_db", of.psnr_db()},
               {"hole_share", of.hole_share()},
               {"unexplained_share", of.unexplained_share()}};
  for (int i = 0; i < kAgreements; ++i) {
    const auto agreement = static_cast<Agreement>(i);
    json["shares"][name_of(agreement)] = of.share(agreement);
  }
  return json;
}

Json consistency_json(const ConsistencyReport& report) {
  Json json = residuals_json(report.all);
  json["photos"] = Json::array();
  for (const PhotoResiduals& photo : report.photos) {
    Json entry = {{"name", photo.name},
                  {"noise", photo.noise},
                  {"shift_px", {photo.shift_x, photo.shift_y}},
                  {"sharpness", photo.sharpness}};
    entry.update(residuals_json(photo.statistics));
    json["photos"].push_back(std::move(entry));
  }
  json["directions"] = Json::array();
  for (const DirectionResiduals& direction : report.directions) {
    Json entry = {{"from_deg", direction.from * kDegreesPerRadian}, {"to_deg", direction.to * kDegreesPerRadian}};
    entry.update(residuals_json(direction.statistics));
    json["directions"].push_back(std::move(entry));
  }
  return json;
}

Json report_json(const BuildReport& report, const LayeredPanorama& panorama) {
  Json json;
  json["seconds"] = seconds_json(report.seconds);
  json["processor_seconds"] = seconds_json(report.processor_seconds);
  json["panorama"] = {{"width", panorama.grid.width},   {"height", panorama.grid.height},
                      {"wraps", panorama.grid.wraps},   {"w_far", panorama.grid.w_far},
                      {"w_near", panorama.grid.w_near}, {"layers", panorama.layers.size()}};
  json["coverage"] = report.coverage;
  json["consistency"] = consistency_json(report.consistency);
  json["arc"] = arc_json(report.arc);
  json["solves"] = Json::array();
  for (const SolveEntry& solve : report.solves) json["solves"].push_back(solve_json(solve));
  json["poses"] = poses_json(report.poses);
  json["quality"] = quality_json(report.quality);
  json["notes"] = with_switches(report.notes);
  return json;
}

Json sizes_json(std::span<const uint8_t> file) {
  const LdpDescription description = describe_ldp(file);
  Json json;
  json["file"] = description.file_bytes;
  json["chunks"] = Json::array();
  for (const LdpChunk& chunk : description.chunks)
    json["chunks"].push_back({{"type", chunk.type}, {"layer", chunk.layer}, {"bytes", chunk.length}});
  return json;
}

int64_t peak_memory_bytes() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return int64_t{usage.ru_maxrss} * 1024;
}

}  // namespace ldp
