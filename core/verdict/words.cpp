#include "core/verdict/words.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <vector>

namespace ldp {
namespace {

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
    {"photos_left_out", "many photos could not be placed beside the others", "take one sweep alone, without haste"},
    {"exposure_jumps", "the exposure jumps between the photos%s", "lock the exposure"},
    {"contradicted", "the photos%s contradict each other", "wait until nothing moves, and keep away from what is near"},
    {"holes", "views%s have holes", "sweep all of it"},
    {"lens_doubtful", "the photos do not fit the lens", "give its true field of view, or none"},
}};

const Words& words_of(QualityReason reason) { return kWords[static_cast<size_t>(reason)]; }

std::string place(const QualityFinding& finding) {
  const std::string from = std::to_string(std::lround(finding.from_deg)),
                    to = std::to_string(std::lround(finding.to_deg));
  return from == to ? " near " + from + " degrees" : " between " + from + " and " + to + " degrees";
}

std::string text_of(QualityReason reason, const std::string& places) {
  const Words& words = words_of(reason);
  std::string text = words.wrong;
  if (const size_t at = text.find("%s"); at != std::string::npos) text.replace(at, 2, places);
  return text + ": " + words.advice;
}

}  // namespace

const char* name_of(Grade grade) {
  constexpr std::array kNames = {"good", "fair", "sweep_again"};
  return kNames[static_cast<size_t>(grade)];
}

const char* code_of(QualityReason reason) { return words_of(reason).code; }

std::string text_of(const QualityFinding& finding) { return text_of(finding.reason, place(finding)); }

// Places of one reason by their angle, whatever their grades.
std::string reasons_of(const SweepQuality& quality) {
  std::string text;
  const auto& all = quality.reasons;
  for (auto first = all.begin(); first != all.end(); ++first) {
    std::vector<QualityFinding> alike;
    std::copy_if(all.begin(), all.end(), std::back_inserter(alike),
                 [&](const QualityFinding& finding) { return finding.reason == first->reason; });
    if (alike.front() != *first) continue;  // told already
    std::stable_sort(alike.begin(), alike.end(), [](const auto& a, const auto& b) { return a.from_deg < b.from_deg; });
    std::string places;
    for (const QualityFinding& finding : alike) places += (places.empty() ? "" : " and") + place(finding);
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
