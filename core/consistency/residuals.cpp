#include <cmath>
#include <cstddef>

#include "core/consistency/consistency.h"

namespace ldp {
namespace {

double ratio(int64_t part, int64_t whole) {
  return whole == 0 ? 0 : static_cast<double>(part) / static_cast<double>(whole);
}

}  // namespace

const char* name_of(Agreement agreement) {
  constexpr std::array<const char*, kAgreements> names = {"agrees",  "hole",        "exposure", "wrong_colour",
                                                          "missing", "wrong_depth", "moved",    "alone"};
  return names.at(static_cast<size_t>(agreement));
}

void ResidualStatistics::add(const ResidualStatistics& other) {
  pixels += other.pixels;
  squared_difference += other.squared_difference;
  holes += other.holes;
  for (size_t i = 0; i < classes.size(); ++i) classes[i] += other.classes[i];
}

double ResidualStatistics::psnr_db() const {
  constexpr double kMost = 99;
  if (pixels == 0) return 0;
  if (squared_difference == 0) return kMost;
  return std::min(kMost, 10 * std::log10(255.0 * 255.0 / ratio(squared_difference, 3 * pixels)));
}

double ResidualStatistics::hole_share() const { return ratio(holes, pixels); }

double ResidualStatistics::share(Agreement agreement) const {
  int64_t sum = 0;
  for (const int64_t count : classes) sum += count;
  return ratio(classes[static_cast<size_t>(agreement)], sum);
}

double ResidualStatistics::unexplained_share() const {
  const auto count = [&](Agreement a) { return classes[static_cast<size_t>(a)]; };
  const int64_t wrong = count(Agreement::wrong_colour) + count(Agreement::missing) + count(Agreement::wrong_depth);
  return ratio(wrong, wrong + count(Agreement::agrees) + count(Agreement::exposure));
}

}  // namespace ldp
