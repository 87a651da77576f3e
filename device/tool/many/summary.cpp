#include "device/tool/many/build_outcomes.h"

#include <algorithm>
#include <cstdio>
#include <map>
#include <span>

#include "core/base/files.h"
#include "core/base/markup_text.h"
#include "core/panorama/file/ldp_file.h"
#include "core/verdict/sweep_quality.h"
#include "core/verdict/words.h"
#include "device/tool/own_output.h"
#include "device/tool/panorama_input.h"
#include "device/tool/session.h"

namespace ldp {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char *kFailed = "failed", *kUnknown = "unknown";

template <typename T>
std::optional<T> field(const Json& json, const char* path) {
  const Json::json_pointer at(path);
  if (!json.contains(at) || !json.at(at).is_number()) return std::nullopt;
  return json.at(at).get<T>();
}

std::string text_at(const Json& json, const char* path) {
  const Json::json_pointer at(path);
  return json.contains(at) && json.at(at).is_string() ? json.at(at).get<std::string>() : std::string();
}

// Where there is a quality, what a file holds of it is what its report says.
void take_quality(const std::optional<SweepQuality>& quality, BuildOutcome& outcome) {
  if (!quality) return;
  outcome.verdict = name_of(quality->grade);
  outcome.expected_view_psnr_db = quality->expected_view_psnr_db;
  outcome.reasons = reasons_of(*quality);
}

void read_panorama_file(const fs::path& file, BuildOutcome& outcome) {
  const MappedFile mapped(file);
  try {
    const LdpDescription description = describe_ldp(mapped.bytes());
    take_quality(quality_from(description.panorama.quality), outcome);
    outcome.file_bytes = description.file_bytes;
    outcome.posed = static_cast<int>(description.panorama.cameras.size());
    outcome.thumbnail = description.thumbnail;
  } catch (const LdpError& error) {
    outcome.verdict = kFailed;
    outcome.reasons = refusal_of(mapped.bytes(), std::string("the file is damaged: ") + error.what());
  }
}

// A failure is newer than a panorama that is there all the same.
void take_report(const Json& report, BuildOutcome& outcome) {
  outcome.processor_seconds = field<double>(report, "/processor_seconds/whole");
  outcome.peak_memory_bytes = field<uint64_t>(report, "/peak_memory_bytes");
  if (report.contains(Json::json_pointer("/poses/frames")))
    outcome.photos = static_cast<int>(report["poses"]["frames"].size());
  if (!report.contains("failure")) return;
  outcome.verdict = kFailed;
  outcome.reasons = text_at(report, "/failure/text");
  outcome.exit_status = field<int>(report, "/failure/status");
}

std::optional<Json> report_in(const fs::path& file) {
  const MappedFile mapped(file);
  Json json = Json::parse(mapped.bytes().begin(), mapped.bytes().end(), nullptr, false);
  if (!is_report(json)) return std::nullopt;
  return json;
}

size_t& count_of(const std::string& verdict, Totals& totals) {
  if (verdict == name_of(Grade::good)) return totals.good;
  if (verdict == name_of(Grade::fair)) return totals.fair;
  if (verdict == name_of(Grade::sweep_again)) return totals.sweep_again;
  return verdict == kFailed ? totals.failed : totals.unknown;
}

std::string words_of(const std::string& verdict) {
  return verdict == name_of(Grade::sweep_again) ? text_of(Grade::sweep_again) : verdict;
}

template <typename T>
void put(Json& json, const char* name, const std::optional<T>& value) {
  if (value) json[name] = *value;
}

}  // namespace

std::vector<BuildOutcome> outcomes_in(const fs::path& folder) {
  if (folder.empty()) throw BadInput("the name of a folder is empty: give the folder of the builds");
  if (!fs::is_directory(folder)) throw BadInput(folder.string() + ": there is no such folder: check the name");
  std::map<std::string, std::pair<fs::path, fs::path>> found;  // panorama and report, by name
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    const std::string ending = entry.path().extension().string();
    const std::string name = fs::relative(entry.path(), folder).replace_extension().string();
    if (ending == ".ldp") found[name].first = entry.path();
    if (ending == ".json") found[name].second = entry.path();
  }
  std::vector<BuildOutcome> outcomes;
  for (const auto& [name, files] : found) {
    BuildOutcome outcome;
    outcome.name = name;
    outcome.verdict = kUnknown;
    const std::optional<Json> report = files.second.empty() ? std::nullopt : report_in(files.second);
    if (files.first.empty() && !report) continue;
    if (!files.first.empty()) read_panorama_file(files.first, outcome);
    if (report) take_report(*report, outcome);
    outcomes.push_back(std::move(outcome));
  }
  return outcomes;
}

