#include "device/tool/panorama_input.h"

#include <unistd.h>

#include <cstdio>

#include "core/base/files.h"
#include "core/panorama/file/ldp_file.h"
#include "device/tool/memory_size.h"
#include "device/tool/output.h"
#include "device/tool/session.h"

namespace ldp {
namespace {

uint64_t allowed_bytes(const PanoramaInput& input) {
  if (input.memory_bytes > 0) return input.memory_bytes;
  return static_cast<uint64_t>(::sysconf(_SC_PHYS_PAGES)) / 4 * 3 * static_cast<uint64_t>(::sysconf(_SC_PAGESIZE));
}

std::string megabytes(uint64_t bytes) {
  char text[32];
  std::snprintf(text, sizeof text, "%.0f MB", static_cast<double>(bytes) * 1e-6);
  return text;
}

std::string what_it_is(const LdpDescription& description) {
  const PanoramaGrid& grid = description.panorama.grid;
  return std::to_string(grid.width) + "x" + std::to_string(grid.height) + " pixels in " +
         std::to_string(description.layers.size()) + " layers";
}

uint64_t bytes_beside(const LdpDescription& description, const BytesBeside& beside) {
  const PanoramaGrid& grid = description.panorama.grid;
  const uint64_t pixels = static_cast<uint64_t>(grid.width) * static_cast<uint64_t>(grid.height);
  uint64_t bytes = beside.always + beside.per_pixel_once * pixels;
  for (const LdpLayerSummary& layer : description.layers)
    bytes += beside.per_pixel * pixels + beside.per_present_pixel * layer.present_pixels;
  return bytes;
}

}  // namespace

void check_memory(const PanoramaInput& input, uint64_t needed_bytes, const std::string& what) {
  const uint64_t allowed = allowed_bytes(input);
  if (needed_bytes <= allowed) return;
  throw Impossible(input.file + ": " + what + " may need " + megabytes(needed_bytes) + ", allowed are " +
                   megabytes(allowed) + ": allow more (--memory), or use a machine that has more");
}

void add_panorama_input(CLI::App& command, PanoramaInput& input) {
  command.add_option("FILE", input.file, "The .ldp file")->required();
  command
      .add_option("--memory", input.memory_bytes,
                  "Memory that may be used, such as 512M: a file that needs more is refused; 0 = three quarters of the "
                  "machine's")
      ->transform(memory_size("three quarters of the machine's"))
      ->default_str("0");
}

LayeredPanorama read_panorama(const PanoramaInput& input, const BytesBeside& beside, const Job& job) {
  check_input_file(input.file);
  const MappedFile mapped(input.file);
  return decode_panorama(input, mapped.bytes(), beside, job);
}

LayeredPanorama decode_panorama(const PanoramaInput& input, std::span<const uint8_t> bytes, const BytesBeside& beside,
                                const Job& job) {
  try {
    const LdpDescription description = describe_ldp(bytes);
    check_memory(input, decoding_bytes(description, job.threads) + bytes_beside(description, beside),
                 what_it_is(description));
    return decode_ldp(bytes, {}, job);
  } catch (const LdpError& error) {
    throw BadInput(input.file + ": " + refusal_of(bytes, error.what()));
  }
}

std::string refusal_of(std::span<const uint8_t> bytes, const std::string& damage) {
  if (bytes.empty()) return "the file is empty: build the panorama again, or give another file";
  if (!begins_as_ldp(bytes)) return "is no .ldp file: give one that ldp build made";
  return damage + ": copy the file again, or build the panorama again";
}

std::vector<std::string> verify_panorama(const PanoramaInput& input, std::span<const uint8_t> bytes, const Job& job) {
  try {
    const LdpDescription description = describe_ldp(bytes);
    check_memory(input, verifying_bytes(description), what_it_is(description));
  } catch (const LdpError&) {
    // which is among what is told
  }
  return verify_ldp(bytes, job);
}

}  // namespace ldp
