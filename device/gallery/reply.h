// A request and what is answered, without the network.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "device/gallery/byte_range.h"
#include "device/gallery/conversions.h"
#include "drivers/interface/unique_fd.h"

namespace ldp::gallery {

struct Asked {
  std::string method, path;                               // decoded, without the query
  std::function<std::string(const std::string&)> header;  // its value, empty where there is none
};

struct Reply {
  int status = 200;
  std::string type = "text/plain; charset=utf-8";
  std::vector<std::pair<std::string, std::string>> headers;
  std::string text;                // the body, where it is neither of the next two
  std::shared_ptr<UniqueFd> file;  // its bytes of `range`
  SharedBytes bytes;               // those of `range`
  ByteRange range;
  bool follows = false;  // the live feed goes on where the head ends
};

}  // namespace ldp::gallery
