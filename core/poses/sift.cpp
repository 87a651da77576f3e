#include "sift.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "exact_math.h"

namespace ldp {
namespace {

constexpr int kLevels = Sift::kLevels, kCells = Sift::kCells, kDirections = Sift::kDirections;
constexpr double kSigma = 1.6;         // of an octave's first level, pixels of the octave
constexpr double kPictureSigma = 0.5;  // blur that a picture is taken to have
constexpr int kBorder = 5;             // pixels without extrema
constexpr double kEdge = 10;           // ratio of curvatures at which an extremum is an edge, which slides along itself
constexpr int kSteps = 5;              // of an extremum from pixel to pixel
constexpr int kAngles = 36;            // bins for the direction of a keypoint
constexpr double kAngleSigma = 1.5;    // of their window, in units of the keypoint's
constexpr double kOtherAngle = 0.8;    // share of the highest bin that makes a second keypoint
constexpr double kCellWidth = 3;       // of the descriptor, in units of the keypoint's sigma
constexpr float kLargestShare = 0.2F;  // of the descriptor's length that one gradient may have, against glare
constexpr float kLength = 512;         // of the descriptor as bytes
constexpr double kPi = std::numbers::pi;

double power_of_two(double exponent) { return exact_exp(exponent * std::numbers::ln2); }

// To 1e-5 rad (Abramowitz and Stegun 4.4.47).
float angle_of(float x, float y) {
  const float ax = std::abs(x), ay = std::abs(y);
  const float t = std::min(ax, ay) / std::max(std::max(ax, ay), 1e-30F), t2 = t * t;
  float angle = t * (0.9998660F + t2 * (-0.3302995F + t2 * (0.1801410F + t2 * (-0.0851330F + t2 * 0.0208351F))));
  if (ay > ax) angle = static_cast<float>(kPi / 2) - angle;
  if (x < 0) angle = static_cast<float>(kPi) - angle;
  return y < 0 ? -angle : angle;
}

// exp(-d^2 / 2 sigma^2) for d = 0, 1, ...
std::vector<float> gaussian(int count, double sigma) {
  std::vector<float> weights;
  for (int i = 0; i < count; ++i) {
    const double d = i / sigma;
    weights.push_back(static_cast<float>(exact_exp(-0.5 * d * d)));
  }
  return weights;
}

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
  const std::vector<float> kernel = half_kernel(sigma);
  const int reach = static_cast<int>(kernel.size()) - 1, width = image.width;
  std::vector<float> padded(static_cast<size_t>(width + 2 * reach));
  float* const line = padded.data() + reach;
  Plane<float> result(width, image.height);
  for (int y = 0; y < image.height; ++y) {
    const float* const middle = image.row(y);
    for (int x = 0; x < width; ++x) line[x] = kernel[0] * middle[x];
    for (int j = 1; j <= reach; ++j) {
      const float *above = image.row(mirrored(y - j, image.height)), *below = image.row(mirrored(y + j, image.height));
      const float weight = kernel[static_cast<size_t>(j)];
      for (int x = 0; x < width; ++x) line[x] += weight * (above[x] + below[x]);
    }
    for (int j = 1; j <= reach; ++j) {
      line[-j] = line[mirrored(-j, width)];
      line[width - 1 + j] = line[mirrored(width - 1 + j, width)];
    }
    float* const out = result.row(y);
    for (int x = 0; x < width; ++x) out[x] = kernel[0] * line[x];
    for (int j = 1; j <= reach; ++j) {
      const float weight = kernel[static_cast<size_t>(j)];
      for (int x = 0; x < width; ++x) out[x] += weight * (line[x - j] + line[x + j]);
    }
  }
  return result;
}

// Twice the size, bilinearly.
Plane<float> doubled(const GreyImage& grey) {
  Plane<float> result(2 * grey.width, 2 * grey.height);
  for (int y = 0; y < result.height; ++y) {
    const uint8_t* near = grey.row(y / 2);
    const uint8_t* far = grey.row(std::clamp(y / 2 + (y % 2 == 0 ? -1 : 1), 0, grey.height - 1));
    for (int x = 0; x < result.width; ++x) {
      const int i = x / 2, j = std::clamp(i + (x % 2 == 0 ? -1 : 1), 0, grey.width - 1);
      result.at(x, y) = static_cast<float>(9 * near[i] + 3 * near[j] + 3 * far[i] + far[j]) / 16;
    }
  }
  return result;
}

Plane<float> every_second(const Plane<float>& image) {
  Plane<float> result(image.width / 2, image.height / 2);
  for (int y = 0; y < result.height; ++y) {
    for (int x = 0; x < result.width; ++x) result.at(x, y) = image.at(2 * x, 2 * y);
  }
  return result;
}

// One octave: levels of blur, each 2^(1 / kLevels) times the one before.
class Octave {
 public:
  explicit Octave(Plane<float> first) {
    blur_.push_back(std::move(first));
    for (int i = 1; i < kLevels + 3; ++i) {
      const double before = sigma(i - 1), after = sigma(i);
      blur_.push_back(blurred(blur_.back(), std::sqrt(after * after - before * before)));
    }
  }

