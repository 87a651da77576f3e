// The grid of a build: the finest that fits the memory allowed and a file, and the scratch space where memory is not
// enough.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/arc/arc.h"
#include "core/base/memory/scratch_space.h"
#include "core/photos/upright_frame.h"
#include "core/pipeline/build.h"
#include "core/pipeline/memory_budget.h"

namespace ldp {

// Whether the photos were taken from more than one place.
bool has_parallax(const Poses& poses);

// What a grid asks for.
struct GridNeeds {
  int width = 0, height = 0;  // of the panorama: with the columns of colour
  ExpectedMemory memory;
  bool scratch = false;  // large arrays may live in files
};

enum class GridFit : uint8_t { fits, too_large_for_a_file, too_large_for_memory };
GridFit fit_of(const GridNeeds& needs, size_t memory_bytes);  // 0 = no limit
// Why a grid that does not fit, however coarse, is the end.
std::string why_impossible(const GridNeeds& needs, size_t memory_bytes);

class GridLayout {
 public:
  // All must outlive it; `notes` are told what was done to save memory and time. Throws Impossible where no grid fits,
  // and std::invalid_argument where a depth that was asked for lies on the wrong side of the one that the photos tell.
  GridLayout(const Poses& poses, const ArcFit& fit, const BuildOptions& options, std::vector<std::string>& notes);

  const PanoramaGrid& grid() const { return grid_; }
  int columns_of_colour() const { return columns_of_colour_; }  // to each of the columns in which depths are found
  double pitch_px() const { return wanted_.pitch_px; }          // rows of the photos to a row of the panorama

  // What is nearer than the feature points tell widens the range, and the grid a little; not where memory does not
  // allow it, nor where the nearest depth was given.
  void take_in_what_is_nearer(const std::vector<UprightFrame>& upright, const Job& job);

  std::unique_ptr<ScratchSpace> give_scratch() { return std::move(scratch_); }  // nullptr: everything is in memory

 private:
  void lay_finest(double coarsest_px);
  void check_range() const;
  GridFit lay(const GridOptions& wanted);
  GridFit fit_laid(const GridOptions& wanted);
  void open_scratch(size_t allowed);

  const Poses& poses_;
  const Arc& arc_;
  const BuildOptions& options_;
  std::vector<std::string>& notes_;
  GridOptions wanted_;
  PanoramaGrid grid_;
  int columns_of_colour_ = 1;
  GridNeeds needs_;  // of the grid laid last
  bool tried_scratch_ = false;
  std::unique_ptr<ScratchSpace> scratch_;
};

}  // namespace ldp
