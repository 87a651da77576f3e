#include "core/solve/solve.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <functional>
#include <latch>
#include <map>
#include <mutex>
#include <random>

#include "core/base/task_order.h"
#include "core/solve/depth_problem.h"
#include "core/solve/moves/alpha_expansion.h"
#include "core/solve/moves/label_grid.h"
#include "core/solve/moves/region_moves.h"
#include "core/solve/moves/smoothness.h"

namespace ldp::solve {
namespace {

// Costs and medians held in arrays; as a ring or not.
struct ArrayCosts final : CostSource {
  ArrayCosts(int w, int h, int l, bool ring)
      : width_(w),
        height_(h),
        labels_(l),
        wraps_(ring),
        cost(static_cast<size_t>(w * h * l)),
        median(static_cast<size_t>(w * h * l)) {}
  int width() const override { return width_; }
  int height() const override { return height_; }
  int labels() const override { return labels_; }
  bool wraps() const override { return wraps_; }
  size_t index(int x, int y, int l) const { return static_cast<size_t>((x * height_ + y) * labels_ + l); }
  void read(const Window& window, uint8_t* c, uint8_t* m) const override {
    for (int x = 0; x < window.width; ++x)
      for (int y = 0; y < window.height; ++y)
        for (int l = 0; l < labels_; ++l, ++c, ++m) {
          *c = cost[index((window.x + x) % width_, window.y + y, l)];
          *m = median[index((window.x + x) % width_, window.y + y, l)];
        }
  }
  int width_, height_, labels_;
  bool wraps_;
  std::vector<uint8_t> cost, median;
};

// Piecewise-constant truth with noisy costs and medians that vary with the label.
ArrayCosts random_costs(int w, int h, int l, bool ring, unsigned seed, int noise = 20, int median_spread = 40) {
  ArrayCosts costs(w, h, l, ring);
  std::mt19937 random(seed);
  const auto uniform = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
  for (int x = 0; x < w; ++x)
    for (int y = 0; y < h; ++y) {
      const int truth = (x / 7 + y / 5 * 3) % l;
      const int base = 60 + (x / 9 % 3) * 50;
      for (int k = 0; k < l; ++k) {
        costs.cost[costs.index(x, y, k)] = static_cast<uint8_t>(std::min(20, 4 * std::abs(k - truth)) + uniform(noise));
        costs.median[costs.index(x, y, k)] = static_cast<uint8_t>(base + uniform(median_spread));
      }
    }
  return costs;
}

// The energy of the formula, in grey levels, in floating point.
double formula_energy(const ArrayCosts& costs, const Plane<uint8_t>& labels, const Plane<uint8_t>& mask,
                      const SolveOptions& options) {
  double energy = 0;
  const auto in = [&](int x, int y) { return mask.empty() || mask.at(x, y) != 0; };
  const auto grey = [&](int x, int y) { return costs.median[costs.index(x, y, labels.at(x, y))]; };
  const auto pair = [&](int x, int y, int x2, int y2) {
    if (!in(x2, y2)) return 0.0;
    return options.lambda * std::min(std::abs(labels.at(x, y) - labels.at(x2, y2)), options.truncation) *
           std::exp(-options.contrast * std::abs(grey(x, y) - grey(x2, y2)));
  };
  for (int y = 0; y < costs.height(); ++y)
    for (int x = 0; x < costs.width(); ++x) {
      if (!in(x, y)) continue;
      energy += static_cast<double>(costs.cost[costs.index(x, y, labels.at(x, y))]) / kCostScale;
      if (y + 1 < costs.height()) energy += pair(x, y, x, y + 1);
      if (x + 1 < costs.width() || costs.wraps()) energy += pair(x, y, (x + 1) % costs.width(), y);
    }
  return energy;
}

Job on_threads(int threads) {
  Job job;
  job.threads = threads;
  return job;
}

double total(const SolveReport& report) { return report.data_energy + report.smoothness_energy; }

TEST(Solve, reports_the_energy_of_the_formula) {
  for (const bool ring : {false, true}) {
    const ArrayCosts costs = random_costs(61, 47, 16, ring, 1);
    SolveOptions options;
    options.core_px = 24, options.margin_px = 6;
    const Labelling result = solve_depth(costs, {}, options, {});
    EXPECT_NEAR(total(result.report), formula_energy(costs, result.labels, {}, options), 0.004 * total(result.report));
    EXPECT_LT(total(result.report), 0.9 * result.report.initial_energy);
  }
}

TEST(Solve, finds_the_best_of_all_labellings_of_small_problems_or_nearly) {
  int best_found = 0, problems = 0;
  for (unsigned seed = 0; seed < 16; ++seed) {
    const bool ring = seed == 1;  // one ring and one open grid of 12 nodes, the others of 9
    const ArrayCosts costs = random_costs(ring ? 6 : seed == 0 ? 4 : 3, ring ? 2 : 3, 3, ring, seed, 24, 80);
    const int nodes = costs.width() * costs.height(), labellings = static_cast<int>(std::lround(std::pow(3, nodes)));
    SolveOptions options;
    const double found = formula_energy(costs, solve_depth(costs, {}, options, {}).labels, {}, options);
    double least = 1e9;
    Plane<uint8_t> labels(costs.width(), costs.height());
    for (int code = 0; code < labellings; ++code) {
      for (int rest = code, i = 0; i < nodes; ++i, rest /= 3)
        labels.samples[static_cast<size_t>(i)] = static_cast<uint8_t>(rest % 3);
      least = std::min(least, formula_energy(costs, labels, {}, options));
    }
    EXPECT_LE(found, least * 1.03 + 0.05) << "seed " << seed;
    best_found += found <= least * 1.002 + 0.01;
    ++problems;
  }
  EXPECT_GE(best_found, problems - 1);
}

TEST(Solve, gives_the_same_bytes_at_any_thread_count) {
  const ArrayCosts costs = random_costs(150, 90, 16, true, 5);
  SolveOptions options;
  options.core_px = 24, options.margin_px = 6;
  const Labelling one = solve_depth(costs, {}, options, on_threads(1));
  for (const int threads : {2, 8}) {
    const Labelling many = solve_depth(costs, {}, options, on_threads(threads));
    EXPECT_EQ(many.labels, one.labels);
    EXPECT_EQ(total(many.report), total(one.report));
  }
}

TEST(Solve, does_not_see_pixels_outside_the_mask) {
  ArrayCosts costs = random_costs(60, 40, 8, true, 9);
  Plane<uint8_t> mask(60, 40);
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 60; ++x) mask.at(x, y) = (x / 11 + y / 7) % 3 != 0;
  SolveOptions options;
  options.core_px = 20, options.margin_px = 5;
  const Labelling before = solve_depth(costs, mask, options, {});
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 60; ++x)
      if (mask.at(x, y) == 0) {
        EXPECT_EQ(before.labels.at(x, y), 0);
        for (int l = 0; l < 8; ++l) costs.cost[costs.index(x, y, l)] = static_cast<uint8_t>(37 * l + x);
      }
  const Labelling after = solve_depth(costs, mask, options, {});
  EXPECT_EQ(after.labels, before.labels);
  EXPECT_EQ(total(after.report), total(before.report));
  EXPECT_NEAR(total(after.report), formula_energy(costs, after.labels, mask, options), 0.004 * total(after.report));
}

