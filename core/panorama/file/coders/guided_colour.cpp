#include "core/panorama/file/coders/guided_colour.h"

#include <algorithm>
#include <vector>

namespace ldp::file {
namespace {

constexpr int kPixels = 4;       // of a block
constexpr int kBlocks = 9;       // from which a slope is estimated
constexpr int kPlain = 1 << 14;  // as much variance of luma, in the sums that follow: half of the slope is believed
constexpr int kSlope = 256;      // a difference rises as luma does
constexpr int kMaxSlope = 2 * kSlope;
constexpr int kWeights = 16;  // of linear interpolation: 9, 3, 3 and 1

int luma_of(Rgb c) { return (77 * c.r + 150 * c.g + 29 * c.b + 128) >> 8; }
int of_green(int of_red, int of_blue) { return -(77 * of_red + 29 * of_blue) / 150; }  // so that luma stays
uint8_t level(int value) { return static_cast<uint8_t>(std::clamp(value, 0, 255)); }

// Sums over the pixels of blocks of 2 x 2.
struct Blocks {
  Plane<int16_t> luma, red, blue;  // of the latter the difference from luma

  explicit Blocks(const RgbImage& image) : luma(image.width / 2, image.height / 2), red(luma), blue(luma) {
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x) {
        const Rgb c = image.at(x, y);
        const int grey = luma_of(c);
        const size_t i = luma.index(x / 2, y / 2);
        luma.samples[i] = static_cast<int16_t>(luma.samples[i] + grey);
        red.samples[i] = static_cast<int16_t>(red.samples[i] + c.r - grey);
        blue.samples[i] = static_cast<int16_t>(blue.samples[i] + c.b - grey);
      }
  }
};

struct Moments {
  int luma = 0, square = 0, red = 0, red_product = 0, blue = 0, blue_product = 0;

  void add(const Moments& m) {
    luma += m.luma, square += m.square;
    red += m.red, red_product += m.red_product;
    blue += m.blue, blue_product += m.blue_product;
  }
};

int16_t slope(const Moments& m, int difference, int product) {
  const int variance = kBlocks * m.square - m.luma * m.luma, covariance = kBlocks * product - m.luma * difference;
  // A quarter more: differences that have been interpolated are flatter than they were.
  const int ratio = covariance * 5 / ((variance + kPlain) / (kSlope / 4));
  return static_cast<int16_t>(std::clamp(ratio, -kMaxSlope, kMaxSlope));
}

struct Slopes {
  Plane<int16_t> red, blue;
};

Slopes slopes_of(const Blocks& blocks) {
  const int width = blocks.luma.width, height = blocks.luma.height;
  Slopes slopes{Plane<int16_t>(width, height), Plane<int16_t>(width, height)};
  std::vector<Moments> columns(static_cast<size_t>(width) + 2);  // of three rows; outside the outer ones are repeated
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      Moments m;
      for (const int row : {std::max(y - 1, 0), y, std::min(y + 1, height - 1)}) {
        const int luma = blocks.luma.at(x, row), red = blocks.red.at(x, row), blue = blocks.blue.at(x, row);
        m.add({luma, luma * luma, red, luma * red, blue, luma * blue});
      }
      columns[static_cast<size_t>(x) + 1] = m;
    }
    columns.front() = columns[1];
    columns.back() = columns[static_cast<size_t>(width)];
    for (int x = 0; x < width; ++x) {
      Moments m = columns[static_cast<size_t>(x)];
      m.add(columns[static_cast<size_t>(x) + 1]);
      m.add(columns[static_cast<size_t>(x) + 2]);
      slopes.red.at(x, y) = slope(m, m.red, m.red_product);
      slopes.blue.at(x, y) = slope(m, m.blue, m.blue_product);
    }
  }
  return slopes;
}

using Row = std::vector<int>;

// Of blocks, for each pixel of row y [kWeights].
void interpolate(const Plane<int16_t>& blocks, int y, Row& out) {
  const int near = y / 2, far = std::clamp(y % 2 == 0 ? near - 1 : near + 1, 0, blocks.height - 1);
  const int16_t *near_row = blocks.row(near), *far_row = blocks.row(far);
  const auto count = static_cast<size_t>(blocks.width);
  Row column(count + 2);
  for (size_t x = 0; x < count; ++x) column[x + 1] = 3 * near_row[x] + far_row[x];
  column.front() = column[1];
  column.back() = column[count];
  out.resize(2 * count);
  for (size_t x = 0; x < count; ++x) {
    out[2 * x] = 3 * column[x + 1] + column[x];
    out[2 * x + 1] = 3 * column[x + 1] + column[x + 2];
  }
}

// Differences from luma as a codec of 4:2:0 gives them back: means of blocks, interpolated.
RgbImage halved(const RgbImage& image) {
  constexpr int kUnit = kWeights * kPixels;
  const Blocks blocks(image);
  RgbImage out(image.width, image.height);
  Row red, blue;
  for (int y = 0; y < image.height; ++y) {
    interpolate(blocks.red, y, red);
    interpolate(blocks.blue, y, blue);
    for (int x = 0; x < image.width; ++x) {
      const auto i = static_cast<size_t>(x);
      const int luma = kUnit * luma_of(image.at(x, y)) + kUnit / 2;
      out.at(x, y) = {level((luma + red[i]) / kUnit), level((luma + of_green(red[i], blue[i])) / kUnit),
                      level((luma + blue[i]) / kUnit)};
    }
  }
  return out;
}

}  // namespace

RgbImage guide_colour(const RgbImage& decoded) {
  constexpr int kRise = kWeights * kPixels, kUnit = kWeights * kSlope * kRise;
  const Blocks blocks(decoded);
  const Slopes slopes = slopes_of(blocks);
  RgbImage out(decoded.width, decoded.height);
  Row luma, red, blue;
  for (int y = 0; y < out.height; ++y) {
    interpolate(blocks.luma, y, luma);
    interpolate(slopes.red, y, red);
    interpolate(slopes.blue, y, blue);
    for (int x = 0; x < out.width; ++x) {
      const auto i = static_cast<size_t>(x);
      const Rgb c = decoded.at(x, y);
      const int rise = kRise * luma_of(c) - luma[i];
      const auto moved = [rise](int value, int slope) { return level(value + ((slope * rise + kUnit / 2) >> 18)); };
      static_assert(kUnit == 1 << 18);
      out.at(x, y) = {moved(c.r, red[i]), moved(c.g, of_green(red[i], blue[i])), moved(c.b, blue[i])};
    }
  }
  return out;
}

RgbImage made_for_guiding(const RgbImage& image) {
  const Blocks wanted(image), found(guide_colour(halved(image)));
  RgbImage out = image;
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) {
      const size_t i = wanted.red.index(x / 2, y / 2);
      const int red = wanted.red.samples[i] - found.red.samples[i],
                blue = wanted.blue.samples[i] - found.blue.samples[i];
      const auto moved = [](int value, int lack) { return level(value + ((lack + kPixels / 2) >> 2)); };
      static_assert(kPixels == 1 << 2);
      Rgb& c = out.at(x, y);
      c = {moved(c.r, red), moved(c.g, of_green(red, blue)), moved(c.b, blue)};
    }
  return out;
}

}  // namespace ldp::file
