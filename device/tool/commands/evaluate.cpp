// ldp evaluate: how well does a build predict photos it has not seen?

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>

#include "core/base/files.h"
#include "core/base/markup_text.h"
#include "core/captures/json_text.h"
#include "core/photos/exposure/local_exposure.h"
#include "core/photos/exposure/photo_exposure.h"
#include "core/photos/exposure_gain.h"
#include "core/photos/images.h"
#include "core/photos/left_out.h"
#include "core/pipeline/build.h"
#include "core/verdict/words.h"
#include "core/view/image_quality.h"
#include "core/view/render.h"
#include "device/tool/build_setup.h"
#include "device/tool/commands.h"
#include "device/tool/commands/baseline.h"
#include "device/tool/commands/build_report.h"
#include "device/tool/json/quality_json.h"
#include "device/tool/number_within.h"
#include "device/tool/output.h"
#include "device/tool/process/progress_bar.h"
#include "device/tool/switches.h"

namespace ldp {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct EvaluateCommand {
  BuildSetup setup;
  int every = 5;
  std::string keep;
};

// Some of another source's frames.
class SomeFrames : public FrameSource {
 public:
  SomeFrames(const FrameSource& all, std::vector<int> chosen) : all_(all), chosen_(std::move(chosen)) {}
  int size() const override { return static_cast<int>(chosen_.size()); }
  std::string name(int index) const override { return all_.name(at(index)); }
  RgbImage load(int index) const override { return all_.load(at(index)); }
  std::optional<double> focal_hint(int index) const override { return all_.focal_hint(at(index)); }

 private:
  int at(int index) const { return chosen_.at(static_cast<size_t>(index)); }
  const FrameSource& all_;
  std::vector<int> chosen_;
};

// From the middle of the first `every` on, so that neither end of the sweep is left out.
bool is_tested(int index, int every) { return index % every == every / 2; }

struct Split {
  std::vector<int> kept_frames, test_frames;
  std::vector<Camera> kept, tests;
  std::vector<FrameReport> without_camera;
};

FrameReport not_given(const std::string& name) {
  FrameReport report;
  report.name = name;
  report.left_out.cause = LeftOutCause::no_camera;
  return report;
}

// Poses of a held-out photo come from all photos: it is the panorama that must do without it.
Split split(const PreparedBuild& prepared, int every, const Job& job) {
  Poses poses;
  poses.cameras = prepared.options.cameras;
  const bool given = !poses.cameras.empty();
  if (!given) poses = estimate_poses(prepared.frames, prepared.options.poses, job);
  const std::vector<Camera>& cameras = poses.cameras;
  Split result;
  int posed = 0;
  for (int i = 0; i < prepared.frames.size(); ++i) {
    const auto camera = std::find_if(cameras.begin(), cameras.end(),
                                     [&](const Camera& c) { return c.name == prepared.frames.name(i); });
    if (camera == cameras.end()) {
      result.without_camera.push_back(given ? not_given(prepared.frames.name(i))
                                            : poses.report.frames[static_cast<size_t>(i)]);
      continue;
    }
    const bool is_test = is_tested(posed++, every);
    (is_test ? result.test_frames : result.kept_frames).push_back(i);
    (is_test ? result.tests : result.kept).push_back(*camera);
  }
  if (result.tests.empty())
    throw Impossible("too few photos to leave each " + std::to_string(every) + "th out: give a smaller --every");
  if (result.kept.size() < 3)
    throw Impossible("only " + std::to_string(result.kept.size()) + " photos are left to build from when each " +
                     std::to_string(every) + "th is left out; at least 3 are needed: take more");
  return result;
}

// Less those of the photos kept that the build had no use for.
Split used(Split split, const std::map<std::string, Gain>& gains) {
  for (size_t i = split.kept.size(); i-- > 0;) {
    if (gains.contains(split.kept[i].name)) continue;
    split.kept.erase(split.kept.begin() + static_cast<std::ptrdiff_t>(i));
    split.kept_frames.erase(split.kept_frames.begin() + static_cast<std::ptrdiff_t>(i));
  }
  return split;
}

// The exposure that a left-out photo may be expected to have: between those of the photos before and after it.
Gain expected_gain(const Split& split, size_t test, const std::map<std::string, Gain>& gains) {
  const int frame = split.test_frames[test];
  const auto after = std::upper_bound(split.kept_frames.begin(), split.kept_frames.end(), frame);
  const auto last = split.kept_frames.end() - 1;
  const auto to = std::min(after, last), from = after == split.kept_frames.begin() ? after : after - 1;
  const double share = *to == *from ? 0 : static_cast<double>(frame - *from) / (*to - *from);
  const auto gain = [&](auto at) {
    return gains.at(split.kept[static_cast<size_t>(at - split.kept_frames.begin())].name);
  };
  Gain expected;
  for (size_t c = 0; c < 3; ++c)
    expected[c] = static_cast<float>(std::pow(gain(from)[c], 1 - share) * std::pow(gain(to)[c], share));
  return expected;
}

// A picture about as a photo of that gain would show it: of bright colours, which gains bend (exposure_gain.h), near
// enough.
void expose(RgbImage& picture, const Gain& gain) {
  const ExposureGain evened(gain);
  constexpr int kUnits = 16;
  const auto stored = [](int channel) { return static_cast<uint8_t>(std::min(255, (channel + kUnits / 2) / kUnits)); };
  for (Rgb& pixel : picture.samples) {
    const auto c = evened.undone({pixel.r * kUnits, pixel.g * kUnits, pixel.b * kUnits}, kUnits);
    pixel = {stored(c[0]), stored(c[1]), stored(c[2])};
  }
}

// Of the photos kept, in their order.
std::vector<Gain> gains_of(const Split& split, const std::map<std::string, Gain>& gains) {
  std::vector<Gain> of_kept;
  for (const Camera& camera : split.kept) of_kept.push_back(gains.at(camera.name));
  return of_kept;
}

struct Row {
  std::string name;
  ViewQuality ours, baseline;
};

class Evaluation {
 public:
  Evaluation(const PreparedBuild& prepared, const Split& split, const BuildResult& result, const Job& job)
      : prepared_(prepared),
        split_(split),
        is_local_(!result.panorama.exposure.empty()),
        gains_(result.report.gains),
        local_(split.kept, gains_of(split, gains_)),
        response_(result.panorama.exposure.response),
        renderer_(result.panorama),
        job_(job) {
    const double near = result.panorama.grid.w_near;
    nearest_depth_ = near > 0 ? 1 / near : 1e6;
  }

