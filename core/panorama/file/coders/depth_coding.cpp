#include "core/panorama/file/coders/depth_coding.h"

#include <algorithm>
#include <array>
#include <cstdlib>

#include "core/panorama/file/coders/block_range_coding.h"
#include "core/panorama/file/coders/coverage_coding.h"
#include "core/panorama/file/coders/range_coder.h"

namespace ldp::file {
namespace {

// Every function here runs in the encoder and in the decoder, which differ in Coder only: coder.bit(model, value) codes
// `value` in the one and ignores it in the other, and returns the true one in both.

constexpr uint8_t kAbsent = 255;  // in rows of codes
constexpr int kGradients = 7;     // classes of a difference of codes
constexpr int kContexts = kGradients * kGradients * kGradients;

// Class of a difference of two codes: -3 .. 3, by magnitude 0, 1, 2 to 3, 4 and more; index is difference + 15.
constexpr std::array<int8_t, 31> kGradientClass = [] {
  std::array<int8_t, 31> classes{};
  for (int d = -15; d <= 15; ++d) {
    const int magnitude = d < 0 ? -d : d;
    const int level = magnitude <= 1 ? magnitude : magnitude <= 3 ? 2 : 3;
    classes[static_cast<size_t>(d + 15)] = static_cast<int8_t>(d < 0 ? -level : level);
  }
  return classes;
}();

int gradient_class(int difference) { return 3 + kGradientClass[static_cast<size_t>(difference + 15)]; }

struct CodeModels {
  std::array<std::array<BitModel, 6>, kContexts> not_first;
  std::array<std::array<BitModel, 4>, kContexts> not_second;
  std::array<BitModel, kContexts> not_third;
  std::array<BitModel, size_t{kGradients} * kGradients> upwards;
  std::array<std::array<BitModel, 15>, 6> further;
};

TileState tile_state(const Plane<uint8_t>& coverage, int tx, int ty) {
  const int x1 = std::min(coverage.width, (tx + 1) * kTile);
  const int y1 = std::min(coverage.height, (ty + 1) * kTile);
  bool any = false, all = true;
  for (int y = ty * kTile; y < y1; ++y)
    for (int x = tx * kTile; x < x1; ++x) (coverage.at(x, y) ? any : all) = coverage.at(x, y) != 0;
  return !any ? TileState::empty : all ? TileState::full : TileState::mixed;
}

// Codes around the pixel to be coded, in the range of its block, with what is absent replaced by its likeliest value.
struct Neighbours {
  int w, n, nw, ne, ww, nn;
  int absent;  // how many of w and n were
};

Neighbours complete(int w, int n, int nw, int ne, int ww, int nn) {
  Neighbours a{w, n, nw, ne, ww, nn, (w == kAbsent) + (n == kAbsent)};
  if (a.absent == 2) a.n = a.w = ne != kAbsent ? ne : nw != kAbsent ? nw : 0;
  if (a.n == kAbsent) a.n = a.w;
  if (a.w == kAbsent) a.w = nw != kAbsent ? nw : a.n;
  if (nw == kAbsent) a.nw = a.n;
  if (ne == kAbsent) a.ne = a.n;
  if (ww == kAbsent) a.ww = a.w;
  if (nn == kAbsent) a.nn = a.n;
  return a;
}

// What is left when none of the candidates holds: up or down from the first, then how far, candidates not counted.
template <typename Coder>
int code_remainder(Coder& coder, CodeModels& models, const Neighbours& a, const std::array<int, 3>& tried, int code) {
  const auto is_tried = [&](int v) { return v == tried[0] || v == tried[1] || v == tried[2]; };
  const int first = tried[0];
  int above = 0, below = 0;
  for (int v = first + 1; v < kLabels; ++v) above += !is_tried(v);
  for (int v = 0; v < first; ++v) below += !is_tried(v);
  bool up = above > 0;
  const int gradient = gradient_class(a.n - a.nw) * kGradients + gradient_class(a.w - a.nw);
  if (above > 0 && below > 0) up = coder.bit(models.upwards[static_cast<size_t>(gradient)], code > first);
  const int activity = std::max({std::abs(a.n - a.nw), std::abs(a.w - a.nw), std::abs(a.ne - a.n)});
  auto& further = models.further[static_cast<size_t>(2 * std::min(activity, 2) + up)];
  int left = up ? above : below;
  size_t passed = 0;
  for (int v = up ? first + 1 : first - 1;; v += up ? 1 : -1) {
    if (is_tried(v)) continue;
    if (--left == 0 || !coder.bit(further[passed], v != code)) return v;
    ++passed;
  }
}

template <typename Coder>
int code_pixel(Coder& coder, CodeModels& models, const Neighbours& a, int code) {
  const auto context = static_cast<size_t>(
      (gradient_class(a.n - a.nw) * kGradients + gradient_class(a.w - a.nw)) * kGradients + gradient_class(a.ne - a.n));
  const int first = std::clamp(a.w + a.n - a.nw, std::min(a.w, a.n), std::max(a.w, a.n));
  const auto sight = static_cast<size_t>(a.absent > 0 ? 3 + a.absent : (a.ww == a.w) + 2 * (a.nn == a.n));
  if (!coder.bit(models.not_first[context][sight], code != first)) return first;
  std::array<int, 3> tried = {first, first, first};
  tried[1] = first == a.w ? a.n : a.w;
  if (tried[1] != first) {
    const auto origin = static_cast<size_t>((a.w == first) + 2 * (a.n == first));
    if (!coder.bit(models.not_second[context][origin], code != tried[1])) return tried[1];
  }
  const int third = a.ne == tried[0] || a.ne == tried[1] ? a.nw : a.ne;
  if (third != tried[0] && third != tried[1]) {
    tried[2] = third;
    if (!coder.bit(models.not_third[context], code != third)) return third;
  }
  return code_remainder(coder, models, a, tried, code);
}

// A run of pixels of one row and one range. The rows above are given as codes in that range, kAbsent where there is
// none; north[-1] and north[length] are read.
struct Run {
  const uint8_t* present;
  const uint8_t* north;
  const uint8_t* north2;
  uint8_t* codes;  // codes[-2] and codes[-1]: the pixels to the left, in this range
  int length;
};

template <typename Coder>
void code_run(Coder& coder, CodeModels& models, const Run& run) {
  constexpr size_t kFlat = kContexts / 2;  // all differences 0
  int ww = run.codes[-2];
  int w = run.codes[-1];
  for (int i = 0; i < run.length; ++i) {
    const int n = run.north[i];
    const int ne = run.north[i + 1];
    const int nw = run.north[i - 1];
    const int nn = run.north2[i];
    int code = kAbsent;
    if (run.present[i]) {
      const bool flat = ((w ^ n) | (nw ^ n) | (ne ^ n) | (ww ^ n) | (nn ^ n)) == 0 && n != kAbsent;
      // The flat case is most of any picture and the only reason for this shortcut: code_pixel would do the same.
      if (flat && !coder.bit(models.not_first[kFlat][3], run.codes[i] != n))
        code = n;
      else if (flat)
        code = code_remainder(coder, models, {n, n, n, n, n, n, 0}, {n, n, n}, run.codes[i]);
      else
        code = code_pixel(coder, models, complete(w, n, nw, ne, ww, nn), run.codes[i]);
    }
    run.codes[i] = static_cast<uint8_t>(code);
    ww = w;
    w = code;
  }
}

// The code nearest in `to` to what `code` means in `from`.
uint8_t code_in(BlockRange to, BlockRange from, uint8_t code) {
  if (code == kAbsent || to == from) return code;
  const int span = to.high - to.low;
  if (span == 0) return 0;
  const int disparity = 15 * from.low + (from.high - from.low) * code;
  return static_cast<uint8_t>(std::clamp((disparity - 15 * to.low + span / 2) / span, 0, 15));
}

// Codes row by row with kAbsent where absent: two rows back and the current one, with two columns of margin.
class RowWindow {
 public:
  explicit RowWindow(int width) : rows_(width + 4, 3, kAbsent) {}
  uint8_t* current() { return rows_.row(now_) + 2; }
  const uint8_t* above() const { return rows_.row((now_ + 2) % 3) + 2; }
  const uint8_t* above2() const { return rows_.row((now_ + 1) % 3) + 2; }
  void advance() { now_ = (now_ + 1) % 3; }