  static double sigma(double level) { return kSigma * power_of_two(level / kLevels); }

  int width() const { return blur_[0].width; }
  int height() const { return blur_[0].height; }
  Plane<float>& blur(int level) { return blur_[static_cast<size_t>(level)]; }

  // Without directions yet, and without the octave's number.
  std::vector<Keypoint> extrema(double contrast) const {
    std::vector<Keypoint> found;
    const float least = static_cast<float>(0.5 * contrast);
    for (int level = 1; level <= kLevels; ++level) {
      for (int y = kBorder; y < height() - kBorder; ++y) {
        for (int x = kBorder; x < width() - kBorder; ++x) {
          if (std::abs(difference(level, x, y)) <= least || !extreme(level, x, y)) continue;
          const std::optional<Keypoint> keypoint = placed(level, x, y, contrast);
          if (keypoint) found.push_back(*keypoint);
        }
      }
    }
    return found;
  }

 private:
  float difference(int level, int x, int y) const {
    const size_t i = static_cast<size_t>(level), at = blur_[0].index(x, y);
    return blur_[i + 1].samples[at] - blur_[i].samples[at];
  }

  bool extreme(int level, int x, int y) const {
    const float middle = difference(level, x, y), sign = middle > 0 ? 1.0F : -1.0F;
    for (const int l : {level, level - 1, level + 1}) {
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          if (sign * difference(l, x + dx, y + dy) > sign * middle) return false;
        }
      }
    }
    return true;
  }

  // Where the parabola through the neighbours is extreme; none where that is faint, an edge or runs away.
  std::optional<Keypoint> placed(int level, int x, int y, double contrast) const {
    for (int step = 0; step < kSteps; ++step) {
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
        if (response < contrast || flat <= 0 || trace * trace * kEdge >= (kEdge + 1) * (kEdge + 1) * flat)
          return std::nullopt;
        return Keypoint{x + to_x, y + to_y, sigma(level + to_l), 0, level, response, 0};
      }
      if (!(std::max({std::abs(to_x), std::abs(to_y), std::abs(to_l)}) < 1e6)) return std::nullopt;
      x += static_cast<int>(std::lround(to_x));
      y += static_cast<int>(std::lround(to_y));
      level += static_cast<int>(std::lround(to_l));
      if (level < 1 || level > kLevels || x < kBorder || x >= width() - kBorder || y < kBorder ||
          y >= height() - kBorder)
        return std::nullopt;
    }
    return std::nullopt;
  }

  std::vector<Plane<float>> blur_;
};

// A gradient near a keypoint: where, from the pixel nearest to it; its direction; its size times a Gaussian weight.
struct Gradient {
  float x, y, angle, size;
};

template <typename Wanted, typename Use>
void for_gradients(const Plane<float>& image, const Keypoint& around, int reach, double sigma, Wanted wanted, Use use) {
  const std::vector<float> weights = gaussian(reach + 1, sigma);
  const int x = static_cast<int>(around.x + 0.5), y = static_cast<int>(around.y + 0.5);
  for (int dy = std::max(1 - y, -reach); dy <= std::min(image.height - 2 - y, reach); ++dy) {
    for (int dx = std::max(1 - x, -reach); dx <= std::min(image.width - 2 - x, reach); ++dx) {
      const Gradient place{static_cast<float>(dx), static_cast<float>(dy), 0, 0};
      if (!wanted(place)) continue;
      const float *row = image.row(y + dy) + x + dx, *above = row - image.width, *below = row + image.width;
      const float gx = row[1] - row[-1], gy = *below - *above;
      const float weight = weights[static_cast<size_t>(std::abs(dx))] * weights[static_cast<size_t>(std::abs(dy))];
      use(Gradient{place.x, place.y, angle_of(gx, gy), weight * std::sqrt(gx * gx + gy * gy)});
    }
  }
}

// Directions in which brightness grows most around a keypoint.
std::vector<double> directions(const Plane<float>& image, const Keypoint& keypoint) {
  std::array<float, kAngles> bins{}, smooth{};
  const double sigma = kAngleSigma * keypoint.sigma;
  const auto all = [](const Gradient&) { return true; };
  for_gradients(image, keypoint, static_cast<int>(3 * sigma + 0.5), sigma, all, [&](const Gradient& g) {
    const float bin = g.angle * static_cast<float>(kAngles / (2 * kPi));
    bins[static_cast<size_t>(bin + (kAngles + 0.5F)) % kAngles] += g.size;
  });
  const auto around = [](const std::array<float, kAngles>& b, size_t i, size_t step) {
    return b[(i + step) % kAngles];
  };
  for (size_t i = 0; i < kAngles; ++i) {
    smooth[i] = (around(bins, i, kAngles - 2) + around(bins, i, 2)) / 16 +
                (around(bins, i, kAngles - 1) + around(bins, i, 1)) * 4 / 16 + bins[i] * 6 / 16;
  }
  const float highest = *std::max_element(smooth.begin(), smooth.end());
  std::vector<double> found;
  for (size_t i = 0; i < kAngles; ++i) {
    const double before = double{around(smooth, i, kAngles - 1)}, here = double{smooth[i]},
                 after = double{around(smooth, i, 1)};
    if (here <= before || here <= after || here < kOtherAngle * double{highest}) continue;
    const double shift = 0.5 * (before - after) / (before - 2 * here + after);
    found.push_back((static_cast<double>(i) + shift) * (2 * kPi / kAngles));
  }
  return found;
}

