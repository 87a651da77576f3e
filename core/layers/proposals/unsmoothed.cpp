#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include "core/layers/layers.h"
#include "core/layers/layers_tuning.h"

namespace ldp {
namespace {

static_assert(kLabels <= 16);  // one bit each

// Several threads may read the same window, and find the same.
template <typename T>
void remember(T& place, T value) {
  std::atomic_ref<T>(place).store(value, std::memory_order_relaxed);
}

}  // namespace

CheapestLabels::CheapestLabels(const CostSource& inner)
    : inner_(inner), cheapest_(inner.width(), inner.height(), kUnread), nearly_(inner.width(), inner.height(), 0) {}

void CheapestLabels::read(const Window& window, uint8_t* cost, uint8_t* median) const {
  inner_.read(window, cost, median);
  const int labels = inner_.labels();
  for (int i = 0; i < window.width; ++i) {
    const int x = (window.x + i) % inner_.width();
    for (int y = window.y; y < window.y + window.height; ++y, cost += labels) {
      const uint8_t* least = std::min_element(cost, cost + labels);
      remember(cheapest_.at(x, y), static_cast<uint8_t>(least - cost));
      unsigned nearly = 0;
      for (int l = 0; l < labels; ++l)
        nearly |= static_cast<unsigned>(cost[l] <= *least + layers::tuning::kClearlyCheaper) << l;
      remember(nearly_.at(x, y), static_cast<uint16_t>(nearly));
    }
  }
}

Plane<uint8_t> CheapestLabels::clearly_nearer(const Plane<uint8_t>& chosen, int least) const {
  DisparityMap nearer(chosen.width, chosen.height, kNoDisparity);
  for (size_t i = 0; i < nearer.samples.size(); ++i) {
    const uint8_t cheapest = cheapest_.samples[i], own = chosen.samples[i];
    if (cheapest != kUnread && cheapest > own && (nearly_.samples[i] >> own & 1) == 0) nearer.samples[i] = cheapest;
  }
  drop_small_components(least, wraps(), nearer, 1);
  Plane<uint8_t> large(chosen.width, chosen.height);
  std::transform(nearer.samples.begin(), nearer.samples.end(), large.samples.begin(),
                 [](uint16_t label) { return static_cast<uint8_t>(label != kNoDisparity); });
  return large;
}

}  // namespace ldp
