#include "kernels.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

// Vectors never cross a call that is not inlined, so how they would be passed does not matter.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace ldp::kernels {
namespace {

constexpr int kLanes = 16;
using Lanes = uint8_t __attribute__((vector_size(kLanes)));
using Wide = uint16_t __attribute__((vector_size(2 * kLanes)));

template <typename V, typename T>
V load(const T* from) {
  V lanes;
  __builtin_memcpy(&lanes, from, sizeof lanes);
  return lanes;
}

template <typename V, typename T>
void store(const V& lanes, T* to) {
  __builtin_memcpy(to, &lanes, sizeof lanes);
}

template <typename V>
V smaller(const V& a, const V& b) {
  return a < b ? a : b;
}
template <typename V>
V larger(const V& a, const V& b) {
  return a > b ? a : b;
}

Lanes narrow(const Wide& wide) { return __builtin_convertvector(wide, Lanes); }
Wide widen(const Lanes& lanes) { return __builtin_convertvector(lanes, Wide); }

struct Swap {
  int low, high;
};

// Sorting networks of least size (Knuth, vol. 3, 5.3.4).
constexpr std::array<Swap, 1> kSort2 = {{{0, 1}}};
constexpr std::array<Swap, 3> kSort3 = {{{0, 2}, {0, 1}, {1, 2}}};
constexpr std::array<Swap, 5> kSort4 = {{{0, 2}, {1, 3}, {0, 1}, {2, 3}, {1, 2}}};
constexpr std::array<Swap, 9> kSort5 = {{{0, 3}, {1, 4}, {0, 2}, {1, 3}, {0, 1}, {2, 4}, {1, 2}, {3, 4}, {2, 3}}};
constexpr std::array<Swap, 12> kSort6 = {
    {{0, 5}, {1, 3}, {2, 4}, {1, 2}, {3, 4}, {0, 3}, {2, 5}, {0, 1}, {2, 3}, {4, 5}, {1, 2}, {3, 4}}};
constexpr std::array<Swap, 16> kSort7 = {{{0, 6},
                                          {2, 3},
                                          {4, 5},
                                          {0, 2},
                                          {1, 4},
                                          {3, 6},
                                          {0, 1},
                                          {2, 5},
                                          {3, 4},
                                          {1, 2},
                                          {4, 6},
                                          {2, 3},
                                          {4, 5},
                                          {1, 2},
                                          {3, 4},
                                          {5, 6}}};
constexpr std::array<Swap, 19> kSort8 = {{{0, 2},
                                          {1, 3},
                                          {4, 6},
                                          {5, 7},
                                          {0, 4},
                                          {1, 5},
                                          {2, 6},
                                          {3, 7},
                                          {0, 1},
                                          {2, 3},
                                          {4, 5},
                                          {6, 7},
                                          {2, 4},
                                          {3, 5},
                                          {1, 4},
                                          {3, 6},
                                          {1, 2},
                                          {3, 4},
                                          {5, 6}}};

template <size_t N>
constexpr const auto& network() {
  if constexpr (N == 2)
    return kSort2;
  else if constexpr (N == 3)
    return kSort3;
  else if constexpr (N == 4)
    return kSort4;
  else if constexpr (N == 5)
    return kSort5;
  else if constexpr (N == 6)
    return kSort6;
  else if constexpr (N == 7)
    return kSort7;
  else
    return kSort8;
}

template <size_t N>
void sort(std::array<Lanes, N>& s) {
  if constexpr (N >= 2) {
    const auto swap = [&](const Swap pair) {
      Lanes &low = s[static_cast<size_t>(pair.low)], &high = s[static_cast<size_t>(pair.high)];
      const Lanes a = smaller(low, high), b = larger(low, high);
      low = a;
      high = b;
    };
    [&]<size_t... I>(std::index_sequence<I...>) { (swap(network<N>()[I]), ...); }
    (std::make_index_sequence<network<N>().size()>{});
  }
}

// phi of sorted deviations, the reference's own zero first: two others that agree are enough.
template <size_t N>
Lanes disagreement(const std::array<Lanes, N>& sorted, const Lanes& seen) {
  const Wide second = widen(sorted[1]), third = widen(seen < 3 ? sorted[1] : sorted[std::min<size_t>(2, N - 1)]);
  return narrow(smaller(2 * (second + third), Wide{} + kLargestVariance));
}

template <size_t N>
void robust_variance_of(const uint8_t* const* samples, int count, uint8_t* phi, uint8_t* reference) {
  for (int i = 0; i < count; i += kLanes) {
    std::array<Lanes, N> s;
    for (size_t k = 0; k < N; ++k) s[k] = load<Lanes>(samples[k] + i);
    const Lanes nearest = s[0];
    for (size_t k = 0; k < N; ++k) s[k] = larger(s[k], nearest) - smaller(s[k], nearest);
    sort<N>(s);
    store(disagreement<N>(s, Lanes{} + uint8_t{N}), phi + i);
    store(nearest, reference + i);
  }
}

template <size_t N>
void masked_robust_variance_of(const uint8_t* const* samples, const uint8_t* const* masks, int prior, int count,
                               uint8_t* phi, uint8_t* reference) {
  for (int i = 0; i < count; i += kLanes) {
    std::array<Lanes, N> s, hidden;
    Lanes seen = Lanes{} + uint8_t{N}, nearest = Lanes{} + uint8_t{128};
    for (size_t k = N; k-- > 0;) {
      hidden[k] = ~load<Lanes>(masks[k] + i);
      s[k] = load<Lanes>(samples[k] + i);
      nearest = hidden[k] == 0 ? s[k] : nearest;
      seen += hidden[k];
    }
    for (size_t k = 0; k < N; ++k)
      s[k] = (larger(s[k], nearest) - smaller(s[k], nearest)) | hidden[k];  // hidden ones sort to the end
    sort<N>(s);
    Lanes variance = Lanes{} + kLargestVariance;
    if constexpr (N > 1) variance = disagreement<N>(s, seen);
    variance = seen == 1 ? Lanes{} + static_cast<uint8_t>(prior) : variance;
    store(seen == 0 ? Lanes{} + kLargestVariance : variance, phi + i);
    store(nearest, reference + i);
  }
}

}  // namespace

