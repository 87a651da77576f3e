// What is behind an ldp_panorama: the file's bytes, a reader of parts, and a renderer from the first view on.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "core/base/job.h"
#include "core/panorama/file/ldp_file.h"
#include "core/view/render.h"
#include "device/library/ldp.h"

struct ldp_panorama {
  ldp_panorama(std::vector<uint8_t> file, uint64_t most_memory)
      : bytes(std::move(file)), memory_bytes(most_memory), reader(bytes) {}

  const std::vector<uint8_t> bytes;
  const uint64_t memory_bytes;  // 0 = no limit
  const ldp::LdpReader reader;  // of `bytes`
  std::mutex preparing;         // guards renderer
  std::shared_ptr<ldp::Renderer> renderer;

  const ldp::LdpDescription& description() const { return reader.description(); }
};

namespace ldp::library {

void check_memory(const ldp_panorama& panorama, uint64_t needed_bytes, const char* what);

ldp_camera camera_of(const Camera& camera);
Camera camera_from(const ldp_camera& camera);  // without a name; throws Refusal

}  // namespace ldp::library