TEST(Solve, a_turned_ring_has_the_energy_of_the_ring) {
  const ArrayCosts costs = random_costs(96, 40, 16, true, 3);
  ArrayCosts turned(96, 40, 16, true);
  for (int x = 0; x < 96; ++x)
    for (int y = 0; y < 40; ++y)
      for (int l = 0; l < 16; ++l) {
        turned.cost[turned.index(x, y, l)] = costs.cost[costs.index((x + 13) % 96, y, l)];
        turned.median[turned.index(x, y, l)] = costs.median[costs.index((x + 13) % 96, y, l)];
      }
  SolveOptions options;
  options.core_px = 24, options.margin_px = 8;
  const Labelling a = solve_depth(costs, {}, options, {}), b = solve_depth(turned, {}, options, {});
  EXPECT_NEAR(total(a.report), total(b.report), 0.003 * total(a.report));
  Plane<uint8_t> back(96, 40);
  for (int x = 0; x < 96; ++x)
    for (int y = 0; y < 40; ++y) back.at((x + 13) % 96, y) = b.labels.at(x, y);
  EXPECT_NEAR(formula_energy(costs, back, {}, options), formula_energy(turned, b.labels, {}, options), 1e-6);
}

TEST(Solve, a_ring_is_smooth_across_its_seam) {
  ArrayCosts costs(64, 16, 16, true);
  for (int x = 0; x < 64; ++x)
    for (int y = 0; y < 16; ++y)
      for (int l = 0; l < 16; ++l) {  // evidence only far from the seam
        costs.cost[costs.index(x, y, l)] =
            static_cast<uint8_t>(x > 9 && x < 57 ? std::min(200, 40 * std::abs(l - 9)) : 0);
        costs.median[costs.index(x, y, l)] = 100;
      }
  const Labelling result = solve_depth(costs, {}, {}, {});
  EXPECT_THAT(result.labels.samples, testing::Each(9));
}

