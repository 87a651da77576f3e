#include "tests/bench/verdict/summary.h"

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <map>

#include "core/verdict/words.h"

namespace ldp {
namespace {

constexpr double kMuchWorse_db = 6;
constexpr double kFarOff_db = 3;

std::string line(const char* format, ...) __attribute__((format(printf, 1, 2)));
std::string line(const char* format, ...) {
  char text[256];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  return std::string(text) + "\n";
}

// Equal values share the mean of their ranks.
std::vector<double> ranks(const std::vector<double>& values) {
  std::vector<double> sorted = values, result;
  std::sort(sorted.begin(), sorted.end());
  for (const double value : values) {
    const auto [from, to] = std::equal_range(sorted.begin(), sorted.end(), value);
    result.push_back(0.5 * static_cast<double>((from - sorted.begin()) + (to - sorted.begin()) - 1));
  }
  return result;
}

double correlation(const std::vector<double>& a, const std::vector<double>& b) {
  const double middle = 0.5 * static_cast<double>(a.size() - 1);
  double ab = 0, aa = 0, bb = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    ab += (a[i] - middle) * (b[i] - middle);
    aa += (a[i] - middle) * (a[i] - middle);
    bb += (b[i] - middle) * (b[i] - middle);
  }
  return aa * bb > 0 ? ab / std::sqrt(aa * bb) : 0;
}

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

bool is_told(const JudgedSweep& sweep) { return !sweep.refused.empty() || sweep.quality.grade != Grade::good; }

std::string name_of(const JudgedSweep& sweep) {
  return sweep.scene + " " + std::to_string(sweep.seed) + " " + sweep.spoil;
}

std::string verdict_of(const JudgedSweep& sweep) {
  std::string text = name_of(sweep.quality.grade);
  for (const QualityFinding& finding : sweep.quality.reasons) text += std::string(" ") + code_of(finding.reason);
  return text;
}

class Summary {
 public:
  explicit Summary(const std::vector<JudgedSweep>& sweeps) : sweeps_(sweeps) {
    for (const JudgedSweep& sweep : sweeps)
      if (sweep.spoil == "clean" && sweep.truth) clean_db_[sweep.seed] = sweep.truth->matched_db;
  }

  std::string text() {
    add_expectation();
    add_much_worse();
    add_clean();
    return figures_ + misses_;
  }

 private:
  void add_expectation() {
    std::vector<double> expected, known, errors;
    for (const JudgedSweep& sweep : sweeps_) {
      if (!sweep.truth) continue;
      expected.push_back(sweep.quality.expected_view_psnr_db);
      known.push_back(sweep.truth->matched_db);
      errors.push_back(std::abs(expected.back() - known.back()));
      if (errors.back() > kFarOff_db)
        misses_ += line("far off: %s: expected %.1f, true %.1f dB; %s", name_of(sweep).c_str(), expected.back(),
                        known.back(), verdict_of(sweep).c_str());
    }
    figures_ += line("sweeps: %zu, with a panorama %zu", sweeps_.size(), expected.size());
    figures_ += line("rank correlation of expected and true PSNR: %.3f", correlation(ranks(expected), ranks(known)));
    figures_ += line("median error of the expectation: %.2f dB", median(errors));
  }

  void add_much_worse() {
    int worse = 0, told = 0;
    for (const JudgedSweep& sweep : sweeps_) {
      if (!sweep.truth || !clean_db_.contains(sweep.seed)) continue;
      const double loss = clean_db_.at(sweep.seed) - sweep.truth->matched_db;
      if (loss <= kMuchWorse_db) continue;
      ++worse;
      told += is_told(sweep) ? 1 : 0;
      if (!is_told(sweep)) misses_ += line("not told: %s: %.1f dB worse", name_of(sweep).c_str(), loss);
    }
    figures_ += line("more than %.0f dB worse than their clean copy: %d, told %d", kMuchWorse_db, worse, told);
  }

  void add_clean() {
    int clean = 0, told = 0;
    for (const JudgedSweep& sweep : sweeps_) {
      if (sweep.spoil != "clean") continue;
      ++clean;
      told += is_told(sweep) ? 1 : 0;
      if (is_told(sweep))
        misses_ += line("false alarm: %s: %s", name_of(sweep).c_str(),
                        sweep.refused.empty() ? verdict_of(sweep).c_str() : sweep.refused.c_str());
    }
    figures_ += line("clean: %d, told %d", clean, told);
  }

  const std::vector<JudgedSweep>& sweeps_;
  std::map<uint32_t, double> clean_db_;
  std::string figures_, misses_;
};

}  // namespace

std::string summary_of(const std::vector<JudgedSweep>& sweeps) { return Summary(sweeps).text(); }

}  // namespace ldp
