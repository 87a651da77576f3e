// What the gallery tells of every panorama without decoding it: size, date, verdict, thumbnail.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "device/gallery/folder.h"

namespace ldp::gallery {

struct Card {
  std::string name;
  FileVersion version;               // none: it could not be read this time
  std::string captured_utc, device;  // empty: not told
  int degrees = 0, width = 0, height = 0, layers = 0;
  std::string verdict, verdict_text;    // of programs, and a sentence; empty: not judged
  std::string trouble;                  // why it cannot be shown; empty: it can
  std::vector<uint8_t> thumbnail_jpeg;  // or empty
};
using SharedCard = std::shared_ptr<const Card>;

// Read once a version of a file; any thread.
class Cards {
 public:
  explicit Cards(const Folder& folder) : folder_(folder) {}

  std::vector<SharedCard> newest_first();
  SharedCard of(const std::string& name);  // nullptr: no such panorama

 private:
  SharedCard read(const std::string& name);

  const Folder& folder_;
  std::mutex mutex_;
  std::map<std::string, SharedCard> known_;
};

}  // namespace ldp::gallery
