#include "core/poses/features/scale_space.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/base/exact_math.h"
#include "core/poses/features/feature_tuning.h"
#include "core/poses/features/sift_kernels.h"

namespace ldp::sfm {
namespace {

constexpr int kLevels = Sift::kLevels;

// Of a level, pixels of its octave.
double sigma_of(double level) { return kOctaveSigma_px * exact_exp(level / kLevels * std::numbers::ln2); }

// Half of a kernel of sum 1, from its middle on.
std::vector<float> half_kernel(double sigma) {
  std::vector<float> half = gaussian(static_cast<int>(std::ceil(4 * sigma)) + 1, sigma);
  float sum = half[0];
  for (size_t i = 1; i < half.size(); ++i) sum += 2 * half[i];
  for (float& weight : half) weight /= sum;
  return half;
}

int mirrored(int i, int size) {
  if (size == 1) return 0;
  const int period = 2 * (size - 1), place = std::abs(i) % period;
  return std::min(place, period - place);
}

Plane<float> blurred(const Plane<float>& image, double sigma) {
  const std::vector<float> half = half_kernel(sigma);
  const int reach = static_cast<int>(half.size()) - 1, width = image.width;
  const sift::Blur blur{half.data(), reach};
  const sift::Kernels& kernels = sift::best();
  std::vector<float> padded(static_cast<size_t>(width + 2 * reach));
  float* const line = padded.data() + reach;
  std::vector<const float*> rows(static_cast<size_t>(2 * reach + 1));
  Plane<float> result(width, image.height);
  for (int y = 0; y < image.height; ++y) {
    for (int j = -reach; j <= reach; ++j)
      rows[static_cast<size_t>(reach + j)] = image.row(mirrored(y + j, image.height));
    kernels.blur_down(rows.data(), blur, width, line);
    for (int j = 1; j <= reach; ++j) {
      line[-j] = line[mirrored(-j, width)];
      line[width - 1 + j] = line[mirrored(width - 1 + j, width)];
    }
    kernels.blur_across(line, blur, width, result.row(y));
  }
  return result;
}

// Twice the size, bilinearly.
Plane<float> doubled(const GreyImage& grey) {
  Plane<float> result(2 * grey.width, 2 * grey.height);
  std::vector<int> line(static_cast<size_t>(grey.width) + 2);  // with its ends repeated
  for (int y = 0; y < result.height; ++y) {
    const uint8_t* near = grey.row(y / 2);
    const uint8_t* far = grey.row(std::clamp(y / 2 + (y % 2 == 0 ? -1 : 1), 0, grey.height - 1));
    int* const middle = line.data() + 1;
    for (int x = 0; x < grey.width; ++x) middle[x] = 3 * near[x] + far[x];
    middle[-1] = middle[0], middle[grey.width] = middle[grey.width - 1];
    float* const out = result.row(y);
    for (int x = 0; x < grey.width; ++x) {
      out[ptrdiff_t{2} * x] = static_cast<float>(3 * middle[x] + middle[x - 1]) / 16;
      out[2 * x + 1] = static_cast<float>(3 * middle[x] + middle[x + 1]) / 16;
    }
  }
  return result;
}

// Rows of the differences of neighbouring levels, with what is around each place.
class DifferenceRows {
 public:
  explicit DifferenceRows(int width) : width_(width), samples_(static_cast<size_t>(3 * kCount * width)) {
    for (int i = 0; i < kCount; ++i) {
      float* const first = samples_.data() + static_cast<std::ptrdiff_t>(3 * i) * width;
      rows_[i] = {first, first + width, first + ptrdiff_t{2} * width};
    }
  }

  template <size_t blurs>
  void find(const std::array<Plane<float>, blurs>& blur, int y) {
    static_assert(blurs == kCount + 1);
    for (size_t i = 0; i < kCount; ++i) {
      const Plane<float>&less = blur[i], &more = blur[i + 1];
      kernels_.find_difference({less.row(y - 1), less.row(y), less.row(y + 1)},
                               {more.row(y - 1), more.row(y), more.row(y + 1)}, width_, rows_[i]);
    }
  }

  void mark_extrema(int level, float least, uint8_t* marks) const {
    kernels_.mark_extrema({rows_[level - 1], rows_[level], rows_[level + 1]}, least, width_, marks);
  }

