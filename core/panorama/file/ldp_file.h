// The .ldp file (format: FORMAT.md in this folder): encoding, decoding whole or in part, describing and verifying.
//
// Errors: LdpError, whose message names the chunk, its offset, what was expected and what was found. Every limit is
// checked before allocation. decode(encode(p)) returns depth codes, coverage and alpha of present pixels exactly
// (absent ones are 0); colour as the codec keeps it, exactly when lossless.
#pragma once

#include <cstdint>
#include <memory>
#include <set>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/base/job.h"
#include "core/panorama/panorama.h"

namespace ldp {

struct LdpError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

constexpr int kLdpVersion = 2;  // the newest; a file gets the first version that has what it uses
constexpr int kMaxLdpWidth = 65535, kMaxLdpHeight = 16368;  // the latter so that any strip is a WebP image
constexpr int64_t kMaxLdpPixels = int64_t{1} << 28;
constexpr bool fits_ldp(int width, int height) {
  return width <= kMaxLdpWidth && height <= kMaxLdpHeight && int64_t{width} * height <= kMaxLdpPixels;
}
constexpr int kMaxLdpLayers = 8;
// Pixels of all layers together: so many in any file, and more with every byte of it. What decoding takes is thereby
// bounded by what a file says, not by what it claims; a photographed panorama has some ten pixels a byte.
constexpr int64_t kEasyLdpPixels = int64_t{1} << 26, kMaxLdpPixelsPerByte = 256;
constexpr int kMaxLdpBlock = 256;
constexpr int kMaxLdpStrip = 8192;

enum class LdpCodec : uint8_t { none = 0, jpeg = 1, webp = 2 };
enum class ColourCoding { webp, webp_lossless, jpeg };  // of what is there, in either layout

struct LdpEncodeOptions {
  int colour_quality = 90;  // of the front layer, 1 .. 100; those behind get 20 less; 101 = all lossless
  // none = chosen by quality: WebP, which is a third smaller, up to 96; JPEG, whose colour can have full resolution,
  // from 97 to 100; WebP for lossless.
  LdpCodec codec = LdpCodec::none;
};

struct LdpChunk {
  std::string type;  // four characters
  int layer = -1;    // -1 = belongs to the whole file
  int strip = -1;    // -1 = belongs to the whole layer
  uint64_t offset = 0, length = 0;
  uint32_t crc32c = 0;
};

// What is known of a layer without decoding it.
struct LdpLayerSummary {
  int block_px = 0;
  int strip_px = 0;
  bool has_alpha = false;
  uint64_t present_pixels = 0;
};

struct LdpDescription {
  int version = 0;
  uint64_t file_bytes = 0;
  std::vector<LdpChunk> chunks;
  std::vector<LdpLayerSummary> layers;
  LayeredPanorama panorama;        // everything but the layers
  std::vector<uint8_t> thumbnail;  // a JPEG file, or empty
};

// What a reader is ready to hold: a device with little memory refuses what would not fit.
struct LdpReadLimits {
  int64_t max_pixels = kMaxLdpPixels;  // of the grid
};

struct LdpColumns {
  int begin = 0, end = 0;  // begin <= column < end
};

// Reads parts of a file without the rest. The bytes (a mapped file, say) must outlive the reader.
class LdpReader {
 public:
  explicit LdpReader(std::span<const uint8_t> bytes, const LdpReadLimits& limits = {});
  ~LdpReader();
  LdpReader(LdpReader&&) noexcept;
  LdpReader& operator=(LdpReader&&) noexcept;

  const LdpDescription& description() const;

  // All that its strips have, without decoding them; empty for a layer without a pixel.
  std::set<ColourCoding> colour_codings(int layer) const;

  // One layer, or its columns [begin, end): planes of that width; ranges of the blocks that overlap it, so that with
  // block_px > 0 begin must be a multiple of block_px. Only strips that overlap are decoded. Without colour, the colour
  // plane is empty.
  Layer read_layer(int layer, const Job& job = {}) const;
  Layer read_layer(int layer, const LdpColumns& columns, bool with_colour, const Job& job = {}) const;

  // Throws unless a whole layer has as many present pixels as the file says.
  void check_present(int layer, uint64_t found) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

std::vector<uint8_t> encode_ldp(const LayeredPanorama& panorama, const LdpEncodeOptions& options, const Job& job = {});
LayeredPanorama decode_ldp(std::span<const uint8_t> bytes, const LdpReadLimits& limits = {}, const Job& job = {});
LdpDescription describe_ldp(std::span<const uint8_t> bytes);  // decodes no layer
bool begins_as_ldp(std::span<const uint8_t> bytes);           // else they are of another kind of file, not damaged
std::vector<std::string> verify_ldp(std::span<const uint8_t> bytes,
                                    const Job& job = {});  // every damage found, one line each; empty = sound

// The most bytes that decode_ldp and verify_ldp hold at a time, the file's own apart. Known from the description, so
// that a file from elsewhere can be refused before it is decoded: a kilobyte may declare gigabytes.
uint64_t decoding_bytes(const LdpDescription& description, int threads);
uint64_t verifying_bytes(const LdpDescription& description);

}  // namespace ldp