  Row judge(size_t test, const fs::path& keep) const {
    const Camera& camera = split_.tests[test];
    job_.report("comparing", static_cast<double>(test) / static_cast<double>(split_.tests.size()));
    const RgbImage truth = prepared_.frames.load(split_.test_frames[test]);
    View view = renderer_.render(camera, {}, job_);
    const Gain gain = expected_gain(split_, test, gains_);
    if (is_local_)
      PhotoExposure({local_.back_to_photo(camera, gain), response_}, view.colour.width, view.colour.height)
          .apply(view.colour);
    else
      expose(view.colour, gain);
    const auto nearest = static_cast<size_t>(nearest_camera(split_.kept, camera, nearest_depth_));
    const RgbImage photo = prepared_.frames.load(split_.kept_frames[nearest]);
    const BaselineView flat = baseline_view(photo, split_.kept[nearest], camera, truth, nearest_depth_);
    job_.check();
    if (!keep.empty()) {
      const std::string stem = fs::path(camera.name).stem().string();
      write_file(keep / (stem + "_true.png"), encode_png(truth));
      write_file(keep / (stem + "_view.png"), encode_png(view.colour, view.alpha));
      write_file(keep / (stem + "_baseline.png"), encode_png(flat.colour, flat.alpha));
    }
    return {camera.name, view_quality(view.colour, view.alpha, truth), view_quality(flat.colour, flat.alpha, truth)};
  }