 private:
  static constexpr int kCount = kLevels + 2;
  const sift::Kernels& kernels_ = sift::best();
  int width_;
  std::vector<float> samples_;
  sift::DifferenceRow rows_[kCount];
};

}  // namespace

std::vector<float> gaussian(int count, double sigma) {
  std::vector<float> weights;
  for (int i = 0; i < count; ++i) {
    const double d = i / sigma;
    weights.push_back(static_cast<float>(exact_exp(-0.5 * d * d)));
  }
  return weights;
}

Plane<float> base_level(const GreyImage& picture) {
  return blurred(doubled(picture),
                 std::sqrt(kOctaveSigma_px * kOctaveSigma_px - 4 * kAssumedBlur_px * kAssumedBlur_px));
}

Plane<float> decimated(const Plane<float>& image) {
  Plane<float> result(image.width / 2, image.height / 2);
  for (int y = 0; y < result.height; ++y) {
    const float* const from = image.row(2 * y);
    float* const to = result.row(y);
    for (int x = 0; x < result.width; ++x) to[x] = from[ptrdiff_t{2} * x];
  }
  return result;
}

Octave::Octave(Plane<float> first) {
  blur_[0] = std::move(first);
  for (int i = 1; i < kBlurs; ++i) {
    const double before = sigma_of(i - 1), after = sigma_of(i);
    blur(i) = blurred(blur(i - 1), std::sqrt(after * after - before * before));
  }
}

std::vector<Keypoint> Octave::extrema(double contrast) const {
  std::array<std::vector<Keypoint>, kLevels> found;
  DifferenceRows rows(width());
  std::vector<uint8_t> marks(static_cast<size_t>(width()));
  for (int y = kBorder; y < height() - kBorder; ++y) {
    rows.find(blur_, y);
    for (int level = 1; level <= kLevels; ++level) {
      rows.mark_extrema(level, static_cast<float>(0.5 * contrast), marks.data());
      const auto end = marks.end() - kBorder;
      for (auto mark = std::find(marks.begin() + kBorder, end, 1); mark != end; mark = std::find(mark + 1, end, 1)) {
        const auto keypoint = localised(level, static_cast<int>(mark - marks.begin()), y, contrast);
        if (keypoint) found[static_cast<size_t>(level) - 1].push_back(*keypoint);
      }
    }
  }
  for (size_t i = 1; i < kLevels; ++i) found[0].insert(found[0].end(), found[i].begin(), found[i].end());
  return std::move(found[0]);
}

// Where the parabola through the neighbours is extreme; none where that is faint, an edge or runs away.
std::optional<Keypoint> Octave::localised(int level, int x, int y, double contrast) const {
  for (int step = 0; step < kMaxLocalisationSteps; ++step) {
    const auto d = [&](int dl, int dx, int dy) { return double{difference(level + dl, x + dx, y + dy)}; };
    const double middle = d(0, 0, 0);
    const double gx = 0.5 * (d(0, 1, 0) - d(0, -1, 0)), gy = 0.5 * (d(0, 0, 1) - d(0, 0, -1)),
                 gl = 0.5 * (d(1, 0, 0) - d(-1, 0, 0));
    const double xx = d(0, 1, 0) + d(0, -1, 0) - 2 * middle, yy = d(0, 0, 1) + d(0, 0, -1) - 2 * middle,
                 ll = d(1, 0, 0) + d(-1, 0, 0) - 2 * middle;
    const double xy = 0.25 * (d(0, 1, 1) - d(0, -1, 1) - d(0, 1, -1) + d(0, -1, -1)),
                 xl = 0.25 * (d(1, 1, 0) - d(1, -1, 0) - d(-1, 1, 0) + d(-1, -1, 0)),
                 yl = 0.25 * (d(1, 0, 1) - d(1, 0, -1) - d(-1, 0, 1) + d(-1, 0, -1));
    // Cramer's rule.
    const double axx = yy * ll - yl * yl, axy = xl * yl - xy * ll, axl = xy * yl - xl * yy;
    const double determinant = xx * axx + xy * axy + xl * axl;
    if (determinant == 0) return std::nullopt;
    const double to_x = -(axx * gx + axy * gy + axl * gl) / determinant;
    const double to_y = -(axy * gx + (xx * ll - xl * xl) * gy + (xy * xl - xx * yl) * gl) / determinant;
    const double to_l = -(axl * gx + (xy * xl - xx * yl) * gy + (xx * yy - xy * xy) * gl) / determinant;
    if (std::max({std::abs(to_x), std::abs(to_y), std::abs(to_l)}) < 0.5) {
      const double response = std::abs(middle + 0.5 * (gx * to_x + gy * to_y + gl * to_l));
      const double trace = xx + yy, flat = xx * yy - xy * xy;
      if (response < contrast || flat <= 0 ||
          trace * trace * kMaxCurvatureRatio >= (kMaxCurvatureRatio + 1) * (kMaxCurvatureRatio + 1) * flat)
        return std::nullopt;
      return Keypoint{x + to_x, y + to_y, sigma_of(level + to_l), 0, level, response, 0};
    }
    if (!(std::max({std::abs(to_x), std::abs(to_y), std::abs(to_l)}) < 1e6)) return std::nullopt;
    x += static_cast<int>(std::lround(to_x));
    y += static_cast<int>(std::lround(to_y));
    level += static_cast<int>(std::lround(to_l));
    if (level < 1 || level > kLevels || x < kBorder || x >= width() - kBorder || y < kBorder || y >= height() - kBorder)
      return std::nullopt;
  }
  return std::nullopt;
}

}  // namespace ldp::sfm
