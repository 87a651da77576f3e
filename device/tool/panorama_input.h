// The .ldp file a command was given, and how much memory may be used for it: a small file may declare a large panorama.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/base/job.h"
#include "core/panorama/panorama.h"

namespace ldp {

struct PanoramaInput {
  std::string file;
  uint64_t memory_bytes = 0;  // that may be used; 0 = three quarters of what the machine has
};

// What a command holds beside the panorama, in bytes.
struct BytesBeside {
  uint64_t per_pixel = 0;          // of the grid, for every layer
  uint64_t per_pixel_once = 0;     // of the grid, for all layers together
  uint64_t per_present_pixel = 0;  // as the file tells them, and decoding checks
  uint64_t always = 0;
};

// Throws Impossible, with what it is that needs them, if it needs more bytes than may be used.
void check_memory(const PanoramaInput& input, uint64_t needed_bytes, const std::string& what);

void add_panorama_input(CLI::App& command, PanoramaInput& input);  // FILE and --memory

// Throws BadInput naming the file: missing, not an .ldp file, or damaged; Impossible if it takes more memory than may
// be used.
LayeredPanorama read_panorama(const PanoramaInput& input, const BytesBeside& beside, const Job& job);

// The same of bytes that were read from the file already.
LayeredPanorama decode_panorama(const PanoramaInput& input, std::span<const uint8_t> bytes, const BytesBeside& beside,
                                const Job& job);

// What to tell of bytes that are refused, of which `damage` was said, and what to do: those of an empty file, or of a
// file of another kind, are not damaged.
std::string refusal_of(std::span<const uint8_t> bytes, const std::string& damage);

// Every damage found, one line each. Throws as above, but for damage.
std::vector<std::string> verify_panorama(const PanoramaInput& input, std::span<const uint8_t> bytes, const Job& job);

}  // namespace ldp
