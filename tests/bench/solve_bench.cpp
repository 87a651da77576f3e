// Energy, speed and memory of the solver against a whole-grid alpha-expansion and a lower bound.
//
//   solve_bench [--reference] [--bound ITERATIONS] [--iterations N] [--passes N] [--core PX] [--margin PX] [--save
//   FILE.volume] NAME...
//
// NAME: tsukuba, teddy, either with 1600 or 2400 appended (mirror-tiled to 1600x600, 2400x700), a capture folder, or a
// saved volume.
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>
#include <vector>

#include "core/solve/depth_problem.h"
#include "tests/bench/solve_reference.h"
#include "tests/bench/solve_volumes.h"

namespace ldp::solve {
namespace {

struct Settings {
  bool reference = false;
  std::string save;
  int bound_iterations = 0;
  int core_px = 64, margin_px = 8, iterations = 4, passes = 0;
  std::vector<std::string> names;
};

Settings parse(int argc, char** argv) {
  Settings settings;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--reference")
      settings.reference = true;
    else if (word == "--bound")
      settings.bound_iterations = std::atoi(argv[++i]);
    else if (word == "--core")
      settings.core_px = std::atoi(argv[++i]);
    else if (word == "--iterations")
      settings.iterations = std::atoi(argv[++i]);
    else if (word == "--passes")
      settings.passes = std::atoi(argv[++i]);
    else if (word == "--save")
      settings.save = argv[++i];
    else if (word == "--margin")
      settings.margin_px = std::atoi(argv[++i]);
    else
      settings.names.push_back(word);
  }
  if (settings.names.empty()) settings.names = {"tsukuba", "teddy", "tsukuba2400", "teddy1600", "teddy2400"};
  return settings;
}

Problem make_problem(const std::string& name) {
  if (name.ends_with(".volume")) return saved_problem(name);
  if (name.find('/') != std::string::npos) return capture_problem(name);
  const size_t digits = name.find_first_of("0123456789");
  Problem problem = name.substr(0, digits) == "teddy" ? teddy16() : tsukuba();
  if (digits == std::string::npos) return problem;
  const int width = std::stoi(name.substr(digits));
  return mirror_tiled(problem, width, width == 1600 ? 600 : 700);
}

double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

void compare(const DepthProblem& whole, const Problem& problem, double energy, const Settings& settings) {
  LabelGrid grid;
  const Window everything{0, 0, problem.volume.width(), problem.volume.height()};
  grid.resize(everything.width, everything.height, false);
  whole.source().load(everything, grid, 0);
  set_edges(whole.source(), everything, grid);
  const double unit = whole.grey_levels_per_unit() / problem.unit;
  const auto least = static_cast<double>(problem.volume.least_sum());
  if (settings.bound_iterations > 0) {
    const double bound = lower_bound(grid, whole.smoothness(), settings.bound_iterations) * unit + least;
    std::printf("  bound %.1f gap %+.3f %%", bound, 100 * (energy - bound) / bound);
  }
  if (settings.reference) {
    const double start = cpu_seconds();
    expand_whole_grid(grid, whole.smoothness(), problem.volume.labels());
    const double reference = static_cast<double>(energy_of(grid, whole.smoothness()).total()) * unit + least;
    std::printf("  whole-grid expansion %.1f (%.2f s) dE %+.3f %%", reference, cpu_seconds() - start,
                100 * (energy - reference) / reference);
  }
}

void run(Problem problem, const Settings& settings) {
  if (!settings.save.empty()) save_volume(problem.volume, settings.save);
  SolveOptions options = problem.options;
  options.core_px = settings.core_px;
  options.margin_px = settings.margin_px;
  options.iterations = settings.iterations;
  options.passes = settings.passes;
  if (!problem.factors.right.empty()) options.factors = &problem.factors;
  const double start = cpu_seconds();
  const Labelling result = solve_depth(problem.volume, {}, options, {});
  const double seconds = cpu_seconds() - start;
  const auto pixels = static_cast<double>(result.labels.samples.size());
  const double energy = (result.report.data_energy + result.report.smoothness_energy) / problem.unit +
                        static_cast<double>(problem.volume.least_sum());
  std::printf("%-12s %dx%d E %.0f  %.2f s  %.2f Mpl/s  %.1f B/node  %d passes", problem.name.c_str(),
              result.labels.width, result.labels.height, energy, seconds,
              pixels * problem.volume.labels() / seconds * 1e-6, static_cast<double>(result.report.peak_bytes) / pixels,
              result.report.passes);
  std::fflush(stdout);
  if (settings.reference || settings.bound_iterations > 0)
    compare(DepthProblem(problem.volume, {}, options), problem, energy, settings);
  std::printf("\n");
}

}  // namespace
}  // namespace ldp::solve

int main(int argc, char** argv) {
  const ldp::solve::Settings settings = ldp::solve::parse(argc, argv);
  for (const auto& name : settings.names) ldp::solve::run(ldp::solve::make_problem(name), settings);
}
