#include <algorithm>
#include <numeric>
#include <string>

#include "core/panorama/file/coders/alpha_coding.h"
#include "core/panorama/file/coders/colour_coding.h"
#include "core/panorama/file/coders/depth_coding.h"
#include "core/panorama/file/container.h"
#include "core/panorama/file/ldp_file.h"
#include "core/panorama/file/records.h"
#include "core/panorama/pull_push.h"
#include "core/photos/images.h"

namespace ldp::file {
namespace {

constexpr int kStripPx = 512;      // narrow enough to read parts, wide enough for models to learn
constexpr int kLessBehind = 20;    // quality of the layers behind, of which views show slivers
constexpr int kThumbnailPx = 480;  // longer side
constexpr int kThumbnailQuality = 80;

[[noreturn]] void break_off(size_t layer, const std::string& what) {
  throw std::logic_error("encode_ldp: layer " + std::to_string(layer + 1) + ": " + what);
}

template <typename T>
bool fits(const Plane<T>& plane, int width, int height) {
  return plane.width == width && plane.height == height &&
         plane.samples.size() == static_cast<size_t>(width) * static_cast<size_t>(height);
}

int blocks(int pixels, int block_px) { return block_px == 0 ? 1 : (pixels + block_px - 1) / block_px; }

// What FORMAT.md promises of a layer, so that decoding gives back what was encoded.
void check_layer(const LayeredPanorama& panorama, size_t index) {
  const Layer& layer = panorama.layers[index];
  const int width = panorama.grid.width;
  const int height = panorama.grid.height;
  const int block_px = layer.depth.block_px;
  if (!fits(layer.depth.codes, width, height) || !fits(layer.coverage, width, height) ||
      !fits(layer.colour, width, height) || !(layer.alpha.empty() || fits(layer.alpha, width, height)))
    break_off(index, "planes must be as large as the grid");
  if (block_px < 0 || block_px > kMaxLdpBlock)
    break_off(index, "block_px must be 0 to " + std::to_string(kMaxLdpBlock));
  if (!fits(layer.depth.ranges, blocks(width, block_px), blocks(height, block_px)))
    break_off(index, "wrong number of block ranges");
  for (size_t i = 0; i < layer.coverage.samples.size(); ++i) {
    const uint8_t code = layer.depth.codes.samples[i];
    if (layer.coverage.samples[i] > 1) break_off(index, "coverage must be 0 or 1");
    if (code >= kLabels || (code > 0 && !layer.coverage.samples[i]))
      break_off(index, "codes must be 0 to 15, and 0 where absent");
  }
}

// One range of one value has no codes; a block without a present pixel has no range.
void check_blocks(const DepthStrip& strip, size_t layer) {
  Plane<uint8_t> used(strip.ranges.width, strip.ranges.height);
  for (int y = 0; y < strip.codes.height; ++y)
    for (int x = 0; x < strip.codes.width; ++x) {
      if (!strip.coverage.at(x, y)) continue;
      const int bx = strip.block_px == 0 ? 0 : x / strip.block_px;
      const int by = strip.block_px == 0 ? 0 : y / strip.block_px;
      const BlockRange range = strip.ranges.at(bx, by);
      used.at(bx, by) = 1;
      if (range.low > range.high) break_off(layer, "a block's range has low > high");
      if (range.low == range.high && strip.codes.at(x, y) != 0)
        break_off(layer, "codes must be 0 where a range is one value");
    }
  for (size_t i = 0; i < used.samples.size(); ++i)
    if (strip.block_px > 0 && !used.samples[i] && strip.ranges.samples[i] != BlockRange{0, 0})
      break_off(layer, "the range of a block without a present pixel must be (0, 0)");
}

template <typename T>
Plane<T> cut_columns(const Plane<T>& plane, int begin, int end) {
  Plane<T> part(end - begin, plane.height);
  for (int y = 0; y < plane.height; ++y) std::copy(plane.row(y) + begin, plane.row(y) + end, part.row(y));
  return part;
}

int strip_px_of(const Layer& layer) {
  const int block_px = layer.depth.block_px;
  const int unit = block_px == 0 ? kTile : kTile / std::gcd(kTile, block_px) * block_px;
  return (kStripPx + unit - 1) / unit * unit;
}

DepthStrip cut_strip(const Layer& layer, int begin, int end) {
  const int block_px = layer.depth.block_px;
  DepthStrip strip;
  strip.block_px = block_px;
  strip.ranges = block_px == 0 ? layer.depth.ranges
                               : cut_columns(layer.depth.ranges, begin / block_px, (end + block_px - 1) / block_px);
  strip.coverage = cut_columns(layer.coverage, begin, end);
  strip.codes = cut_columns(layer.depth.codes, begin, end);
  strip.tiles = tile_states(strip.coverage);
  return strip;
}

struct StripJob {
  size_t layer;
  int strip;
  std::vector<uint8_t> depth, alpha, colour;
};

LdpEncodeOptions options_of_layer(LdpEncodeOptions options, size_t layer) {
  if (layer > 0 && options.colour_quality <= 100)
    options.colour_quality = std::max(1, options.colour_quality - kLessBehind);
  return options;
}

void encode_strip(const LayeredPanorama& panorama, const LdpEncodeOptions& options, StripJob& job) {
  const Layer& layer = panorama.layers[job.layer];
  const int strip_px = strip_px_of(layer);
  const int begin = job.strip * strip_px;
  const int end = std::min(panorama.grid.width, begin + strip_px);
  const DepthStrip strip = cut_strip(layer, begin, end);
  check_blocks(strip, job.layer);
  job.depth = encode_depth_strip(strip);
  if (!layer.alpha.empty()) job.alpha = encode_alpha_strip(strip.coverage, cut_columns(layer.alpha, begin, end));
  job.colour = encode_colour_strip(strip, cut_columns(layer.colour, begin, end), options_of_layer(options, job.layer));
}

std::vector<uint8_t> write_layer_record(const Layer& layer) {
  LayerRecord record;
  record.summary.block_px = layer.depth.block_px;
  record.summary.strip_px = strip_px_of(layer);
  record.summary.has_alpha = !layer.alpha.empty();
  record.summary.present_pixels =
      static_cast<uint64_t>(std::count(layer.coverage.samples.begin(), layer.coverage.samples.end(), 1));
  record.range = layer.depth.block_px == 0 ? layer.depth.ranges.samples[0] : BlockRange{0, 0};
  if (record.range.low > record.range.high) throw std::logic_error("encode_ldp: a layer's range has low > high");
  return write_layer_record(record);
}

// What is seen first in a square of k x k pixels from (x, y) on, weighed by how much of it is.
WeightedColour mean_seen(const LayeredPanorama& panorama, int x, int y, int k) {
  const Plane<uint8_t>& grid = panorama.layers[0].coverage;
  uint32_t r = 0, g = 0, b = 0, seen = 0, all = 0;
  for (int sy = y; sy < std::min(grid.height, y + k); ++sy)
    for (int sx = x; sx < std::min(grid.width, x + k); ++sx) {
      ++all;
      const size_t pixel = grid.index(sx, sy);
      const Layer* layer = panorama.seen_first(pixel);
      if (layer == nullptr) continue;
      const Rgb c = layer->colour.samples[pixel];
      r += c.r, g += c.g, b += c.b, ++seen;
    }
  if (seen == 0) return {};
  const auto mean = [seen](uint32_t sum) { return static_cast<float>(sum) / static_cast<float>(seen); };
  return {mean(r), mean(g), mean(b), static_cast<float>(seen) / static_cast<float>(all)};
}

// Averaged over squares; what no photograph shows is filled from around it.
std::vector<uint8_t> make_thumbnail(const LayeredPanorama& panorama) {
  const int width = panorama.grid.width, height = panorama.grid.height;
  const int k = (std::max(width, height) + kThumbnailPx - 1) / kThumbnailPx;
  Plane<WeightedColour> small(std::max(1, width / k), std::max(1, height / k));
  for (int y = 0; y < small.height; ++y)
    for (int x = 0; x < small.width; ++x) small.at(x, y) = mean_seen(panorama, x * k, y * k, k);
  fill_by_pull_push(small);
  RgbImage image(small.width, small.height);
  std::transform(small.samples.begin(), small.samples.end(), image.samples.begin(), rounded);
  return encode_jpeg(image, kThumbnailQuality);
}

void check_options(const LdpEncodeOptions& options) {
  if (options.colour_quality < 1 || options.colour_quality > 101)
    throw std::logic_error("colour_quality must be 1 to 101, not " + std::to_string(options.colour_quality));
  if (options.colour_quality == 101 && options.codec == LdpCodec::jpeg)
    throw std::logic_error("JPEG cannot be lossless: leave the codec open or choose WebP");
}

// Written, then read: what a reader would refuse must not be written.
std::vector<NewChunk> write_records(const LayeredPanorama& panorama) {
  std::vector<NewChunk> chunks;
  chunks.push_back(
      {"HEAD", -1, -1, write_head({panorama.grid, panorama.limits, static_cast<int>(panorama.layers.size())})});
  read_head(ByteReader(chunks.back().bytes, {"encode_ldp: HEAD", 0}), {});
  for (size_t i = 0; i < panorama.layers.size(); ++i) {
    check_layer(panorama, i);
    chunks.push_back({"LAYR", static_cast<int>(i), -1, write_layer_record(panorama.layers[i])});
  }
  chunks.push_back({"thmb", -1, -1, make_thumbnail(panorama)});
  chunks.push_back({"cams", -1, -1, write_cameras(panorama.cameras)});
  read_cameras(ByteReader(chunks.back().bytes, {"encode_ldp: cams", 0}));
  chunks.push_back({"qual", -1, -1, write_quality(panorama.quality)});
  chunks.push_back({"meta", -1, -1, write_metadata(panorama.metadata)});
  if (!panorama.exposure.empty()) {
    chunks.push_back({"expo", -1, -1, write_exposure(panorama.exposure)});
    read_exposure(ByteReader(chunks.back().bytes, {"encode_ldp: expo", 0}), panorama.grid);
  }
  return chunks;
}

}  // namespace
}  // namespace ldp::file

