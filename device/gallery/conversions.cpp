#include "device/gallery/conversions.h"

#include <algorithm>

#include "core/base/files.h"
#include "core/export/export.h"
#include "core/panorama/file/ldp_file.h"

namespace ldp::gallery {
namespace {

// Of a panorama's present pixels and of its grid, beside what decoding takes (as `ldp export` measures it).
constexpr uint64_t kBytesPerPresentPixel = 64, kBytesPerPixel = 5;

uint64_t needed_bytes(const LdpDescription& description, int threads) {
  const PanoramaGrid& grid = description.panorama.grid;
  uint64_t bytes = decoding_bytes(description, threads);
  for (const LdpLayerSummary& layer : description.layers)
    bytes += kBytesPerPixel * static_cast<uint64_t>(grid.width) * static_cast<uint64_t>(grid.height) +
             kBytesPerPresentPixel * layer.present_pixels;
  return bytes;
}

SharedBytes make(const OpenFile& file, const std::string& ending, uint64_t memory_bytes, const Job& job) {
  const MappedFile mapped("/proc/self/fd/" + std::to_string(file.fd.get()));
  if (needed_bytes(describe_ldp(mapped.bytes()), job.threads) > memory_bytes)
    throw Impossible("the panorama is too large to be converted here: download it and use ldp export");
  const LayeredPanorama panorama = decode_ldp(mapped.bytes(), {}, job);
  return std::make_shared<const std::vector<uint8_t>>(
      export_as("panorama" + ending, panorama, mapped.bytes(), {}, job));
}

}  // namespace

SharedBytes Conversions::find(const std::string& key) {
  const auto found = std::find_if(kept_.begin(), kept_.end(), [&](const Kept& kept) { return kept.key == key; });
  if (found == kept_.end()) return nullptr;
  kept_.splice(kept_.begin(), kept_, found);
  return found->bytes;
}

void Conversions::keep(const std::string& key, const SharedBytes& bytes) {
  kept_.push_front({key, bytes});
  uint64_t sum = 0;
  std::erase_if(kept_, [&](const Kept& kept) { return (sum += kept.bytes->size()) > limits_.kept_bytes; });
}

SharedBytes Conversions::convert(const OpenFile& file, const std::string& ending) {
  const std::string key = etag_of(file.version) + ending;
  {
    const std::lock_guard lock(mutex_);
    if (SharedBytes bytes = find(key)) return bytes;
    if (waiting_ >= limits_.waiting) return nullptr;
    ++waiting_;
  }
  const std::unique_ptr<int, std::function<void(int*)>> place(&waiting_, [this](int* waiting) {
    const std::lock_guard lock(mutex_);
    --*waiting;
  });
  const std::lock_guard making(making_);
  {
    const std::lock_guard lock(mutex_);
    if (SharedBytes bytes = find(key)) return bytes;  // somebody else's request made it meanwhile
  }
  SharedBytes bytes = make(file, ending, limits_.memory_bytes, job_);
  const std::lock_guard lock(mutex_);
  keep(key, bytes);
  return bytes;
}

}  // namespace ldp::gallery