// A textureless wall in a textured room: within it labels 3 and 11 cost almost the same everywhere, a random one of
// the two a little less; at its rim, the truth, 3, shows.
ArrayCosts wall(int w, int h, bool ring) {
  ArrayCosts costs(w, h, 16, ring);
  std::mt19937 random(7);
  for (int x = 0; x < w; ++x)
    for (int y = 0; y < h; ++y) {
      const bool inside = x > w / 8 && x < w - w / 8 && y > h / 8 && y < h - h / 8;
      const bool favoured = (x / 120 + y / 110) % 2 == 0;
      for (int l = 0; l < 16; ++l) {
        const int depth = std::min(std::abs(l - 3), inside ? std::abs(l - 11) : 16);
        const int lure = inside && favoured == (l == 11) ? 0 : 1;
        costs.cost[costs.index(x, y, l)] =
            static_cast<uint8_t>(std::min(40, 10 * depth) + lure + static_cast<int>(random() % 2));
        costs.median[costs.index(x, y, l)] = static_cast<uint8_t>(100 + random() % 4);
      }
    }
  return costs;
}

TEST(Solve, a_wall_larger_than_any_window_takes_one_label) {
  const ArrayCosts costs = wall(740, 440, true);  // a ring of an odd number of windows
  SolveOptions options;
  options.passes = 1;
  const Labelling windows = solve_depth(costs, {}, options, on_threads(2));
  EXPECT_THAT(windows.labels.samples, testing::Contains(11));
  options.passes = 0;
  const Labelling result = solve_depth(costs, {}, options, on_threads(2));
  EXPECT_THAT(result.labels.samples, testing::Each(3));
  EXPECT_LT(total(result.report), total(windows.report));
  EXPECT_NEAR(total(result.report), formula_energy(costs, result.labels, {}, options), 0.004 * total(result.report));
  const Labelling alone = solve_depth(costs, {}, options, on_threads(1));
  EXPECT_EQ(total(alone.report), total(result.report));
}

TEST(Solve, gives_the_same_bytes_at_any_thread_count_where_regions_move) {
  const ArrayCosts costs = random_costs(960, 330, 8, false, 11);
  SolveOptions options;
  options.iterations = 1;
  const Labelling one = solve_depth(costs, {}, options, on_threads(1)),
                  many = solve_depth(costs, {}, options, on_threads(8));
  EXPECT_EQ(one.report.passes, 1);
  EXPECT_EQ(many.labels, one.labels);
  EXPECT_EQ(total(many.report), total(one.report));
  EXPECT_NEAR(total(one.report), formula_energy(costs, one.labels, {}, options), 0.004 * total(one.report));
}