namespace ldp {

using namespace file;

std::vector<uint8_t> encode_ldp(const LayeredPanorama& panorama, const LdpEncodeOptions& options, const Job& job) {
  check_options(options);
  if (panorama.layers.empty() || panorama.layers.size() > kMaxLdpLayers)
    throw std::logic_error("encode_ldp: 1 to 8 layers, not " + std::to_string(panorama.layers.size()));
  std::vector<NewChunk> chunks = write_records(panorama);
  std::vector<StripJob> strips;
  for (size_t layer = 0; layer < panorama.layers.size(); ++layer)
    for (int strip = 0; strip < strip_count(panorama.grid, strip_px_of(panorama.layers[layer])); ++strip)
      strips.push_back({layer, strip, {}, {}, {}});
  parallel_for(job, static_cast<int>(strips.size()),
               [&](int i) { encode_strip(panorama, options, strips[static_cast<size_t>(i)]); });
  const auto add = [&](const char* type, std::vector<uint8_t> StripJob::*bytes) {
    for (StripJob& strip : strips)
      if (!(strip.*bytes).empty())
        chunks.push_back({type, static_cast<int>(strip.layer), strip.strip, std::move(strip.*bytes)});
  };
  int version = 1;
  for (const StripJob& strip : strips) version = std::max(version, version_of_colour(strip.colour));
  add("DPTH", &StripJob::depth);
  add("ALPH", &StripJob::alpha);
  add("COLR", &StripJob::colour);
  std::vector<uint8_t> file = write_container(chunks, version);
  check_work({panorama.grid, panorama.limits, static_cast<int>(panorama.layers.size())}, file.size(),
             {"encode_ldp: HEAD", 0});
  return file;
}

}  // namespace ldp
