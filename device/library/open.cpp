#include <filesystem>
#include <span>

#include "core/base/files.h"
#include "device/library/doors.h"
#include "device/library/panorama_handle.h"

namespace ldp::library {
namespace {

[[noreturn]] void refuse_limit(const std::string& what, uint64_t needed, uint64_t allowed, const char* unit) {
  throw Refusal(LDP_BEYOND_LIMITS,
                what + " " + std::to_string(needed) + " " + unit + ", allowed are " + std::to_string(allowed));
}

ldp_limits limits_or_none(const ldp_limits* limits) {
  return limits == nullptr ? LDP_INIT(ldp_limits) : taken(limits, "limits");
}

ldp_panorama* opened(std::vector<uint8_t> bytes, const ldp_limits& limits) {
  auto panorama = std::make_unique<ldp_panorama>(std::move(bytes), limits.memory_bytes);
  const PanoramaGrid& grid = panorama->description().panorama.grid;
  const uint64_t pixels = static_cast<uint64_t>(grid.width) * static_cast<uint64_t>(grid.height);
  if (limits.pixels > 0 && pixels > limits.pixels) refuse_limit("its grid has", pixels, limits.pixels, "pixels");
  return panorama.release();
}

// Before anything of it is in memory.
void check_file(const char* path, const ldp_limits& limits) {
  const std::filesystem::file_status status = std::filesystem::status(path);
  if (std::filesystem::is_directory(status) || std::filesystem::is_other(status))
    throw Refusal(LDP_NOT_READABLE, "is no regular file");
  if (!std::filesystem::is_regular_file(status)) return;  // reading says why
  const uint64_t bytes = std::filesystem::file_size(path);
  if (limits.memory_bytes > 0 && bytes > limits.memory_bytes)
    refuse_limit("the file has", bytes, limits.memory_bytes, "bytes");
}

}  // namespace

void check_memory(const ldp_panorama& panorama, uint64_t needed_bytes, const char* what) {
  const uint64_t needed = panorama.bytes.size() + needed_bytes;
  if (panorama.memory_bytes > 0 && needed > panorama.memory_bytes)
    refuse_limit(std::string(what) + " may need", needed, panorama.memory_bytes, "bytes");
}

}  // namespace ldp::library

using namespace ldp::library;

ldp_status ldp_open_file(const char* path, const ldp_limits* limits, ldp_panorama** panorama, ldp_error* error) {
  const auto attempted = [&] { return "open " + std::string(&required(path, "path")); };
  return guarded(attempted, error, [&] {
    const ldp_limits most = limits_or_none(limits);
    required(panorama, "panorama");
    check_file(path, most);
    *panorama = opened(ldp::read_file(path), most);
  });
}

ldp_status ldp_open_memory(const void* bytes, size_t count, const ldp_limits* limits, ldp_panorama** panorama,
                           ldp_error* error) {
  return guarded("open a panorama in memory", error, [&] {
    const ldp_limits most = limits_or_none(limits);
    required(panorama, "panorama");
    const auto* const first = static_cast<const uint8_t*>(bytes);
    if (first == nullptr) throw Refusal(LDP_BAD_ARGUMENT, "bytes is a null pointer");
    if (most.memory_bytes > 0 && count > most.memory_bytes)
      refuse_limit("there are", count, most.memory_bytes, "bytes");
    *panorama = opened({first, first + count}, most);
  });
}

void ldp_close(ldp_panorama* panorama) { delete panorama; }