TEST(TaskOrder, does_every_task_once_after_those_it_waits_for) {
  for (const int threads : {1, 2, 8}) {
    std::mt19937 random(17);
    constexpr int kTasks = 300;
    std::vector<std::atomic<int>> times_done(kTasks);
    std::atomic<int> too_early = 0;
    TaskOrder order;
    for (int i = 0; i < kTasks; ++i) {
      std::vector<int> waits_for;
      for (int k = 0; k < 3 && i > 0; ++k) waits_for.push_back(static_cast<int>(random() % static_cast<unsigned>(i)));
      order.add(
          [&, i, waits_for] {
            for (const int before : waits_for) too_early += times_done[static_cast<size_t>(before)] == 0;
            ++times_done[static_cast<size_t>(i)];
          },
          waits_for);
    }
    order.run(on_threads(threads));
    EXPECT_EQ(too_early, 0);
    for (const auto& times : times_done) EXPECT_EQ(times, 1);
  }
}

TEST(TaskOrder, goes_past_a_task_that_still_waits_to_the_first_that_does_not) {
  std::mutex mutex;
  std::vector<int> done;
  const auto note = [&](int i) {
    const std::scoped_lock lock(mutex);
    done.push_back(i);
  };
  std::latch last_but_two(1);
  TaskOrder order;
  order.add([&] { last_but_two.wait(), note(0); }, {});
  order.add([&] { note(1); }, {});
  order.add([&] { note(2); }, {0, 1});
  order.add([&] { note(3), last_but_two.count_down(); }, {1});
  order.run(on_threads(2));
  EXPECT_THAT(done, testing::ElementsAre(1, 3, 0, 2));
}

TEST(TaskOrder, rethrows_what_a_task_threw_and_begins_none_that_waits_for_it) {
  for (const int threads : {1, 4}) {
    std::atomic<bool> followed = false;
    TaskOrder order;
    for (int i = 0; i < 20; ++i) order.add([] {}, {});
    const auto thrower = order.add([] { throw std::out_of_range("task"); }, {});
    order.add([&] { followed = true; }, {thrower});
    EXPECT_THROW(order.run(on_threads(threads)), std::out_of_range);
    EXPECT_FALSE(followed);
  }
}

TEST(Solve, refuses_options_out_of_range_by_name) {
  const ArrayCosts costs = random_costs(8, 8, 4, false, 1);
  SolveOptions options;
  options.lambda = 1000;
  EXPECT_THAT([&] { solve_depth(costs, {}, options, {}); },
              testing::ThrowsMessage<std::logic_error>(testing::HasSubstr("lambda")));
  EXPECT_THAT([&] { solve_depth(costs, Plane<uint8_t>(3, 3), {}, {}); },
              testing::ThrowsMessage<std::logic_error>(testing::HasSubstr("mask")));
}

TEST(Solve, stops_when_asked) {
  const ArrayCosts costs = random_costs(64, 64, 16, false, 1);
  std::stop_source stop;
  stop.request_stop();
  Job job;
  job.stop = stop.get_token();
  EXPECT_THROW(solve_depth(costs, {}, {}, job), Cancelled);
}

// A small problem, labels that cut it into a few regions, and the regions.
struct FewRegions {
  static constexpr int kWidth = 12, kHeight = 10, kLabelCount = 4;

  FewRegions(unsigned seed, bool one_grey)
      : costs(random_costs(kWidth, kHeight, kLabelCount, seed % 3 == 0, seed, 40, one_grey ? 1 : 120)),
        labels(kWidth, kHeight) {
    if (one_grey) std::fill(costs.median.begin(), costs.median.end(), uint8_t{90});
    std::mt19937 random(seed);
    for (int x = 0; x < kWidth; x += 6)
      for (int y = 0; y < kHeight; y += 5) {
        const auto label = static_cast<uint8_t>(random() % kLabelCount);
        for (int i = 0; i < 30; ++i) labels.at(x + i / 5, y + i % 5) = label;
      }
    terms.resize(kWidth, kHeight, false);
    problem.source().load({0, 0, kWidth, kHeight}, terms, 0);
    for (int x = 0; x < kWidth; ++x) regions.add_column(terms, x * kHeight, x, problem.source(), labels);
    for (int x = 0; x + 1 < kWidth || (costs.wraps() && x < kWidth); ++x)
      regions.add_seam(terms, x * kHeight, (x + 1) % kWidth * kHeight, x, problem.source(), labels);
  }

