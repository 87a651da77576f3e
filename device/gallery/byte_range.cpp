#include "device/gallery/byte_range.h"

#include <algorithm>
#include <charconv>

namespace ldp::gallery {
namespace {

// Digits alone; none for anything else. What is too great for 64 bits is the greatest.
std::optional<uint64_t> number_in(std::string_view text) {
  if (text.empty() || !std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; }))
    return std::nullopt;
  uint64_t number = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), number);
  return read.ec == std::errc::result_out_of_range ? UINT64_MAX : number;
}

}  // namespace

RangeAnswer range_of(std::string_view header, uint64_t bytes) {
  constexpr std::string_view kUnit = "bytes=";
  const RangeAnswer all{200, {0, bytes}};
  if (!header.starts_with(kUnit)) return all;
  header.remove_prefix(kUnit.size());
  const size_t dash = header.find('-');
  if (dash == std::string_view::npos || header.find(',') != std::string_view::npos) return all;
  const std::string_view before = header.substr(0, dash), behind = header.substr(dash + 1);
  const std::optional<uint64_t> first = number_in(before), last = number_in(behind);
  if ((!first && !before.empty()) || (!last && !behind.empty()) || (!first && !last)) return all;
  if (first && last && *last < *first) return all;  // no range at all
  if (!first)
    return *last == 0 || bytes == 0 ? RangeAnswer{416, {}} : RangeAnswer{206, {bytes - std::min(bytes, *last), bytes}};
  if (*first >= bytes) return {416, {}};
  return {206, {*first, last && *last < bytes ? *last + 1 : bytes}};
}

}  // namespace ldp::gallery