 private:
  Plane<uint8_t> rows_;
  int now_ = 0;
};

template <typename Coder>
class CodeCoder {
 public:
  CodeCoder(Coder& coder, DepthStrip& strip)
      : coder_(coder),
        strip_(strip),
        window_(strip.codes.width),
        block_px_(strip.block_px > 0 ? strip.block_px : 1),
        north_(static_cast<size_t>(block_px_) + 2),
        north2_(static_cast<size_t>(block_px_)),
        codes_(static_cast<size_t>(block_px_) + 2) {}

  // False as soon as a damaged stream is seen to have ended.
  bool run() {
    for (int y = 0; y < strip_.codes.height; ++y, window_.advance()) {
      if (coder_.ended()) return false;
      uint8_t* row = strip_.codes.row(y);
      std::copy_n(row, strip_.codes.width, window_.current());
      code_row(y);
      const uint8_t* coded = window_.current();
      for (int x = 0; x < strip_.codes.width; ++x) row[x] = coded[x] == kAbsent ? 0 : coded[x];
    }
    return true;
  }

 private:
  BlockRange range(int x, int y) const {
    return strip_.block_px == 0 ? strip_.ranges.samples[0] : strip_.ranges.at(x / block_px_, y / block_px_);
  }

  void code_row(int y) {
    const int width = strip_.codes.width;
    if (strip_.block_px == 0) {
      if (range(0, 0).low == range(0, 0).high) return code_single(y, 0, width);
      code_run(coder_, models_, {strip_.coverage.row(y), window_.above(), window_.above2(), window_.current(), width});
      return;
    }
    for (int x0 = 0; x0 < width; x0 += block_px_) code_block_row(y, x0, std::min(width, x0 + block_px_));
  }

