#include "device/capture/capture_store.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <thread>

#include "core/base/files.h"
#include "core/captures/json_fields.h"
#include "core/captures/json_text.h"
#include "core/geometry/degrees.h"
#include "device/capture/capture_tuning.h"
#include "device/capture/log.h"
#include "device/capture/sweep_name.h"
#include "drivers/interface/clocks.h"
#include "drivers/interface/errors.h"

namespace ldp {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

std::string name_from(int number) {
  char text[32];
  std::snprintf(text, sizeof text, "%s%06d", kSweepPrefix.data(), number);
  return text;
}

bool is_frame(const fs::path& file) { return file.extension() == ".jpg" && file.stem().string().starts_with("frame_"); }

std::string read_text(const fs::path& file) {
  const std::vector<uint8_t> bytes = read_file(file);
  return {bytes.begin(), bytes.end()};
}

// Links that loop and files that cannot be removed are left alone. `all`: every .tmp, else those that core/base/files.h
// names, which are hidden; the others in a folder of people's own are theirs.
void remove_temporaries(const fs::path& folder, bool all) {
  std::vector<fs::path> files;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const bool is_ours = all || entry.path().filename().string().starts_with('.');
    if (is_ours && entry.path().extension() == ".tmp" && entry.is_regular_file(error)) files.push_back(entry.path());
  }
  for (const fs::path& file : files) fs::remove(file, error);
}

// 0 where there is none. One that cannot be read (a bad block), or holds no number that a sweep can have, is no reason
// to refuse sweeps for ever, nor to give names that no start would know again: it is replaced.
int number_in(const fs::path& counter) {
  std::string why;
  try {
    if (!fs::exists(counter)) return 0;
    const long number = std::strtol(read_text(counter).c_str(), nullptr, 10);
    if (number >= 0 && number < kMostSweeps) return static_cast<int>(number);
    why = counter.string() + " holds no number of a sweep";
  } catch (const std::system_error& error) {
    why = error.what();
  }
  log_warning(why + ": sweeps are counted from those that are in the folder");
  return 0;
}

int count_frames(const fs::path& folder) {
  int frames = 0;
  for (const auto& entry : fs::directory_iterator(folder)) frames += is_frame(entry.path()) ? 1 : 0;
  return frames;
}

// Sizes as they are now; files that vanish meanwhile count nothing.
uint64_t bytes_in(const fs::path& folder) {
  uint64_t sum = 0;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const uintmax_t size = entry.file_size(error);
    sum += error ? 0 : size;
  }
  return sum;
}

std::string utc(int64_t utc_ns) {
  char buffer[32];
  return utc_text(utc_ns, buffer);
}

}  // namespace

std::string capture_json(const CaptureRecord& record) {
  Json json;
  json["version"] = 1;
  json["device"] = record.device;
  json["camera"] = record.camera;
  json["width"] = record.width;
  json["height"] = record.height;
  json["pixel_format"] = record.pixel_format;
  json["arm_length"] = record.arm_length_m;
  if (record.fov_rad) json["fov_degrees"] = *record.fov_rad * kDegreesPerRadian;
  json["exposure_locked"] = record.exposure_locked;
  json["begin_utc"] = utc(record.begin_utc_ns);
  json["clock_synchronized"] = record.clock_synchronized;
  json["begin_ns"] = record.begin_ns;
  if (record.end_ns != 0) json["end_ns"] = record.end_ns;
  json["complete"] = record.complete;
  if (!record.end_reason.empty()) json["end_reason"] = record.end_reason;
  json["frames"] = Json::array();
  for (const FrameRecord& frame : record.frames) {
    Json entry{{"file", frame.file}, {"time_ns", frame.time_ns}, {"sequence", frame.sequence}};
    if (frame.exposure_s) entry["exposure_s"] = *frame.exposure_s;
    if (frame.gain) entry["gain"] = *frame.gain;
    json["frames"].push_back(std::move(entry));
  }
  return json_text(json, 1) + "\n";
}

std::vector<fs::path> CaptureStore::prepare() const {
  std::error_code error;
  std::vector<fs::path> made;
  for (fs::path missing = fs::absolute(output_); !fs::exists(missing, error); missing = missing.parent_path())
    made.push_back(missing);
  fs::create_directories(output_, error);
  const std::string advice = "choose another folder to write to";
  if (error) throw AdvisedError("cannot make the folder " + output_.string(), error.value(), advice);
  if (::access(output_.c_str(), W_OK) != 0) throw AdvisedError("cannot write into " + output_.string(), errno, advice);
  if (!flush_folder(output_))
    log_warning("the file system of " + output_.string() +
                " cannot flush folders: a power cut may take back what was stored in the last seconds");
  return made;
}

void CaptureStore::give_up(const std::vector<fs::path>& made) const {
  std::error_code error;
  if (!made.empty()) fs::remove(lock_file(), error);
  for (const fs::path& folder : made) fs::remove(folder, error);  // none that holds anything
}

UniqueFd CaptureStore::lock() const {
  const fs::path file = lock_file();
  UniqueFd fd(::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644));
  if (!fd.is_open()) throw_errno("cannot open " + file.string());
  for (int attempt = 1; ::flock(fd.get(), LOCK_EX | LOCK_NB) != 0; ++attempt) {
    if (errno != EWOULDBLOCK && errno != EINTR) throw_errno("cannot lock " + file.string());
    if (attempt == kLockAttempts) {
      throw std::runtime_error("another ldpd works in " + output_.string() + ": stop it, or name another folder");
    }
    std::this_thread::sleep_for(kLockInterval);
  }
  return fd;
}