  int64_t energy(const Plane<uint8_t>& of) const {
    int64_t sum = 0;
    const auto pair = [&](int x, int y, int x2, int y2) {
      return terms.pair(problem.smoothness(), 1, x * kHeight + y, of.at(x, y), x2 * kHeight + y2, of.at(x2, y2));
    };
    for (int x = 0; x < kWidth; ++x)
      for (int y = 0; y < kHeight; ++y) {
        sum += terms.costs(x * kHeight + y)[of.at(x, y)];
        if (y + 1 < kHeight) sum += pair(x, y, x, y + 1);
        if (x + 1 < kWidth || costs.wraps()) sum += pair(x, y, (x + 1) % kWidth, y);
      }
    return sum;
  }

  Plane<uint8_t> moved() const {
    Plane<uint8_t> now = labels;
    for (int x = 0; x < kWidth; ++x)
      for (int y = 0; y < kHeight; ++y) now.at(x, y) = regions.label_of(x, y, labels.at(x, y));
    return now;
  }

  // The least energy with some regions moved to a label, of all choices.
  int64_t least_after_a_move(const Plane<uint8_t>& from) const {
    std::map<std::array<int, 3>, int> number;  // by block and first label
    const auto key = [&](int x, int y) { return std::array<int, 3>{x / 8, y / 8, labels.at(x, y)}; };
    for (int x = 0; x < kWidth; ++x)
      for (int y = 0; y < kHeight; ++y) number.emplace(key(x, y), static_cast<int>(number.size()));
    int64_t least = energy(from);
    for (uint8_t alpha = 0; alpha < kLabelCount; ++alpha)
      for (int subset = 0; subset < 1 << number.size(); ++subset) {
        Plane<uint8_t> candidate = from;
        for (int x = 0; x < kWidth; ++x)
          for (int y = 0; y < kHeight; ++y)
            if (subset >> number.at(key(x, y)) & 1) candidate.at(x, y) = alpha;
        least = std::min(least, energy(candidate));
      }
    return least;
  }

  ArrayCosts costs;
  Plane<uint8_t> labels;
  PixelTerms terms;
  SolveOptions options;
  DepthProblem problem{costs, no_mask, options};
  Regions regions{kWidth, kHeight, kLabelCount, problem.smoothness()};
  static inline const Plane<uint8_t> no_mask;
};

TEST(Regions, move_until_no_set_of_them_gains_by_moving_to_one_label) {
  int fell = 0;
  for (unsigned seed = 0; seed < 40; ++seed) {
    FewRegions few(seed, true);
    const int64_t before = few.energy(few.labels);
    EXPECT_EQ(few.regions.energy().total(), before) << "seed " << seed;
    few.regions.move(20, {});
    const Plane<uint8_t> moved = few.moved();
    EXPECT_EQ(few.energy(moved), few.regions.energy().total()) << "seed " << seed;
    EXPECT_EQ(few.energy(moved), few.least_after_a_move(moved)) << "seed " << seed;
    fell += few.energy(moved) < before;
  }
  EXPECT_GT(fell, 20);
}

TEST(Regions, energy_falls_by_at_least_what_they_say_where_greys_differ) {
  int fell = 0;
  for (unsigned seed = 0; seed < 40; ++seed) {
    FewRegions few(seed, false);
    const int64_t before = few.energy(few.labels);
    EXPECT_EQ(few.regions.energy().total(), before) << "seed " << seed;
    few.regions.move(20, {});
    EXPECT_LE(few.energy(few.moved()), few.regions.energy().total()) << "seed " << seed;
    EXPECT_LE(few.regions.energy().total(), before) << "seed " << seed;
    fell += few.regions.energy().total() < before;
  }
  EXPECT_GT(fell, 10);
}

