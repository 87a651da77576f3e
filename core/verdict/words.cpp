#include "core/verdict/words.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <utility>
#include <vector>

namespace ldp {
namespace {

constexpr double kTouching_deg = 1.5;  // between places that are told as one

struct Words {
  const char* code;
  const char* wrong;  // with %s where the place goes
  const char* advice;
};

constexpr std::array<Words, kQualityReasons> kWords = {{
    {"blurred", "the photos%s are blurred", "turn more slowly there"},
    {"dark", "the photos%s are dark and noisy", "take them in more light, or turn more slowly at a longer exposure"},
    {"little_overlap", "the photos%s show too little in common", "take more of them, three quarters overlapping"},
    {"no_parallax", "the camera only turned and did not move", "hold it at arm's length and turn on the spot"},
    {"moved_forward", "the camera moved forward instead of around", "stay on the spot and turn"},
    {"moved_straight", "the camera moved along a line instead of around", "stay on the spot and turn"},
    {"poses_doubtful", "where the camera was is doubtful", "turn slowly, past things that differ and stand still"},
    {"photos_left_out", "many photos were left out", "take one sweep alone, without haste"},
    {"exposure_jumps", "the exposure jumps between the photos%s", "lock the exposure"},
    {"contradicted", "the photos%s contradict each other", "wait until nothing moves, and keep away from what is near"},
    {"holes", "views%s have holes", "sweep all of it"},
    {"lens_doubtful", "the photos do not fit the lens", "give its true field of view, or none"},
    {"looked_inward", "the camera went around a thing and looked at it", "stay on the spot, turn, and look outward"},
}};

const Words& words_of(QualityReason reason) { return kWords[static_cast<size_t>(reason)]; }

// Beyond a turn angles begin anew; those before the first photo's are negative.
std::string place(const QualityFinding& finding) {
  const double before_deg = kTurn_deg * std::max(0.0, std::floor(finding.from_deg / kTurn_deg));
  const double behind_deg = finding.to_deg - before_deg > kTurn_deg ? before_deg + kTurn_deg : before_deg;
  const std::string from = std::to_string(std::lround(finding.from_deg - before_deg)),
                    to = std::to_string(std::lround(finding.to_deg - behind_deg));
  return from == to ? " near " + from + " degrees" : " between " + from + " and " + to + " degrees";
}

std::string text_of(QualityReason reason, const std::string& places) {
  const Words& words = words_of(reason);
  std::string text = words.wrong;
  if (const size_t at = text.find("%s"); at != std::string::npos) text.replace(at, 2, places);
  return text + ": " + words.advice;
}

QualityFinding turned(QualityFinding finding, double by_deg) {
  return {finding.reason, finding.from_deg + by_deg, finding.to_deg + by_deg};
}

bool holds(const QualityFinding& outer, const QualityFinding& inner) {
  const auto lies_in = [&](double by_deg) {
    const QualityFinding place = turned(inner, by_deg);
    return place.from_deg >= outer.from_deg && place.to_deg <= outer.to_deg;
  };
  return outer.to_deg - outer.from_deg >= kTurn_deg || lies_in(-kTurn_deg) || lies_in(0) || lies_in(kTurn_deg);
}

// Joins the second to the first, which begins before it, where they touch.
bool join(QualityFinding& first, const QualityFinding& second) {
  if (second.from_deg - first.to_deg > kTouching_deg) return false;
  first.to_deg = std::max(first.to_deg, second.to_deg);
  if (first.to_deg - first.from_deg >= kTurn_deg) first = {first.reason, 0, kTurn_deg};
  return true;
}

// Of one reason, by their angle, whatever their grades: those that hold another one are left out, those that touch are
// one.
std::vector<QualityFinding> places_of(std::vector<QualityFinding> alike) {
  std::stable_sort(alike.begin(), alike.end(), [](const auto& a, const auto& b) { return a.from_deg < b.from_deg; });
  std::vector<QualityFinding> places;
  for (const QualityFinding& finding : alike) {
    const bool holds_another = std::any_of(alike.begin(), alike.end(), [&](const QualityFinding& other) {
      return holds(finding, other) && !holds(other, finding);
    });
    if (!holds_another && (places.empty() || !join(places.back(), finding))) places.push_back(finding);
  }
  if (places.size() > 1 && join(places.back(), turned(places.front(), kTurn_deg))) places.erase(places.begin());
  return places;
}

}  // namespace

const char* name_of(Grade grade) {
  constexpr std::array kNames = {"good", "fair", "sweep_again"};
  return kNames[static_cast<size_t>(grade)];
}

const char* code_of(QualityReason reason) { return words_of(reason).code; }

std::string text_of(const QualityFinding& finding) { return text_of(finding.reason, place(finding)); }

std::string reasons_of(const SweepQuality& quality) {
  std::string text;
  const auto& all = quality.reasons;
  for (auto first = all.begin(); first != all.end(); ++first) {
    std::vector<QualityFinding> alike;
    std::copy_if(all.begin(), all.end(), std::back_inserter(alike),
                 [&](const QualityFinding& finding) { return finding.reason == first->reason; });
    if (alike.front() != *first) continue;  // told already
    std::string places;
    for (const QualityFinding& finding : places_of(std::move(alike)))
      places += (places.empty() ? "" : " and") + place(finding);
    text += (text.empty() ? "" : "; ") + text_of(first->reason, places);
  }
  return text;
}

const char* text_of(Grade grade) {
  constexpr std::array kNames = {"good", "fair", "sweep again"};
  return kNames[static_cast<size_t>(grade)];
}

std::string text_of(const SweepQuality& quality) {
  std::string told = reasons_of(quality);
  if (quality.expected_view_psnr_db > 0)
    told = "new views of about " + std::to_string(std::lround(quality.expected_view_psnr_db)) + " dB" +
           (told.empty() ? "" : "; ") + told;
  return std::string(text_of(quality.grade)) + (told.empty() ? "" : ": " + told);
}

}  // namespace ldp