// Gradients summed by place and direction, each shared between the nearest bins.
class Sums {
 public:
  // Cells and directions have their middles at whole numbers; -1 < x, y < kCells, direction >= 0.
  void add(float x, float y, float direction, float size) {
    const int column = static_cast<int>(x + 1), row = static_cast<int>(y + 1), bin = static_cast<int>(direction);
    const float to_right = x + 1 - static_cast<float>(column), to_below = y + 1 - static_cast<float>(row),
                to_next = direction - static_cast<float>(bin);
    for (int i = 0; i < 4; ++i) {
      const float share = size * (i % 2 == 0 ? 1 - to_right : to_right) * (i / 2 == 0 ? 1 - to_below : to_below);
      float* const cell = bins_[row + i / 2][column + i % 2];
      cell[bin % kDirections] += share * (1 - to_next);
      cell[(bin + 1) % kDirections] += share * to_next;
    }
  }

  // To bytes, as shares of the length, none of them larger than kLargestShare.
  Sift::Histograms normalised() const {
    std::array<float, kCells * kCells * kDirections> sums;
    for (int i = 0; i < kCells * kCells * kDirections; ++i) {
      const int cell = i / kDirections;
      sums[static_cast<size_t>(i)] = bins_[1 + cell / kCells][1 + cell % kCells][i % kDirections];
    }
    float squares = 0, limited = 0;
    for (const float s : sums) squares += s * s;
    const float most = kLargestShare * std::sqrt(squares);
    for (const float s : sums) limited += std::min(s, most) * std::min(s, most);
    const float scale = kLength / std::max(std::sqrt(limited), 1e-7F);
    Sift::Histograms result;
    std::transform(sums.begin(), sums.end(), result.begin(),
                   [&](float s) { return static_cast<uint8_t>(std::min(255.0F, std::min(s, most) * scale + 0.5F)); });
    return result;
  }

 private:
  float bins_[kCells + 2][kCells + 2][kDirections] = {};  // with a rim of cells that nobody asks for
};

}  // namespace

Sift::Sift(const GreyImage& picture, double contrast) {
  Plane<float> first = blurred(doubled(picture), std::sqrt(kSigma * kSigma - 4 * kPictureSigma * kPictureSigma));
  while (std::min(first.width, first.height) > 2 * kBorder) {
    Octave octave(std::move(first));
    for (Keypoint found : octave.extrema(contrast)) {
      for (const double angle : directions(octave.blur(found.level), found)) {
        found.octave = static_cast<int>(octaves_.size());
        found.angle_rad = angle;
        keypoints_.push_back(found);
      }
    }
    first = every_second(octave.blur(kLevels));
    octaves_.emplace_back();
    for (int i = 0; i < kLevels; ++i) octaves_.back()[static_cast<size_t>(i)] = std::move(octave.blur(i + 1));
  }
}

Sift::Histograms Sift::describe(const Keypoint& keypoint) const {
  const Plane<float>& image = octaves_[static_cast<size_t>(keypoint.octave)][static_cast<size_t>(keypoint.level) - 1];
  const double cell = kCellWidth * keypoint.sigma;
  const SineCosine turn = exact_sine_cosine(keypoint.angle_rad);
  const float c = static_cast<float>(turn.cosine / cell), s = static_cast<float>(turn.sine / cell);
  constexpr float kMiddle = 0.5F * (kCells - 1), kPerRadian = static_cast<float>(kDirections / (2 * kPi));
  const float angle = static_cast<float>(keypoint.angle_rad);
  const auto along = [&](const Gradient& g) { return c * g.x + s * g.y + kMiddle; };
  const auto across = [&](const Gradient& g) { return c * g.y - s * g.x + kMiddle; };
  const auto inside = [](float place) { return place > -1 && place < kCells; };
  const auto wanted = [&](const Gradient& g) { return inside(along(g)) && inside(across(g)); };
  const int reach = static_cast<int>(cell * std::numbers::sqrt2 * 0.5 * (kCells + 1) + 0.5);
  Sums sums;
  for_gradients(image, keypoint, reach, 0.5 * kCells * cell, wanted, [&](const Gradient& g) {
    sums.add(along(g), across(g), (g.angle - angle) * kPerRadian + 2 * kDirections, g.size);
  });
  return sums.normalised();
}

}  // namespace ldp
