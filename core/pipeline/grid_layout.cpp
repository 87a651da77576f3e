#include "core/pipeline/grid_layout.h"

#include <cstdio>
#include <stdexcept>
#include <utility>

#include "core/panorama/file/ldp_file.h"
#include "core/pipeline/pipeline_tuning.h"
#include "core/rectify/rectify.h"
#include "core/sweep/cost_volume.h"

namespace ldp {
namespace {

using namespace pipeline;  // tuned constants

std::string mebibytes(size_t bytes) {
  if (bytes < 1 << 20) return std::to_string(bytes) + " bytes";
  return std::to_string((bytes + (1 << 20) - 1) >> 20) + " MiB";
}

std::string in_short(double value) {
  char digits[32];
  std::snprintf(digits, sizeof digits, "%.4g", value);
  return digits;
}

// Who turns the camera up or down, or on the spot, moves it along lines of sight, too.
bool walked(const Poses& poses, const ArcFit& fit) {
  return fit.forward && has_parallax(poses) && !nods(poses.cameras);
}

}  // namespace

GridFit fit_of(const GridNeeds& needs, size_t memory_bytes) {
  if (!fits_ldp(needs.width, needs.height)) return GridFit::too_large_for_a_file;
  const size_t needed = needs.scratch ? needs.memory.least : needs.memory.all;
  return memory_bytes == 0 || needed <= memory_bytes ? GridFit::fits : GridFit::too_large_for_memory;
}

std::string why_impossible(const GridNeeds& needs, size_t memory_bytes) {
  if (fit_of(needs, memory_bytes) == GridFit::too_large_for_a_file)
    return "the panorama would have at least " + std::to_string(needs.width) + " x " + std::to_string(needs.height) +
           " pixels, more than a file holds: use smaller or fewer photos";
  return "this sweep needs at least " + mebibytes(needs.scratch ? needs.memory.least : needs.memory.all) +
         " of memory, " + mebibytes(memory_bytes) + " are allowed (memory_bytes): allow more or use smaller photos";
}

bool has_parallax(const Poses& poses) { return poses.report.motion != Motion::rotation; }

GridLayout::GridLayout(const Poses& poses, const ArcFit& fit, const BuildOptions& options,
                       std::vector<std::string>& notes)
    : poses_(poses), arc_(fit.arc), options_(options), notes_(notes) {
  wanted_.rays = options.rays;
  wanted_.near_depth = options.near_depth;
  wanted_.far_depth = options.far_depth;
  const bool is_walk = walked(poses, fit);
  const double usual_px = is_walk ? kWalkPitch : 1;
  wanted_.pitch_px = usual_px * options_of(options.effort).pitch_px;
  if (is_walk) {
    notes_.push_back(
        "the camera moved along its line of sight: the panorama is laid round one point, and a row of it spans " +
        in_short(wanted_.pitch_px) + " of the photos': for a view that one can look around in, turn along an arc");
  }
  lay_finest(kCoarsest * usual_px);
  check_range();
}

void GridLayout::lay_finest(double coarsest_px) {
  GridFit last = GridFit::fits;
  for (GridFit fit = lay(wanted_); fit != GridFit::fits; fit = lay(wanted_)) {
    if (wanted_.pitch_px > coarsest_px) throw Impossible(why_impossible(needs_, options_.memory_bytes));
    wanted_.pitch_px *= kCoarser;
    last = fit;
  }
  if (last == GridFit::fits) return;
  notes_.push_back(std::string("to fit ") + (last == GridFit::too_large_for_memory ? "the memory allowed" : "a file") +
                   ", a row of the panorama spans " + std::to_string(wanted_.pitch_px).substr(0, 4) +
                   " of the photos'");
}

// A second column of colour is worth less than finer depths.
GridFit GridLayout::lay(const GridOptions& wanted) {
  grid_ = lay_grid(arc_, poses_.cameras, poses_.points, wanted);
  columns_of_colour_ = ldp::columns_of_colour(grid_, poses_.cameras, poses_.points);
  GridFit fit = fit_laid(wanted);
  if (fit != GridFit::fits && std::exchange(columns_of_colour_, 1) > 1) fit = fit_laid(wanted);
  return fit;
}

// What does not fit the memory allowed goes to files where it may.
GridFit GridLayout::fit_laid(const GridOptions& wanted) {
  const size_t allowed = options_.memory_bytes > 0 ? options_.memory_bytes : kEasyMemory;
  const Intrinsics& k = poses_.cameras.front().intrinsics;
  const size_t photo_px = static_cast<size_t>(k.width) * static_cast<size_t>(k.height);
  needs_ = {grid_.width * columns_of_colour_, grid_.height,
            expected_memory(grid_, columns_of_colour_, photo_px, upright_pixels(poses_.cameras, arc_, wanted.pitch_px),
                            options_.layers),
            false};
  if (!fits_ldp(needs_.width, needs_.height)) return GridFit::too_large_for_a_file;
  if (needs_.memory.all > allowed && !std::exchange(tried_scratch_, true)) open_scratch(allowed);
  needs_.scratch = scratch_ != nullptr;
  return fit_of(needs_, options_.memory_bytes);
}

void GridLayout::open_scratch(size_t allowed) {
  if (options_.scratch_directory.empty()) return;
  try {
    scratch_ = std::make_unique<ScratchSpace>(options_.scratch_directory,
                                              static_cast<size_t>(kFull * static_cast<double>(allowed)));
  } catch (const std::runtime_error& error) {
    notes_.push_back(std::string("everything is kept in memory: ") + error.what());
  }
}

void GridLayout::check_range() const {
  if (!has_parallax(poses_) || grid_.w_far < grid_.w_near) return;
  const bool far_given = options_.far_depth > 0;
  throw std::invalid_argument(
      (far_given ? "far_depth " + in_short(options_.far_depth) : "near_depth " + in_short(options_.near_depth)) +
      (far_given ? ": is nearer than what is nearest in the photos, at "
                 : ": is farther than what is farthest in the photos, at ") +
      in_short(1 / (far_given ? grid_.w_near : grid_.w_far)) +
      (far_given ? ": give a larger one, or near_depth too" : ": give a smaller one, or far_depth too"));
}

void GridLayout::take_in_what_is_nearer(const std::vector<UprightFrame>& upright, const Job& job) {
  if (wanted_.near_depth != 0) return;
  const PanoramaGrid laid = grid_;
  const int columns_laid = columns_of_colour_;
  GridOptions wider = wanted_;
  wider.matched_near = matched_near(upright, grid_, job);
  tried_scratch_ = true;  // files cannot take the upright frames any more
  if (wider.matched_near > grid_.w_near && lay(wider) != GridFit::fits) grid_ = laid, columns_of_colour_ = columns_laid;
}

}  // namespace ldp