Totals totals_of(const std::vector<BuildOutcome>& outcomes) {
  Totals totals;
  for (const BuildOutcome& outcome : outcomes) {
    ++count_of(outcome.verdict, totals);
    totals.processor_seconds += outcome.processor_seconds.value_or(0);
    totals.file_bytes += outcome.file_bytes.value_or(0);
    totals.peak_memory_bytes = std::max(totals.peak_memory_bytes, outcome.peak_memory_bytes.value_or(0));
  }
  return totals;
}

Json summary_json(const std::vector<BuildOutcome>& outcomes) {
  const Totals totals = totals_of(outcomes);
  Json json{{"builds", outcomes.size()},
            {"good", totals.good},
            {"fair", totals.fair},
            {"sweep_again", totals.sweep_again},
            {"failed", totals.failed},
            {"unknown", totals.unknown},
            {"processor_seconds", totals.processor_seconds},
            {"file_bytes", totals.file_bytes},
            {"peak_memory_bytes", totals.peak_memory_bytes},
            {"outcomes", Json::array()}};
  for (const BuildOutcome& outcome : outcomes) {
    Json entry{{"name", outcome.name}, {"verdict", outcome.verdict}, {"reasons", outcome.reasons}};
    put(entry, "expected_view_psnr_db", outcome.expected_view_psnr_db);
    put(entry, "processor_seconds", outcome.processor_seconds);
    put(entry, "peak_memory_bytes", outcome.peak_memory_bytes);
    put(entry, "file_bytes", outcome.file_bytes);
    put(entry, "photos", outcome.photos);
    put(entry, "posed", outcome.posed);
    put(entry, "exit_status", outcome.exit_status);
    json["outcomes"].push_back(std::move(entry));
  }
  return json;
}

std::string summary_table(const std::vector<BuildOutcome>& outcomes) {
  const auto cell = [](const char* format, const std::optional<double>& value) {
    char text[32] = "-";
    if (value) std::snprintf(text, sizeof text, format, *value);
    return std::string(text);
  };
  std::string table;
  char row[160];
  std::snprintf(row, sizeof row, "%-28s %-12s %8s %8s %8s %8s  %s\n", "build", "verdict", "dB", "CPU s", "MB", "KB",
                "reasons");
  table += row;
  for (const BuildOutcome& outcome : outcomes) {
    std::optional<double> megabytes, kilobytes;
    if (outcome.peak_memory_bytes) megabytes = 1e-6 * static_cast<double>(*outcome.peak_memory_bytes);
    if (outcome.file_bytes) kilobytes = 1e-3 * static_cast<double>(*outcome.file_bytes);
    std::snprintf(row, sizeof row, "%-28.60s %-12s %8s %8s %8s %8s  ", printable(outcome.name).c_str(),
                  words_of(outcome.verdict).c_str(), cell("%.1f", outcome.expected_view_psnr_db).c_str(),
                  cell("%.1f", outcome.processor_seconds).c_str(), cell("%.0f", megabytes).c_str(),
                  cell("%.0f", kilobytes).c_str());
    table += row + printable(outcome.reasons) + "\n";
  }
  const Totals totals = totals_of(outcomes);
  std::snprintf(row, sizeof row, "%zu %s: %zu good, %zu fair, %zu sweep again, %zu failed, %zu unknown\n",
                outcomes.size(), outcomes.size() == 1 ? "build" : "builds", totals.good, totals.fair,
                totals.sweep_again, totals.failed, totals.unknown);
  table += row;
  std::snprintf(row, sizeof row, "%.1f MB of files", 1e-6 * static_cast<double>(totals.file_bytes));
  table += row;
  if (totals.processor_seconds > 0) {  // nobody measured it where there are no reports
    std::snprintf(row, sizeof row, ", %.2f hours of processor time, %.0f MB of memory at the peak",
                  totals.processor_seconds / 3600, 1e-6 * static_cast<double>(totals.peak_memory_bytes));
    table += row;
  }
  return table + "\n";
}

}  // namespace ldp
