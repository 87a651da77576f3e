// The part of a file that a request asks for (RFC 9110, section 14): one range; of more, or of another unit, all is
// sent.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace ldp::gallery {

struct ByteRange {
  uint64_t begin = 0, end = 0;  // begin <= byte < end
};

struct RangeAnswer {
  int status = 200;  // 206 for a part, 416 where nothing of the file is asked for
  ByteRange range;
};

// `header`: what stands behind "Range:", empty if nothing does.
RangeAnswer range_of(std::string_view header, uint64_t bytes);

}  // namespace ldp::gallery