 private:
  const PreparedBuild& prepared_;
  const Split& split_;
  bool is_local_;  // as bright as the photos of each direction are
  const std::map<std::string, Gain>& gains_;
  LocalExposure local_;
  ResponseCurve response_;
  Renderer renderer_;
  const Job& job_;
  double nearest_depth_ = 0;
};

ViewQuality mean_of(const std::vector<Row>& rows, ViewQuality Row::*which) {
  ViewQuality mean;
  const double share = 1.0 / static_cast<double>(rows.size());
  for (const Row& row : rows) {
    const ViewQuality& q = row.*which;
    mean.psnr_db += share * q.psnr_db;
    mean.ssim += share * q.ssim;
    mean.psnr_covered_db += share * q.psnr_covered_db;
    mean.psnr_matched_db += share * q.psnr_matched_db;
    mean.holes += share * q.holes;
  }
  return mean;
}

Json view_quality_json(const ViewQuality& q) {
  return {{"psnr", q.psnr_db},
          {"ssim", q.ssim},
          {"psnr_covered", q.psnr_covered_db},
          {"psnr_exposure_matched", q.psnr_matched_db},
          {"holes", 100 * q.holes}};
}

void print_row(const std::string& name, const ViewQuality& q) {
  std::printf("%-24s PSNR %5.2f dB  (exposure matched %5.2f)  SSIM %.3f  holes %5.2f %%\n", printable(name).c_str(),
              q.psnr_db, q.psnr_matched_db, q.ssim, 100 * q.holes);
}

// Photos that take no part: neither built from nor compared.
PosesReport left_out_of(const Split& split, const BuildReport& report) {
  PosesReport both;
  both.frames = split.without_camera;
  for (const FrameReport& frame : report.poses.frames)
    if (!frame.posed) both.frames.push_back(frame);
  return both;
}

void print(const std::vector<Row>& rows, const PosesReport& left_out, const BuildReport& report, bool json) {
  const ViewQuality ours = mean_of(rows, &Row::ours), baseline = mean_of(rows, &Row::baseline);
  if (json) {
    Json all{{"built_from", report.gains.size()},
             {"views", Json::array()},
             {"mean", view_quality_json(ours)},
             {"baseline_mean", view_quality_json(baseline)},
             {"expected", quality_json(report.quality)},
             {"notes", with_switches(report.notes)},
             {"left_out", Json::array()}};
    for (const FrameReport& frame : left_out.frames)
      all["left_out"].push_back({{"name", frame.name}, {"reason", words_of(frame.left_out)}});
    for (const Row& row : rows)
      all["views"].push_back(
          {{"name", row.name}, {"view", view_quality_json(row.ours)}, {"baseline", view_quality_json(row.baseline)}});
    std::printf("%s\n", json_text(all, 1).c_str());
    return;
  }
  const size_t photos = report.gains.size();
  std::printf("built from %zu photos, compared with %zu that it was built without\n", photos, rows.size());
  print_left_out(left_out);
  for (const Row& row : rows) print_row(row.name, row.ours);
  print_row("mean", ours);
  print_row("nearest photo, one depth", baseline);
  std::printf("%-24s PSNR %5.2f dB  %s\n", "as the build expected", report.quality.expected_view_psnr_db,
              text_of(report.quality).c_str());
  for (const std::string& note : with_switches(report.notes)) std::printf("%s\n", printable(note).c_str());
}

int run(const EvaluateCommand& command, const Session& session) {
  std::optional<ProgressBar> bar(session.progress_fd);
  const Job job = start_job(session, *bar);
  const PreparedBuild prepared = prepare(command.setup, job);
  keep_out_of_capture(command.keep, "--keep", prepared);
  std::optional<OutputFolder> keep;
  if (!command.keep.empty()) keep.emplace(command.keep, OutputFolder::Existing::merge);
  const Split parts = split(prepared, command.every, job);
  BuildOptions options = prepared.options;
  options.cameras = parts.kept;
  const BuildResult result = build(SomeFrames(prepared.frames, parts.kept_frames), options, job);
  const Split compared = used(parts, result.report.gains);
  const Evaluation evaluation(prepared, compared, result, job);
  std::vector<Row> rows;
  const auto judge_all = [&] {
    for (size_t i = 0; i < parts.tests.size(); ++i)
      rows.push_back(evaluation.judge(i, keep ? keep->path() : fs::path()));
  };
  if (keep) {
    keep->fill(judge_all);
    keep->keep();
  } else {
    judge_all();
  }
  bar.reset();
  print(rows, left_out_of(parts, result.report), result.report, session.json);
  return kDone;
}

}  // namespace

void add_evaluate(Program& program) {
  auto command = std::make_shared<EvaluateCommand>();
  CLI::App& app =
      add_command(program, "evaluate", "Build without each Nth photo and compare rendered views with those photos",
                  [command](const Session& session) { return run(*command, session); });
  add_capture_options(app, command->setup);
  add_build_options(app, command->setup);
  app.add_option("--every", command->every, "Leave each Nth photo out")
      ->check(whole_within(2, 1000))
      ->capture_default_str();
  app.add_option("--keep", command->keep, "Keep the pictures in this folder");
}

}  // namespace ldp
