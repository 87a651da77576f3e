#include <algorithm>
#include <array>
#include <cstdio>
#include <span>

#include "core/base/markup_text.h"
#include "device/tool/many/build_outcomes.h"

namespace ldp {
namespace {

constexpr const char* kStyle =
    "body{font:16px sans-serif;margin:1em;background:#fff;color:#222}figure{display:inline-block;vertical-align:top;"
    "width:17em;margin:.4em;padding:.5em;border:1px solid #ccc;border-left:.5em solid #999}"
    "img{width:100%;height:7em;object-fit:cover;background:#eee}figcaption{overflow-wrap:anywhere;font-size:.85em}"
    ".good{border-left-color:#2a7}.fair{border-left-color:#da2}.sweep_again{border-left-color:#d63}"
    ".failed{border-left-color:#b12}"
    "@media(prefers-color-scheme:dark){body{background:#181818;color:#ddd}figure{border-color:#444}}";

// The worst first.
size_t rank_of(const BuildOutcome& outcome) {
  constexpr std::array kOrder{"failed", "sweep_again", "unknown", "fair", "good"};
  return static_cast<size_t>(std::find(kOrder.begin(), kOrder.end(), outcome.verdict) - kOrder.begin());
}

std::string figure_of(const BuildOutcome& outcome) {
  std::string html = "<figure class=\"" + escaped(outcome.verdict) + "\">";
  if (!outcome.thumbnail.empty())
    html += "<img alt=\"\" loading=\"lazy\" src=\"data:image/jpeg;base64," + base64(outcome.thumbnail) + "\">";
  html += "<figcaption><b>" + escaped(outcome.name) + "</b>: " + escaped(outcome.verdict);
  if (outcome.expected_view_psnr_db) {
    char text[32];
    std::snprintf(text, sizeof text, ", %.1f dB", *outcome.expected_view_psnr_db);
    html += text;
  }
  if (!outcome.reasons.empty()) html += "<br>" + escaped(outcome.reasons);
  return html + "</figcaption></figure>\n";
}

}  // namespace

std::string summary_page(const std::string& title, const std::vector<BuildOutcome>& outcomes) {
  std::vector<const BuildOutcome*> sorted;
  for (const BuildOutcome& outcome : outcomes) sorted.push_back(&outcome);
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const auto* a, const auto* b) { return rank_of(*a) < rank_of(*b); });
  const Totals totals = totals_of(outcomes);
  char counts[160], hours[48] = "";
  std::snprintf(counts, sizeof counts, "%zu %s: %zu failed, %zu to sweep again, %zu fair, %zu good", outcomes.size(),
                outcomes.size() == 1 ? "build" : "builds", totals.failed, totals.sweep_again, totals.fair, totals.good);
  if (totals.processor_seconds > 0)
    std::snprintf(hours, sizeof hours, "; %.2f hours of processor time", totals.processor_seconds / 3600);
  std::string html =
      "<!DOCTYPE html>\n<html lang=\"en\"><meta charset=\"utf-8\"><meta name=\"viewport\" "
      "content=\"width=device-width\"><title>" +
      escaped(title) + "</title><style>" + kStyle + "</style>\n<h1>" + escaped(title) + "</h1><p>" + counts + hours +
      "</p>\n";
  for (const BuildOutcome* outcome : sorted) html += figure_of(*outcome);
  return html + "</html>\n";
}

}  // namespace ldp
