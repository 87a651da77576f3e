#include "core/poses/features/sift.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <stdexcept>

#include "core/base/exact_math.h"
#include "core/poses/features/feature_tuning.h"
#include "core/poses/features/scale_space.h"
#include "core/poses/features/sift_kernels.h"

namespace ldp::sfm {
namespace {

constexpr int kCells = Sift::kCells, kOrientations = Sift::kOrientations, kOrientationBins = sift::kOrientationBins;
static_assert(kCells == sift::kCells && kOrientations == sift::kOrientations);
constexpr float kLength = 512;  // of the descriptor as bytes
constexpr double kPi = std::numbers::pi;

int nearest_whole(double x) { return static_cast<int>(std::floor(x + 0.5)); }

// Calls use(row) for the rows of a window of Gaussian weights around a keypoint.
template <typename Use>
void for_window_rows(const Plane<float>& image, const Keypoint& around, int reach, double sigma, Use use) {
  const std::vector<float> half = gaussian(reach + 1, sigma);
  std::vector<float> weights(half.rbegin(), half.rend());
  weights.insert(weights.end(), half.begin() + 1, half.end());
  if (weights.size() > sift::kMaxWindow) throw std::logic_error("Sift: a keypoint's scale is none of its octave's");
  const int x = nearest_whole(around.x), y = nearest_whole(around.y);
  sift::WindowRow row{nullptr,
                      image.width,
                      0,
                      std::max(1 - x, -reach),
                      std::min(image.width - 2 - x, reach) + 1,
                      weights.data() + reach};
  for (row.y = std::max(1 - y, -reach); row.y <= std::min(image.height - 2 - y, reach); ++row.y) {
    row.middle = image.row(y + row.y) + x;
    use(row);
  }
}

// Directions in which brightness grows most around a keypoint.
std::vector<double> orientations(const Plane<float>& image, const Keypoint& keypoint) {
  float bins[kOrientationBins] = {};
  const double sigma = kOrientationWindowSigmas * keypoint.sigma;
  for_window_rows(image, keypoint, nearest_whole(3 * sigma), sigma,
                  [&](const sift::WindowRow& row) { sift::best().add_to_orientation_histogram(row, bins); });
  std::array<float, kOrientationBins> smooth{};
  const auto around = [](const auto& b, size_t i, size_t step) { return b[(i + step) % kOrientationBins]; };
  for (size_t i = 0; i < kOrientationBins; ++i) {
    smooth[i] = (around(bins, i, kOrientationBins - 2) + around(bins, i, 2)) / 16 +
                (around(bins, i, kOrientationBins - 1) + around(bins, i, 1)) * 4 / 16 + bins[i] * 6 / 16;
  }
  const float highest = *std::max_element(smooth.begin(), smooth.end());
  std::vector<double> found;
  for (size_t i = 0; i < kOrientationBins; ++i) {
    const double before = double{around(smooth, i, kOrientationBins - 1)}, here = double{smooth[i]},
                 after = double{around(smooth, i, 1)};
    if (here <= before || here <= after || here < kSecondOrientationShare * double{highest}) continue;
    const double shift = 0.5 * (before - after) / (before - 2 * here + after);
    found.push_back((static_cast<double>(i) + shift) * (2 * kPi / kOrientationBins));
  }
  return found;
}

// To bytes, as shares of the length, none of them larger than kMaxDescriptorEntry.
Sift::Histograms normalised(const sift::Cells& cells) {
  std::array<float, size_t{kCells} * kCells * kOrientations> sums;
  for (int i = 0; i < kCells * kCells * kOrientations; ++i) {
    const int cell = i / kOrientations, rimmed = (1 + cell / kCells) * sift::kPaddedCells + 1 + cell % kCells;
    sums[static_cast<size_t>(i)] = cells[rimmed * kOrientations + i % kOrientations];
  }
  float squares = 0, limited = 0;
  for (const float s : sums) squares += s * s;
  const float most = kMaxDescriptorEntry * std::sqrt(squares);
  for (const float s : sums) limited += std::min(s, most) * std::min(s, most);
  const float scale = kLength / std::max(std::sqrt(limited), 1e-7F);
  Sift::Histograms result;
  std::transform(sums.begin(), sums.end(), result.begin(),
                 [&](float s) { return static_cast<uint8_t>(std::min(255.0F, std::min(s, most) * scale + 0.5F)); });
  return result;
}

}  // namespace

Sift::Sift(const GreyImage& picture, double contrast) {
  Plane<float> first = base_level(picture);
  while (std::min(first.width, first.height) > 2 * Octave::kBorder) {
    Octave octave(std::move(first));
    for (Keypoint found : octave.extrema(contrast)) {
      found.octave = static_cast<int>(octaves_.size());
      extrema_.push_back(found);
    }
    first = decimated(octave.blur(kLevels));
    octaves_.emplace_back();
    for (int i = 0; i < kLevels; ++i) octaves_.back()[static_cast<size_t>(i)] = std::move(octave.blur(i + 1));
  }
}

std::vector<Keypoint> Sift::oriented(const Keypoint& extremum) const {
  std::vector<Keypoint> keypoints;
  for (const double angle : orientations(level_of(extremum), extremum)) {
    keypoints.push_back(extremum);
    keypoints.back().angle_rad = angle;
  }
  return keypoints;
}

Sift::Histograms Sift::describe(const Keypoint& keypoint) const {
  const double cell = kDescriptorCellSigmas * keypoint.sigma;
  const SineCosine turn = exact_sine_cosine(keypoint.angle_rad);
  const sift::PatchRotation to_cells{static_cast<float>(turn.cosine / cell), static_cast<float>(turn.sine / cell),
                                     static_cast<float>(keypoint.angle_rad)};
  const int reach = nearest_whole(cell * std::numbers::sqrt2 * 0.5 * (kCells + 1));
  sift::Cells cells = {};
  for_window_rows(level_of(keypoint), keypoint, reach, 0.5 * kCells * cell,
                  [&](const sift::WindowRow& row) { sift::best().add_to_descriptor(row, to_cells, cells); });
  return normalised(cells);
}

}  // namespace ldp::sfm
