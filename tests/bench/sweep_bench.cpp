// Samples a second of the sweep on one core, and what limits them.
//
//   sweep_bench [Google Benchmark's options]
//
// A sample is one (ray, depth, camera): a photo read at the place where the camera sees the voxel, and compared. Slabs
// of `garden` in windows as the solver pulls them; Kernels: the same arithmetic without geometry, all data in the first
// cache, which no sweep can outrun; Memory: the machine's own copying, in bytes.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <optional>
#include <vector>

#include "core/geometry/disparity.h"
#include "core/sweep/cost_slab.h"
#include "tests/bench/captures.h"

namespace ldp::sweep {
namespace {

constexpr int kColumns = 64;  // of a window, at full height
constexpr int kPriorCost = 36;

const PreparedCapture* garden() {
  static const std::optional<PreparedCapture> capture = [] {
    const std::string folder = LDP_SHARED_DATA "/scenes/garden";
    return std::filesystem::exists(folder) ? std::optional(prepare_capture(folder)) : std::nullopt;
  }();
  return capture ? &*capture : nullptr;
}

class Discard final : public SlabSink {
 public:
  void column(int, const uint16_t* cost, const uint8_t*, const uint8_t*) override { benchmark::DoNotOptimize(cost); }
};

int64_t samples_of(const LineTable& table, double inverse_depth, const Window& window) {
  int64_t samples = 0;
  Lines lines;
  for (int x = window.x; x < window.x + window.width; ++x) {
    table.find(x, inverse_depth, window.y, window.y + window.height, lines);
    for (int k = 0; k < lines.count; ++k)
      samples += lines.line[static_cast<size_t>(k)].y_end - lines.line[static_cast<size_t>(k)].y_begin;
  }
  return samples;
}

void Slabs(benchmark::State& state, const kernels::Kernels& kernels) {
  const PreparedCapture* capture = garden();
  if (capture == nullptr) return state.SkipWithError("the garden's photos are not here");
  const PanoramaGrid& grid = capture->grid;
  const LineTable table(capture->upright, grid, {}, kHalo, LineTable::Layer::front);
  SlabScratch scratch(kernels);
  int longest = 0;
  for (const UprightFrame& frame : capture->upright) longest = std::max(longest, frame.columns.width);
  scratch.reserve(grid.height, longest);
  Discard sink;
  int64_t samples = 0;
  int slab = 0;
  for (auto _ : state) {
    const Window window{slab * kColumns % (grid.width - kColumns), 0, kColumns, grid.height};
    const double w = grid.inverse_depth(slab * 7919 % kDisparitySteps);
    sweep_slab(table, w, window, kPriorCost, false, scratch, sink);
    state.PauseTiming();
    samples += samples_of(table, w, window);
    state.ResumeTiming();
    ++slab;
  }
  state.SetItemsProcessed(samples);
}

void Kernels(benchmark::State& state, const kernels::Kernels& kernels) {
  constexpr int kRows = 512, kViews = 8;
  std::vector<uint8_t> left(kRows + 2 * kernels::kPadding, 90), right(left), blended(left);
  std::vector<uint8_t> blended_tint(left), phi(left), grey(left);
  std::vector<std::vector<uint8_t>> samples(2 * kViews, left);
  const uint8_t* views[2 * kViews];  // grey, then tint
  std::vector<uint16_t> sums(kRows + 2 * kernels::kPadding), total(sums), lowest(sums);
  for (auto _ : state) {
    for (size_t k = 0; k < kViews; ++k) {
      const int weight = 7 * static_cast<int>(k);
      kernels.blend_columns(left.data(), right.data(), weight, kRows, blended.data());
      kernels.blend_columns(left.data(), right.data(), weight, kRows, blended_tint.data());
      const kernels::Tinted<uint8_t> out{samples[k].data(), samples[kViews + k].data()};
      kernels.resample_rows({blended.data(), blended_tint.data()}, 1000 * static_cast<int>(k), 65000, kRows, out);
      views[k] = out.grey;
      views[kViews + k] = out.tint;
    }
    kernels.robust_variance({views, views + kViews}, kViews, kRows, phi.data(), {grey.data(), right.data()});
    kernels.sum5(phi.data(), kRows, sums.data());
    kernels.slide(sums.data(), sums.data(), kRows, total.data());
    kernels.min3_rows(total.data(), kRows, lowest.data());
    kernels.min3_columns(lowest.data(), total.data(), sums.data(), kRows, lowest.data());
    kernels.keep_best(lowest.data(), grey.data(), false, kRows, left.data(), right.data());
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations() * kRows * kViews);
}

void Memory(benchmark::State& state) {
  constexpr size_t kBytes = 64 << 20;
  std::vector<uint8_t> from(kBytes, 1), to(kBytes);
  for (auto _ : state) {
    std::memcpy(to.data(), from.data(), kBytes);
    benchmark::ClobberMemory();
  }
  state.SetBytesProcessed(state.iterations() * static_cast<int64_t>(kBytes));
}

BENCHMARK_CAPTURE(Slabs, best, kernels::best())->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(Slabs, plain, kernels::plain())->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(Kernels, best, kernels::best());
BENCHMARK_CAPTURE(Kernels, plain, kernels::plain());
BENCHMARK(Memory)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace ldp::sweep

BENCHMARK_MAIN();