// A small grid with random costs, greys, edges and messages.
LabelGrid random_grid(int w, int h, unsigned seed, bool positions) {
  LabelGrid grid;
  grid.resize(w, h, positions);
  std::mt19937 random(seed);
  const auto uniform = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
  for (auto& cost : grid.cost) cost = static_cast<uint16_t>(uniform(300));
  for (auto& grey : grid.grey) grey = static_cast<uint8_t>(uniform(256));
  for (auto& position : grid.position) position = static_cast<uint8_t>(uniform(40));
  for (auto& message : grid.message) message = static_cast<uint8_t>(uniform(60));
  for (auto& label : grid.label) label = static_cast<uint8_t>(uniform(16));
  for (int x = 0; x < w; ++x)
    for (int y = 0; y < h; ++y) {
      if (y + 1 < h) grid.down[static_cast<size_t>(x * h + y)] = static_cast<uint8_t>(uniform(3));
      if (x + 1 < w) grid.right[static_cast<size_t>(x * h + y)] = static_cast<uint8_t>(uniform(3));
    }
  // Messages of missing edges are no part of the energy.
  for (int p = 0; p < grid.size(); ++p)
    for (int d = 0; d < 4; ++d)
      if (grid.factor(p, d) == 0) std::fill_n(grid.message.begin() + (p * 4 + d) * kSlots, kSlots, uint8_t{0});
  grid.find_grey_ranges();
  return grid;
}

// The energy that a move bounds from above: pair terms that break submodularity raised where only the upper or left
// pixel moves.
int64_t raised_energy(const LabelGrid& before, const LabelGrid& after, const Smoothness& smoothness, int alpha) {
  int64_t sum = 0;
  for (int p = 0; p < before.size(); ++p) {
    const auto label = [](const LabelGrid& grid, int pixel) {
      return static_cast<int>(grid.label[static_cast<size_t>(pixel)]);
    };
    sum += after.costs(p)[label(after, p)];
    for (const int d : {kDown, kRight}) {
      const int factor = before.factor(p, d);
      if (factor == 0) continue;
      const int q = p + before.stride(d), fp = label(before, p), fq = label(before, q);
      const auto v = [&](int a, int b) { return before.pair(smoothness, factor, p, a, q, b); };
      sum += v(label(after, p), label(after, q));
      const bool only_p = label(after, p) == alpha && label(after, q) == fq && fp != alpha && fq != alpha;
      if (only_p) sum += std::max(0, v(fp, fq) + v(alpha, alpha) - v(fp, alpha) - v(alpha, fq));
    }
  }
  return sum;
}

TEST(Expansion, a_move_is_the_least_of_all_cuts_and_never_raises_the_energy) {
  const Smoothness smoothness(60, 0.01, 2, 2);
  for (unsigned seed = 0; seed < 300; ++seed) {
    const int w = 1 + static_cast<int>(seed % 4), h = 12 / w;
    LabelGrid grid = random_grid(w, h, seed, seed % 3 == 0);
    const int alpha = static_cast<int>(seed / 4 % 16);
    const LabelGrid before = grid;
    Expansion expansion;
    expansion.start(grid, smoothness);
    const bool changed = expansion.expand(alpha);
    int64_t least = 1 << 30;
    for (int subset = 0; subset < 1 << (w * h); ++subset) {
      LabelGrid candidate = before;
      for (int p = 0; p < w * h; ++p)
        if (subset >> p & 1) candidate.label[static_cast<size_t>(p)] = static_cast<uint8_t>(alpha);
      least = std::min(least, raised_energy(before, candidate, smoothness, alpha));
    }
    EXPECT_EQ(raised_energy(before, grid, smoothness, alpha), least) << "seed " << seed;
    const int64_t old_energy = energy_of(before, smoothness).total(), new_energy = energy_of(grid, smoothness).total();
    EXPECT_EQ(changed, new_energy < old_energy) << "seed " << seed;
    EXPECT_LE(new_energy, old_energy);
  }
}