std::vector<CaptureState> CaptureStore::recover() const {
  clear_building();
  remove_temporaries(output_, false);
  std::vector<CaptureState> captures;
  for (const auto& entry : fs::directory_iterator(output_)) {
    const std::string name = entry.path().filename().string();
    std::error_code error;
    if (!number_of_sweep(name) || !entry.is_directory(error)) continue;
    try {
      remove_temporaries(entry.path(), true);
      const bool built = fs::exists(panorama_of(name), error);
      captures.push_back({name, count_frames(entry.path()), built, read_build_record(name)});
    } catch (const std::exception& problem) {
      log_warning(std::string(problem.what()) + ": " + name + " is left alone");
    }
  }
  std::sort(captures.begin(), captures.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
  return captures;
}

std::string CaptureStore::create_capture() const {
  const fs::path counter = output_ / ".last_sweep";
  int last = number_in(counter);
  for (const auto& entry : fs::directory_iterator(output_)) {
    last = std::max(last, number_of_sweep(entry.path().stem().string()).value_or(0));
  }
  std::string name = name_from(last + 1);
  write_file(counter, std::to_string(last + 1) + "\n");
  fs::create_directory(folder_of(name));
  try {
    flush_folder(output_);
  } catch (const std::system_error&) {
    std::error_code ignored;
    fs::remove(folder_of(name), ignored);
    throw;
  }
  return name;
}

void CaptureStore::discard(const std::string& name) const {
  if (!number_of_sweep(name)) throw std::logic_error("not a capture: " + name);
  const fs::path gone = output_ / ".building" / name;
  fs::create_directory(gone.parent_path());
  fs::rename(folder_of(name), gone);
  flush_folder(output_);
  std::error_code later;  // clear_building tries again
  fs::remove_all(gone, later);
}

void CaptureStore::clear_building() const {
  fs::create_directory(output_ / ".building");
  std::vector<fs::path> left;
  for (const auto& entry : fs::directory_iterator(output_ / ".building")) left.push_back(entry.path());
  for (const fs::path& path : left) {
    std::error_code error;
    fs::remove_all(path, error);
    if (error) log_warning("cannot remove " + path.string() + ": " + error.message());  // builds replace it or fail
  }
}

void CaptureStore::publish_panorama(const std::string& name) const {
  const fs::path from = building_of(name), to = panorama_of(name);
  if (!fs::exists(from)) throw_errno("the build left no panorama: " + from.string(), ENOENT);
  move_file(from, to);
  std::error_code ignored;  // beside a panorama a record of builds says nothing
  fs::remove(folder_of(name) / "build.json", ignored);
}

void CaptureStore::write_build_record(const std::string& name, const BuildRecord& record) const {
  const Json json{{"interruptions", record.interruptions},
                  {"cancelled", record.cancelled},
                  {"failed", record.failed},
                  {"reason", record.reason}};
  write_file(folder_of(name) / "build.json", json_text(json, 1) + "\n");
}

BuildRecord CaptureStore::read_build_record(const std::string& name) const {
  const fs::path file = folder_of(name) / "build.json";
  if (!fs::exists(file)) return {};
  const Json json = Json::parse(read_text(file), nullptr, false);
  if (!json.is_object()) return {};
  BuildRecord record;
  record.interruptions = static_cast<int>(integer_field(json, "interruptions").value_or(0));
  record.cancelled = flag_field(json, "cancelled").value_or(false);
  record.failed = flag_field(json, "failed").value_or(false);
  record.reason = text_field(json, "reason").value_or("");
  return record;
}

void CaptureStore::forget_build_record(const std::string& name) const { fs::remove(folder_of(name) / "build.json"); }

int CaptureStore::sweeps_left(uint64_t reserve_bytes) const {
  struct statvfs disk {};
  if (::statvfs(output_.c_str(), &disk) != 0) throw_errno("cannot ask for the free space of " + output_.string());
  const uint64_t free_bytes = uint64_t{disk.f_bavail} * uint64_t{disk.f_frsize};
  const uint64_t usable = free_bytes > reserve_bytes ? free_bytes - reserve_bytes : 0;
  return static_cast<int>(std::min<uint64_t>(usable / usual_sweep_bytes(), 1'000'000));
}

// The largest of the last sweeps and a bit, so that a promise of one more is kept. Of those with their panorama: one
// that is being taken is not as large yet as it will be.
uint64_t CaptureStore::usual_sweep_bytes() const {
  std::vector<std::pair<std::string, uint64_t>> built;  // with their panoramas' sizes
  for (const auto& entry : fs::directory_iterator(output_)) {
    const std::string name = entry.path().filename().string();
    std::error_code error;
    const uintmax_t panorama = number_of_sweep(name) ? fs::file_size(panorama_of(name), error) : 0;
    if (panorama > 0 && !error) built.emplace_back(name, panorama);
  }
  std::sort(built.rbegin(), built.rend());
  uint64_t largest = 0;
  for (size_t i = 0; i < std::min(built.size(), kSweepsToGoBy); ++i)
    largest = std::max(largest, bytes_in(folder_of(built[i].first)) + built[i].second);
  return largest > (uint64_t{1} << 20) ? largest + largest / 4 : kFirstGuess_bytes;
}

}  // namespace ldp
