#include "core/verdict/sweep_quality.h"

#include <cmath>
#include <cstdio>
#include <initializer_list>

namespace ldp {
namespace {

constexpr int kMostEntries = 100;  // of a list: their numbers have two digits

std::string entry(const char* list, int index, const char* field) {
  char name[64];
  std::snprintf(name, sizeof name, "%s.%02d.%s", list, index, field);
  return name;
}

// Reads figures by name; once one is missing or wrong, everything is.
class Figures {
 public:
  explicit Figures(const std::map<std::string, double>& figures) : figures_(figures) {}

  bool has(const std::string& name) const { return figures_.contains(name); }
  bool sound() const { return sound_; }
  double number(const std::string& name) {
    const auto at = figures_.find(name);
    if (at != figures_.end() && std::isfinite(at->second)) return at->second;
    sound_ = false;
    return 0;
  }
  int whole(const std::string& name, int count) {
    const double value = number(name);
    if (value >= 0 && value < count && value == std::floor(value)) return static_cast<int>(value);
    sound_ = false;
    return 0;
  }

 private:
  const std::map<std::string, double>& figures_;
  bool sound_ = true;
};

constexpr int kGrades = 3;

QualityFinding finding_from(Figures& figures, int index) {
  return {static_cast<QualityReason>(figures.whole(entry("reason", index, "code"), kQualityReasons)),
          figures.number(entry("reason", index, "from_deg")), figures.number(entry("reason", index, "to_deg"))};
}

DirectionQuality direction_from(Figures& figures, int index) {
  const auto field = [&](const char* name) { return figures.number(entry("direction", index, name)); };
  return {field("from_deg"),
          field("to_deg"),
          static_cast<Grade>(figures.whole(entry("direction", index, "verdict"), kGrades)),
          field("expected_view_psnr_db"),
          field("photos_back_psnr_db"),
          field("unexplained_share")};
}

}  // namespace

std::map<std::string, double> figures_of(const SweepQuality& quality) {
  std::map<std::string, double> figures{{"verdict", static_cast<double>(quality.grade)},
                                        {"expected_view_psnr_db", quality.expected_view_psnr_db},
                                        {"photos_back_psnr_db", quality.photos_back_psnr_db},
                                        {"unexplained_share", quality.unexplained_share}};
  for (int i = 0; i < std::ssize(quality.reasons) && i < kMostEntries; ++i) {
    const QualityFinding& finding = quality.reasons[static_cast<size_t>(i)];
    figures[entry("reason", i, "code")] = static_cast<double>(finding.reason);
    figures[entry("reason", i, "from_deg")] = finding.from_deg;
    figures[entry("reason", i, "to_deg")] = finding.to_deg;
  }
  for (int i = 0; i < std::ssize(quality.by_direction) && i < kMostEntries; ++i) {
    const DirectionQuality& direction = quality.by_direction[static_cast<size_t>(i)];
    figures[entry("direction", i, "from_deg")] = direction.from_deg;
    figures[entry("direction", i, "to_deg")] = direction.to_deg;
    figures[entry("direction", i, "verdict")] = static_cast<double>(direction.grade);
    figures[entry("direction", i, "expected_view_psnr_db")] = direction.expected_view_psnr_db;
    figures[entry("direction", i, "photos_back_psnr_db")] = direction.photos_back_psnr_db;
    figures[entry("direction", i, "unexplained_share")] = direction.unexplained_share;
  }
  return figures;
}

std::optional<SweepQuality> quality_from(const std::map<std::string, double>& figures) {
  Figures read(figures);
  SweepQuality quality;
  quality.grade = static_cast<Grade>(read.whole("verdict", kGrades));
  quality.expected_view_psnr_db = read.number("expected_view_psnr_db");
  quality.photos_back_psnr_db = read.number("photos_back_psnr_db");
  quality.unexplained_share = read.number("unexplained_share");
  for (int i = 0; i < kMostEntries && read.has(entry("reason", i, "code")); ++i)
    quality.reasons.push_back(finding_from(read, i));
  for (int i = 0; i < kMostEntries && read.has(entry("direction", i, "verdict")); ++i)
    quality.by_direction.push_back(direction_from(read, i));
  if (!read.sound()) return std::nullopt;
  return quality;
}

bool is_of_verdict(const std::string& name) {
  for (const char* own : {"verdict", "expected_view_psnr_db", "photos_back_psnr_db", "unexplained_share"})
    if (name == own) return true;
  return name.starts_with("reason.") || name.starts_with("direction.");
}

}  // namespace ldp