  // A range of one value needs no codes.
  void code_single(int y, int x0, int x1) {
    const uint8_t* present = strip_.coverage.row(y);
    for (int x = x0; x < x1; ++x) window_.current()[x] = present[x] ? 0 : kAbsent;
  }

  void code_block_row(int y, int x0, int x1) {
    const BlockRange own = range(x0, y);
    if (own.low == own.high) return code_single(y, x0, x1);
    const auto seen = [&](const uint8_t* row, int x, int from_y) {
      const bool inside = x >= 0 && x < strip_.codes.width && from_y >= 0;
      return inside ? code_in(own, range(x, from_y), row[x]) : kAbsent;
    };
    const int length = x1 - x0;
    for (int i = -1; i <= length; ++i) north_[static_cast<size_t>(i + 1)] = seen(window_.above(), x0 + i, y - 1);
    for (int i = 0; i < length; ++i) north2_[static_cast<size_t>(i)] = seen(window_.above2(), x0 + i, y - 2);
    codes_[0] = seen(window_.current(), x0 - 2, y);
    codes_[1] = seen(window_.current(), x0 - 1, y);
    std::copy_n(window_.current() + x0, length, codes_.begin() + 2);
    code_run(coder_, models_,
             {strip_.coverage.row(y) + x0, north_.data() + 1, north2_.data(), codes_.data() + 2, length});
    std::copy_n(codes_.begin() + 2, length, window_.current() + x0);
  }

  Coder& coder_;
  DepthStrip& strip_;
  RowWindow window_;
  int block_px_;
  std::vector<uint8_t> north_, north2_, codes_;
  CodeModels models_;
};

}  // namespace

Plane<TileState> tile_states(const Plane<uint8_t>& coverage) {
  Plane<TileState> tiles((coverage.width + kTile - 1) / kTile, (coverage.height + kTile - 1) / kTile);
  for (int y = 0; y < tiles.height; ++y)
    for (int x = 0; x < tiles.width; ++x) tiles.at(x, y) = tile_state(coverage, x, y);
  const auto empty = std::count(tiles.samples.begin(), tiles.samples.end(), TileState::empty);
  if (empty * 2 <= static_cast<std::ptrdiff_t>(tiles.samples.size()))
    std::replace(tiles.samples.begin(), tiles.samples.end(), TileState::empty, TileState::mixed);
  return tiles;
}

std::vector<uint8_t> encode_depth_strip(const DepthStrip& strip) {
  DepthStrip copy = strip;
  RangeEncoder coder;
  code_coverage(coder, copy.tiles, copy.coverage);
  if (copy.block_px > 0) code_ranges(coder, copy);
  CodeCoder(coder, copy).run();
  return coder.finish();
}

void decode_depth_strip(std::span<const uint8_t> bytes, const Place& place, DepthStrip& strip) {
  RangeDecoder coder(bytes);
  code_coverage(coder, strip.tiles, strip.coverage);
  if (strip.block_px > 0 && !code_ranges(coder, strip))
    place.refuse("block range", "0 <= low <= high <= 255", "one outside");
  if (!CodeCoder(coder, strip).run() || coder.ended())
    place.refuse("its coded data", "an end within its " + std::to_string(bytes.size()) + " bytes", "none");
  if (coder.bytes_left() > 0)
    place.refuse("its coded data", "an end after " + std::to_string(bytes.size()) + " bytes",
                 std::to_string(coder.bytes_left()) + " bytes more than were used");
}

}  // namespace ldp::file