// What a message is: for each slot of q the least over the slots of p, in full.
std::vector<int> plain_message(const LabelGrid& grid, const Smoothness& smoothness, int p, int direction, bool halve) {
  std::vector<int> belief(kSlots), out(kSlots, 1 << 20);
  for (int a = 0; a < kSlots; ++a) {
    belief[static_cast<size_t>(a)] = grid.costs(p)[a];
    for (int d = 0; d < 4; ++d) belief[static_cast<size_t>(a)] += grid.messages(p, d)[a];
  }
  const int least = *std::min_element(belief.begin(), belief.end());
  for (int a = 0; a < kSlots; ++a) {
    int& rest = belief[static_cast<size_t>(a)];
    rest = (halve ? (rest - least) / 2 : rest - least) - grid.messages(p, direction)[a];
  }
  const int floor = *std::min_element(belief.begin(), belief.end());
  const int q = p + grid.stride(direction), factor = grid.factor(p, direction);
  for (int a = 0; a < kSlots; ++a)
    for (int b = 0; b < kSlots; ++b)
      out[static_cast<size_t>(b)] =
          std::min(out[static_cast<size_t>(b)],
                   belief[static_cast<size_t>(a)] - floor + grid.pair(smoothness, factor, p, a, q, b));
  return out;
}

void plain_sweep(LabelGrid& grid, const Smoothness& smoothness, bool forward) {
  for (int i = 0; i < grid.size(); ++i) {
    const int p = forward ? i : grid.size() - 1 - i;
    const bool halve =
        (grid.factor(p, kDown) && grid.factor(p, kRight)) || (grid.factor(p, kUp) && grid.factor(p, kLeft));
    for (const int d : {forward ? kDown : kUp, forward ? kRight : kLeft}) {
      if (grid.factor(p, d) == 0) continue;
      const auto message = plain_message(grid, smoothness, p, d, halve);
      std::copy(message.begin(), message.end(), grid.message.begin() + ((p + grid.stride(d)) * 4 + (d ^ 1)) * kSlots);
    }
  }
}

std::vector<const MessageKernels*> all_kernels() {
  std::vector<const MessageKernels*> kernels = {&base_kernels::kMessageKernels};
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2")) kernels.push_back(&avx2_kernels::kMessageKernels);
#endif
  return kernels;
}

TEST(MessageKernels, every_instruction_set_gives_the_messages_of_the_plain_loops) {
  for (const MessageKernels* kernels : all_kernels())
    for (unsigned seed = 0; seed < 60; ++seed) {
      const int truncation = 1 + static_cast<int>(seed % 4);
      const Smoothness smoothness(125 / truncation, seed % 5 == 0 ? 0.0 : 0.01, truncation, 2);
      const bool positions = seed % 3 == 0;
      LabelGrid grid = random_grid(6, 5, seed, positions);
      if (positions)
        for (int p = 0; p < grid.size(); ++p) std::fill_n(grid.grey.begin() + p * kSlots, kSlots, grid.greys(p)[0]);
      grid.find_grey_ranges();
      std::fill(grid.message.begin(), grid.message.end(), uint8_t{0});
      LabelGrid plain = grid;
      for (int i = 0; i < 3; ++i)
        for (const bool forward : {true, false}) {
          kernels->sweep(grid.kernel_grid(smoothness), forward, 0, grid.width);
          plain_sweep(plain, smoothness, forward);
          ASSERT_EQ(grid.message, plain.message) << "seed " << seed << " sweep " << i << forward;
        }
    }
}

TEST(MessageKernels, every_instruction_set_gives_the_same_gains_and_labels) {
  for (unsigned seed = 0; seed < 40; ++seed) {
    const Smoothness smoothness(60, 0.01, 2, 2);
    const LabelGrid grid = random_grid(6, 5, seed, seed % 3 == 0);
    std::vector<std::vector<int>> results;
    for (const MessageKernels* kernels : all_kernels()) {
      LabelGrid copy = grid;
      std::vector<int> result;
      for (int p = 0; p < copy.size(); ++p) {
        int16_t gain[kSlots];
        result.push_back(static_cast<int>(kernels->gains(copy.kernel_grid(smoothness), p, gain)));
        result.insert(result.end(), gain, gain + kSlots);
      }
      kernels->decide(copy.kernel_grid(smoothness));
      result.insert(result.end(), copy.label.begin(), copy.label.end());
      results.push_back(result);
    }
    for (const auto& result : results) EXPECT_EQ(result, results[0]);
  }
}