void blend_columns(const uint8_t* left, const uint8_t* right, int weight, int count, uint8_t* out) {
  const auto w = static_cast<uint16_t>(weight), rest = static_cast<uint16_t>(kWeightOne - weight);
  const int whole = count / kLanes * kLanes;
  for (int i = 0; i < whole; i += kLanes) {
    const Wide sum = widen(load<Lanes>(left + i)) * rest + widen(load<Lanes>(right + i)) * w;
    store(narrow((sum + kWeightOne / 2) >> kWeightBits), out + i);
  }
  for (int i = whole; i < count; ++i) {
    out[i] = static_cast<uint8_t>((left[i] * rest + right[i] * w + kWeightOne / 2) >> kWeightBits);
  }
}

void resample_rows(const uint8_t* column, int64_t row_q16, int32_t step_q16, int count, uint8_t* out) {
  const uint8_t* base = column + (row_q16 >> 16);
  auto position = static_cast<uint32_t>(row_q16 & 0xFFFF);
  for (int i = 0; i < count; ++i, position += static_cast<uint32_t>(step_q16)) {
    const uint8_t* at = base + (position >> 16);
    const int f = static_cast<int>(position >> (16 - kWeightBits)) & (kWeightOne - 1);
    out[i] = static_cast<uint8_t>((at[0] * (kWeightOne - f) + at[1] * f + kWeightOne / 2) >> kWeightBits);
  }
}

void test_visibility(const uint16_t* surface, int64_t row_q16, int32_t step_q16, int shrink, int limit, int count,
                     uint8_t* mask) {
  for (int i = 0; i < count; ++i, row_q16 += step_q16) {
    mask[i] = surface[static_cast<int32_t>(row_q16 >> 16) / shrink] <= limit ? 255 : 0;
  }
}

void robust_variance(const uint8_t* const* samples, int views, int count, uint8_t* phi, uint8_t* reference) {
  switch (views) {
    case 2:
      return robust_variance_of<2>(samples, count, phi, reference);
    case 3:
      return robust_variance_of<3>(samples, count, phi, reference);
    case 4:
      return robust_variance_of<4>(samples, count, phi, reference);
    case 5:
      return robust_variance_of<5>(samples, count, phi, reference);
    case 6:
      return robust_variance_of<6>(samples, count, phi, reference);
    case 7:
      return robust_variance_of<7>(samples, count, phi, reference);
    default:
      return robust_variance_of<8>(samples, count, phi, reference);
  }
}

void masked_robust_variance(const uint8_t* const* samples, const uint8_t* const* masks, int views, int prior, int count,
                            uint8_t* phi, uint8_t* reference) {
  switch (views) {
    case 1:
      return masked_robust_variance_of<1>(samples, masks, prior, count, phi, reference);
    case 2:
      return masked_robust_variance_of<2>(samples, masks, prior, count, phi, reference);
    case 3:
      return masked_robust_variance_of<3>(samples, masks, prior, count, phi, reference);
    case 4:
      return masked_robust_variance_of<4>(samples, masks, prior, count, phi, reference);
    case 5:
      return masked_robust_variance_of<5>(samples, masks, prior, count, phi, reference);
    case 6:
      return masked_robust_variance_of<6>(samples, masks, prior, count, phi, reference);
    case 7:
      return masked_robust_variance_of<7>(samples, masks, prior, count, phi, reference);
    default:
      return masked_robust_variance_of<8>(samples, masks, prior, count, phi, reference);
  }
}

void sum5(const uint8_t* in, int count, uint16_t* out) {
  for (int i = 0; i < count; i += kLanes) {
    Wide sum{};
    for (int k = 0; k < 5; ++k) sum += widen(load<Lanes>(in + i + k));
    store(sum, out + i);
  }
}

void slide(const uint16_t* entering, const uint16_t* leaving, int count, uint16_t* total) {
  for (int i = 0; i < count; i += kLanes) {
    store(load<Wide>(total + i) + load<Wide>(entering + i) - load<Wide>(leaving + i), total + i);
  }
}

void min3_rows(const uint16_t* in, int count, uint16_t* out) {
  for (int i = 0; i < count; i += kLanes) {
    store(smaller(smaller(load<Wide>(in + i), load<Wide>(in + i + 1)), load<Wide>(in + i + 2)), out + i);
  }
}

void min3_columns(const uint16_t* a, const uint16_t* b, const uint16_t* c, int count, uint16_t* out) {
  for (int i = 0; i < count; i += kLanes) {
    store(smaller(smaller(load<Wide>(a + i), load<Wide>(b + i)), load<Wide>(c + i)), out + i);
  }
}

void keep_best(const uint16_t* sum, const uint8_t* median, bool first, int count, uint8_t* best, uint8_t* best_median) {
  for (int i = 0; i < count; ++i) {
    const auto cost = static_cast<uint8_t>((sum[i] * 5243u) >> 17);  // / 25, exact below 43,698
    const bool better = first || cost < best[i];
    best[i] = better ? cost : best[i];
    best_median[i] = better ? median[i] : best_median[i];
  }
}

}  // namespace ldp::kernels
