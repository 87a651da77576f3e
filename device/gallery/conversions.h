// Panoramas in other forms (core/export), made when somebody asks for them. One is made at a time, the last ones are
// kept, and what is kept is bounded.
#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "core/base/job.h"
#include "device/gallery/folder.h"

namespace ldp::gallery {

struct ConversionLimits {
  uint64_t memory_bytes = uint64_t{512} << 20;  // that making one may take; a file that needs more is refused
  uint64_t kept_bytes = uint64_t{32} << 20;     // of results
  int waiting = 4;                              // requests that wait for one that is being made; more are sent away
};

using SharedBytes = std::shared_ptr<const std::vector<uint8_t>>;

class Conversions {
 public:
  Conversions(const ConversionLimits& limits, const Job& job) : limits_(limits), job_(job) {}

  // `ending`: one that core/export knows, ".glb". nullptr: too many wait already. Throws std::runtime_error naming what
  // is wrong with the file, Impossible if it takes too much memory.
  SharedBytes convert(const OpenFile& file, const std::string& ending);

 private:
  struct Kept {
    std::string key;
    SharedBytes bytes;
  };

  SharedBytes find(const std::string& key);
  void keep(const std::string& key, const SharedBytes& bytes);

  ConversionLimits limits_;
  Job job_;
  std::mutex making_, mutex_;  // mutex_: of what follows
  int waiting_ = 0;
  std::list<Kept> kept_;  // used last first
};

}  // namespace ldp::gallery