TEST(MessageKernels, every_instruction_set_finds_the_first_least_cost_and_the_range_of_greys) {
  const LabelGrid random = random_grid(9, 7, 5, false);
  std::vector<uint16_t> costs = random.cost;
  for (size_t i = 0; i < costs.size(); i += 3) costs[i] = static_cast<uint16_t>(costs[i] % 4);  // many equal ones
  costs[5] = kForbidden;
  for (const MessageKernels* kernels : all_kernels()) {
    std::vector<uint8_t> slots(static_cast<size_t>(random.size())), ranges(slots.size() * 2);
    kernels->cheapest(costs.data(), random.size(), slots.data());
    kernels->grey_ranges(random.grey.data(), random.size(), ranges.data());
    for (size_t p = 0; p < slots.size(); ++p) {
      const auto* of_pixel = costs.data() + p * kSlots;
      EXPECT_EQ(slots[p], std::min_element(of_pixel, of_pixel + kSlots) - of_pixel);
      const auto [least, largest] =
          std::minmax_element(random.grey.data() + p * kSlots, random.grey.data() + (p + 1) * kSlots);
      EXPECT_EQ(ranges[2 * p], *least);
      EXPECT_EQ(ranges[2 * p + 1], *largest);
    }
  }
}

// Frames on a line; each pixel is seen by those near it, at an angle that grows with the distance.
struct LineOfFrames final : ColourCosts {
  explicit LineOfFrames(int frames_count, bool ring) : frames_(frames_count), ring_(ring) {}
  int width() const override { return 120; }
  int height() const override { return 30; }
  bool wraps() const override { return ring_; }
  int frames() const override { return frames_; }
  int candidates(int x, int y, uint16_t frame[16], uint16_t cost[16]) const override {
    int count = 0;
    for (int f = 0; f < frames_ && count < 16; ++f) {
      const double centre = (f + 0.5) * 120 / frames_;
      double distance = std::abs(x + 0.5 - centre);
      if (ring_) distance = std::min(distance, 120 - distance);
      if (distance > 25 || (x * 7 + y * 3) % 23 == f % 5) continue;
      frame[count] = static_cast<uint16_t>(f);
      cost[count++] = static_cast<uint16_t>(64 * distance);
    }
    return count;
  }
  uint8_t depth_label(int x, int y) const override { return static_cast<uint8_t>((x / 10 + y / 10) % 16); }
  bool present(int x, int y) const override { return (x + y) % 31 != 0; }
  int frames_;
  bool ring_;
};

TEST(Solve, chooses_frames_that_see_the_pixel_and_reports_their_angles) {
  for (const int frames : {5, 20, 40, 255, 256, 300, 1000}) {
    const LineOfFrames costs(frames, frames == 20 || frames == 300);
    const ColourSolve result = solve_colour(costs, {}, on_threads(2));
    double angles = 0;
    for (int y = 0; y < costs.height(); ++y)
      for (int x = 0; x < costs.width(); ++x) {
        uint16_t frame[16], cost[16];
        const int count = costs.present(x, y) ? costs.candidates(x, y, frame, cost) : 0;
        const auto* chosen = std::find(frame, frame + count, result.sources.at(x, y));
        if (count == 0) {
          EXPECT_EQ(result.sources.at(x, y), kNoSource);
        } else {
          ASSERT_NE(chosen, frame + count) << x << ' ' << y;
          angles += cost[chosen - frame] / 64.0;
        }
      }
    // Up to 40 frames angles are whole steps of the solver's; each is rounded by half a step otherwise, 1/120 degree.
    const double rounded = frames <= 40 ? 0 : 120 * 30 / 120.0;
    EXPECT_NEAR(result.report.data_energy, angles, 1e-6 + rounded);
    EXPECT_LT(total(result.report), result.report.initial_energy);
  }
}

}  // namespace
}  // namespace ldp::solve
