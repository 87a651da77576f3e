#include "core/panorama/file/coders/alpha_coding.h"

#include <array>

#include "core/panorama/file/coders/range_coder.h"

namespace ldp::file {
namespace {

struct AlphaModels {
  std::array<BitModel, 16> not_opaque, not_clear;
  std::array<std::array<BitModel, 256>, 4> digit;
};

struct Neighbour {
  bool present;
  int alpha;

  size_t kind() const { return !present ? 0 : alpha == 0 ? 1 : alpha == 255 ? 3 : 2; }
};

// Eight binary digits, the highest first, each with those before it as context.
template <typename Coder>
uint8_t code_digits(Coder& coder, std::array<BitModel, 256>& models, uint8_t value) {
  size_t node = 1;
  for (int i = 7; i >= 0; --i) node = node << 1 | static_cast<size_t>(coder.bit(models[node], (value >> i & 1) != 0));
  return static_cast<uint8_t>(node & 255);
}

template <typename Coder>
uint8_t code_pixel(Coder& coder, AlphaModels& models, const Neighbour& w, const Neighbour& n, uint8_t value) {
  const size_t context = 4 * w.kind() + n.kind();
  if (!coder.bit(models.not_opaque[context], value != 255)) return 255;
  if (!coder.bit(models.not_clear[context], value != 0)) return 0;
  const int expected = w.present && n.present ? (w.alpha + n.alpha) / 2
                       : w.present            ? w.alpha
                       : n.present            ? n.alpha
                                              : 128;
  return code_digits(coder, models.digit[static_cast<size_t>(expected >> 6)], value);
}

template <typename Coder>
bool code_alpha(Coder& coder, const Plane<uint8_t>& coverage, Plane<uint8_t>& alpha) {
  AlphaModels models;
  for (int y = 0; y < alpha.height; ++y) {
    if (coder.ended()) return false;
    for (int x = 0; x < alpha.width; ++x) {
      if (!coverage.at(x, y)) continue;
      const auto at = [&](int px, int py) {
        const bool present = px >= 0 && py >= 0 && coverage.at(px, py) != 0;
        return Neighbour{present, present ? alpha.at(px, py) : 0};
      };
      const Neighbour west = at(x - 1, y);
      const Neighbour north = at(x, y - 1);
      alpha.at(x, y) = code_pixel(coder, models, west, north, alpha.at(x, y));
    }
  }
  return true;
}

}  // namespace

std::vector<uint8_t> encode_alpha_strip(const Plane<uint8_t>& coverage, const Plane<uint8_t>& alpha) {
  Plane<uint8_t> copy = alpha;
  RangeEncoder coder;
  code_alpha(coder, coverage, copy);
  return coder.finish();
}

Plane<uint8_t> decode_alpha_strip(std::span<const uint8_t> bytes, const Place& place, const Plane<uint8_t>& coverage) {
  Plane<uint8_t> alpha(coverage.width, coverage.height);
  RangeDecoder coder(bytes);
  if (!code_alpha(coder, coverage, alpha) || coder.ended() || coder.bytes_left() > 0)
    place.refuse("its coded data", "an end after " + std::to_string(bytes.size()) + " bytes", "another");
  return alpha;
}

}  // namespace ldp::file
