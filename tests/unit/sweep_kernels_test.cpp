// Every kernel, for the processor at hand and for the base instruction set, against its formula written as a loop.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <random>
#include <vector>

#include "core/sweep/sweep_kernels.h"

namespace ldp::sweep::kernels {
namespace {

constexpr int kLongest = 70;  // more than two vectors, so that every remainder occurs

class SweepKernels : public testing::TestWithParam<const Kernels*> {
 protected:
  template <typename T>
  std::vector<T> noise(int count, int largest) {
    std::vector<T> values(static_cast<size_t>(count + kPadding));
    for (T& value : values) value = static_cast<T>(std::uniform_int_distribution<int>(0, largest)(random_));
    return values;
  }
  template <typename T>
  static std::vector<T> first(const std::vector<T>& values, int count) {
    return {values.begin(), values.begin() + count};
  }
  const Kernels& k() const { return *GetParam(); }

  std::mt19937 random_{7};
};

TEST_P(SweepKernels, BlendTwoColumnsAtEveryWeight) {
  const auto left = noise<uint8_t>(kLongest, 255), right = noise<uint8_t>(kLongest, 255);
  for (int count = 1; count <= kLongest; ++count) {
    const int weight = count % kWeightOne;
    std::vector<uint8_t> out(kLongest + kPadding), expected;
    k().blend_columns(left.data(), right.data(), weight, count, out.data());
    for (size_t i = 0; i < static_cast<size_t>(count); ++i)
      expected.push_back(static_cast<uint8_t>((left[i] * (64 - weight) + right[i] * weight + 32) >> 6));
    ASSERT_EQ(first(out, count), expected) << count;
  }
}

TEST_P(SweepKernels, ResampleRowsAtStepsFromHalfToFour) {
  const auto column = noise<uint8_t>(4 * kLongest + 8, 255), tint = noise<uint8_t>(4 * kLongest + 8, 255);
  for (const int32_t step : {32768, 65535, 65536, 65537, 131071, 131072, 131073, 262144})
    for (int count = 1; count <= kLongest; ++count) {
      const int64_t start = 4 * 65536 + 977 * count;
      std::vector<uint8_t> out(kLongest + kPadding), tint_out = out, expected, expected_tint;
      k().resample_rows({column.data(), tint.data()}, start, step, count, {out.data(), tint_out.data()});
      for (int i = 0; i < count; ++i) {
        const int64_t row = start + int64_t{i} * step;
        const int f = static_cast<int>(row >> 10) & 63;
        const auto at = static_cast<size_t>(row >> 16);
        expected.push_back(static_cast<uint8_t>((column[at] * (64 - f) + column[at + 1] * f + 32) >> 6));
        expected_tint.push_back(static_cast<uint8_t>((tint[at] * (64 - f) + tint[at + 1] * f + 32) >> 6));
      }
      ASSERT_EQ(first(tint_out, count), expected_tint) << step << " " << count;
      ASSERT_EQ(first(out, count), expected) << step << " " << count;
    }
}

TEST_P(SweepKernels, TestVisibilityWithoutReadingPastTheSurface) {
  for (const int32_t step : {40000, 65536, 131072, 200000})
    for (int count = 1; count <= kLongest; ++count) {
      const int64_t start = 70000;
      const auto length = static_cast<size_t>((start + int64_t{step} * (count - 1)) / 65536 + 1);
      std::vector<uint16_t> surface(length);  // exactly what may be read: a sanitizer sees the rest
      for (auto& s : surface) s = static_cast<uint16_t>(random_());
      const int limit = count % 3 == 0 ? 70000 : 40000;
      std::vector<uint8_t> mask(kLongest + kPadding), expected;
      k().test_visibility(surface.data(), start, step, limit, count, mask.data());
      for (int i = 0; i < count; ++i) {
        const auto row = static_cast<size_t>((start + int64_t{i} * step) / 65536);
        expected.push_back(surface[row] <= limit ? 255 : 0);
      }
      ASSERT_EQ(first(mask, count), expected) << step << " " << count;
    }
}

struct Seen {
  int grey = 0, tint = 0;
};

// phi of one row from the samples that count, the first of them being the reference.
int variance_of(const std::vector<Seen>& seen, int prior) {
  if (seen.empty()) return kLargestVariance;
  if (seen.size() == 1) return prior;
  std::vector<int> deviation;
  for (const Seen& s : seen) {
    const int grey = std::max(0, std::abs(s.grey - seen[0].grey) - 2);
    const int tint = std::max(0, std::abs(s.tint - seen[0].tint) - 4);
    deviation.push_back(std::min(255, grey + tint));
  }
  std::sort(deviation.begin(), deviation.end());
  int doubt = 0;
  for (size_t k = 3; k < seen.size(); ++k) doubt += std::min(8, deviation[k]);
  if (seen.size() > 3) doubt = doubt * (512 / (static_cast<int>(seen.size()) - 3)) / 256;
  const int agreeing = std::min<int>(kLargestVariance, 2 * (deviation[1] + deviation[seen.size() > 2 ? 2 : 1]));
  return std::min<int>(kLargestVariance, agreeing + doubt);
}

std::vector<const uint8_t*> pointers_to(const std::vector<std::vector<uint8_t>>& lines) {
  std::vector<const uint8_t*> pointers;
  for (const auto& line : lines) pointers.push_back(line.data());
  return pointers;
}

TEST_P(SweepKernels, RobustVarianceOfTwoToEightViews) {
  for (int views = 2; views <= kMaxViews; ++views)
    for (int count = 1; count <= kLongest; ++count) {
      std::vector<std::vector<uint8_t>> samples, tints;
      for (int v = 0; v < views; ++v) {
        samples.push_back(noise<uint8_t>(kLongest, v == 7 ? 255 : 30));
        tints.push_back(noise<uint8_t>(kLongest, v == 7 ? 255 : 20));
      }
      const auto pointers = pointers_to(samples), tint_pointers = pointers_to(tints);
      std::vector<uint8_t> phi(kLongest + kPadding), reference = phi, reference_tint = phi, expected;
      k().robust_variance({pointers.data(), tint_pointers.data()}, views, count, phi.data(),
                          {reference.data(), reference_tint.data()});
      for (size_t i = 0; i < static_cast<size_t>(count); ++i) {
        std::vector<Seen> seen;
        for (size_t v = 0; v < samples.size(); ++v) seen.push_back({samples[v][i], tints[v][i]});
        expected.push_back(static_cast<uint8_t>(variance_of(seen, 0)));
      }
      ASSERT_EQ(first(phi, count), expected) << views << " " << count;
      ASSERT_EQ(first(reference, count), first(samples[0], count));
      ASSERT_EQ(first(reference_tint, count), first(tints[0], count));
    }
}

TEST_P(SweepKernels, MaskedVarianceLooksOnlyAtWhatSees) {
  constexpr int kPrior = 36;
  for (int views = 1; views <= kMaxViews; ++views)
    for (int count = 1; count <= kLongest; ++count) {
      std::vector<std::vector<uint8_t>> samples, tints, masks;
      for (int v = 0; v < views; ++v) {
        samples.push_back(noise<uint8_t>(kLongest, 30));
        tints.push_back(noise<uint8_t>(kLongest, 20));
        masks.push_back(noise<uint8_t>(kLongest, 1));
        for (auto& m : masks.back()) m = m || count % 4 == 0 ? 255 : 0;  // at times nothing is hidden
      }
      const auto pointers = pointers_to(samples), tint_pointers = pointers_to(tints),
                 mask_pointers = pointers_to(masks);
      std::vector<uint8_t> phi(kLongest + kPadding), reference = phi, reference_tint = phi, expected,
                                                     expected_reference, expected_tint;
      k().masked_robust_variance({pointers.data(), tint_pointers.data()}, mask_pointers.data(), views, kPrior, count,
                                 phi.data(), {reference.data(), reference_tint.data()});
      for (size_t i = 0; i < static_cast<size_t>(count); ++i) {
        std::vector<Seen> seen;
        for (size_t v = 0; v < samples.size(); ++v)
          if (masks[v][i]) seen.push_back({samples[v][i], tints[v][i]});
        expected.push_back(static_cast<uint8_t>(variance_of(seen, kPrior)));
        expected_reference.push_back(static_cast<uint8_t>(seen.empty() ? 128 : seen[0].grey));
        expected_tint.push_back(static_cast<uint8_t>(seen.empty() ? 128 : seen[0].tint));
      }
      ASSERT_EQ(first(phi, count), expected) << views << " " << count;
      ASSERT_EQ(first(reference, count), expected_reference);
      ASSERT_EQ(first(reference_tint, count), expected_tint);
    }
}

TEST_P(SweepKernels, RangesOfRowsAndContrastOfColumns) {
  std::vector<std::vector<uint8_t>> grey, tint;
  for (int column = 0; column < 7; ++column) {
    grey.push_back(noise<uint8_t>(kLongest + 6, 40));
    tint.push_back(noise<uint8_t>(kLongest + 6, 90));
  }
  for (int count = 1; count <= kLongest; ++count) {
    std::vector<std::vector<uint8_t>> buffers(28, std::vector<uint8_t>(kLongest + kPadding));
    Tinted<const uint8_t> low[7], high[7];
    for (size_t k = 0; k < 7; ++k) {
      const auto to = buffers.begin() + static_cast<std::ptrdiff_t>(4 * k);
      this->k().range7(grey[k].data(), count, to[0].data(), to[1].data());
      this->k().range7(tint[k].data(), count, to[2].data(), to[3].data());
      low[k] = {to[0].data(), to[2].data()};
      high[k] = {to[1].data(), to[3].data()};
    }
    std::vector<uint8_t> contrast(kLongest + kPadding);
    this->k().contrast7(low, high, count, contrast.data());
    const auto range = [](const std::vector<std::vector<uint8_t>>& columns, int row) {
      int least = 255, largest = 0;
      for (const auto& column : columns) {
        const auto [from, to] = std::minmax_element(column.begin() + row, column.begin() + row + 7);
        least = std::min<int>(least, *from);
        largest = std::max<int>(largest, *to);
      }
      return largest - least;
    };
    for (int i = 0; i < count; ++i) {
      const auto [least, largest] = std::minmax_element(grey[0].begin() + i, grey[0].begin() + i + 7);
      ASSERT_EQ(low[0].grey[i], *least);
      ASSERT_EQ(high[0].grey[i], *largest);
      ASSERT_EQ(contrast[static_cast<size_t>(i)], std::max(range(grey, i), range(tint, i) / 2)) << count;
    }
  }
}

TEST_P(SweepKernels, SumsAndMinimaOfWindows) {
  const auto bytes = noise<uint8_t>(kLongest, 40);
  const auto a = noise<uint16_t>(kLongest, 1000), b = noise<uint16_t>(kLongest, 1000),
             c = noise<uint16_t>(kLongest, 1000);
  for (int count = 1; count <= kLongest; ++count) {
    std::vector<uint16_t> sum(kLongest + kPadding), total = c, rows = sum, columns = sum;
    k().sum5(bytes.data(), count, sum.data());
    k().slide(a.data(), b.data(), count, total.data());
    k().min3_rows(a.data(), count, rows.data());
    k().min3_columns(a.data(), b.data(), c.data(), count, columns.data());
    for (size_t i = 0; i < static_cast<size_t>(count); ++i) {
      ASSERT_EQ(sum[i], bytes[i] + bytes[i + 1] + bytes[i + 2] + bytes[i + 3] + bytes[i + 4]);
      ASSERT_EQ(total[i], static_cast<uint16_t>(c[i] + a[i] - b[i]));
      ASSERT_EQ(rows[i], std::min({a[i], a[i + 1], a[i + 2]}));
      ASSERT_EQ(columns[i], std::min({a[i], b[i], c[i]}));
    }
  }
}

TEST_P(SweepKernels, AdaptiveSupportIsTheMeanOverPixelsAlike) {
  constexpr int kWindow = 7, kMiddle = 3;
  std::array<std::vector<uint8_t>, kWindow> costs, greys;
  const uint8_t *cost[kWindow], *grey[kWindow];
  for (size_t x = 0; x < kWindow; ++x) {
    cost[x] = (costs[x] = noise<uint8_t>(kLongest + kWindow, kLargestVariance)).data();
    grey[x] = (greys[x] = noise<uint8_t>(kLongest + kWindow, 30)).data();
  }
  const auto box = noise<uint16_t>(kLongest, 25 * kLargestVariance);
  for (int count = 1; count <= kLongest; ++count) {
    std::vector<uint16_t> out(kLongest + kPadding);
    k().adaptive_support(cost, grey, box.data(), count, out.data());
    for (int i = 0; i < count; ++i) {
      int sum = 0, alike = 0;
      for (int x = 0; x < kWindow; ++x)
        for (int y = 0; y < kWindow; ++y) {
          if ((x + y) % 2 != 0 || std::abs(grey[x][i + y] - grey[kMiddle][i + kMiddle]) > kAlike) continue;
          sum += cost[x][i + y];
          ++alike;
        }
      ASSERT_EQ(out[static_cast<size_t>(i)], (25 * sum + kBoxShare * box[static_cast<size_t>(i)]) / (alike + kBoxShare))
          << count;
    }
  }
}

TEST_P(SweepKernels, KeepBestDividesByTheBoxAndKeepsTheFirstOfEquals) {
  const auto sum = noise<uint16_t>(kLongest, 25 * 40);
  const auto grey = noise<uint8_t>(kLongest, 255);
  for (int count = 1; count <= kLongest; ++count)
    for (const bool start : {true, false}) {
      auto best = noise<uint8_t>(kLongest, 40), best_grey = noise<uint8_t>(kLongest, 255);
      const auto before = best, grey_before = best_grey;
      k().keep_best(sum.data(), grey.data(), start, count, best.data(), best_grey.data());
      for (size_t i = 0; i < static_cast<size_t>(count); ++i) {
        const int cost = sum[i] / 25;
        const bool better = start || cost < before[i];
        ASSERT_EQ(best[i], better ? cost : before[i]);
        ASSERT_EQ(best_grey[i], better ? grey[i] : grey_before[i]);
      }
    }
}

// The formula of smooth_row at one pixel.
uint16_t smoothed(const std::vector<SmoothRow>& rows, const uint8_t* weights, int own, int column) {
  const auto weigh = [&](const SmoothRow& row, int i) {
    const int difference = std::abs(row.grey[i] - rows[static_cast<size_t>(own)].grey[column + kSmoothReach]);
    return row.bin[i] == kNoBin || difference >= kSmoothWeights ? 0 : int{weights[difference]};
  };
  int total = 0, beside = 0, sum = 0, bin = -1;
  for (const SmoothRow& row : rows)
    for (int i = column; i <= column + 2 * kSmoothReach; ++i) total += weigh(row, i);
  for (int below = -1; 2 * below < total;) {
    ++bin, below = 0;
    for (const SmoothRow& row : rows)
      for (int i = column; i <= column + 2 * kSmoothReach; ++i) below += row.bin[i] <= bin ? weigh(row, i) : 0;
  }
  for (const SmoothRow& row : rows)
    for (int i = column; i <= column + 2 * kSmoothReach; ++i) {
      if (std::abs(row.bin[i] - bin) > 1) continue;
      beside += weigh(row, i);
      sum += weigh(row, i) * row.disparity[i];
    }
  return static_cast<uint16_t>((sum + beside / 2) / beside);
}

TEST_P(SweepKernels, SmoothRowsLikeAHistogramOfEachWindow) {
  constexpr int kBins = 30, kRows = 2 * kSmoothReach + 1, kWidth = kLongest + 2 * kSmoothReach;
  std::vector<uint8_t> weights(kSmoothWeights);
  for (size_t i = 0; i < weights.size(); ++i) weights[i] = static_cast<uint8_t>(255 / (i + 1));
  for (const int bins : {1, 2, 3, kBins})
    for (int row_count = kSmoothReach + 1; row_count <= kRows; ++row_count) {
      std::vector<std::vector<uint8_t>> greys, all_bins;
      std::vector<std::vector<uint16_t>> disparities;
      std::vector<SmoothRow> rows;
      for (int row = 0; row < row_count; ++row) {
        greys.push_back(noise<uint8_t>(kWidth, 80));
        disparities.push_back(noise<uint16_t>(kWidth, bins * kSmoothBinSteps - 1));
        auto& row_bins = all_bins.emplace_back();
        for (const uint16_t d : disparities.back())
          row_bins.push_back(d % 11 == 0 ? kNoBin : static_cast<uint8_t>(d / kSmoothBinSteps));
      }
      for (size_t i = 0; i < greys.size(); ++i)
        rows.push_back({greys[i].data(), all_bins[i].data(), disparities[i].data()});
      const int count = kLongest - row_count, own = row_count - kSmoothReach - 1;
      std::vector<uint16_t> out(kLongest + kPadding);
      k().smooth_row(rows.data(), row_count, own, weights.data(), count, out.data());
      for (int i = 0; i < count; ++i) {
        if (rows[static_cast<size_t>(own)].bin[i + kSmoothReach] == kNoBin) continue;
        ASSERT_EQ(out[static_cast<size_t>(i)], smoothed(rows, weights.data(), own, i)) << bins << " " << i;
      }
    }
}

INSTANTIATE_TEST_SUITE_P(Both, SweepKernels, testing::Values(&best(), &plain()),
                         [](const auto& set) { return std::string(set.index == 0 ? "Best" : "Plain"); });

}  // namespace
}  // namespace ldp::sweep::kernels
