#include "device/tool/intake/intake.h"

#include <algorithm>
#include <fstream>
#include <set>
#include <utility>

#include "core/captures/folder_frames.h"
#include "device/tool/intake/converted_photos.h"
#include "device/tool/intake/film_frames.h"
#include "device/tool/intake/intake_tuning.h"
#include "device/tool/intake/photo_kinds.h"
#include "device/tool/intake/unpacked_folder.h"
#include "device/tool/intake/zip_archive.h"
#include "device/tool/output.h"
#include "device/tool/session.h"

namespace ldp {
namespace {

namespace fs = std::filesystem;

bool is_converted(const fs::path& file) {
  const FileKind kind = kind_of_name(file);
  return kind == FileKind::heif || kind == FileKind::raw;
}

bool precedes(const fs::path& a, const fs::path& b) {
  return precedes_naturally(a.filename().string(), b.filename().string());
}

// Photos of a folder that have to be converted, in order.
std::vector<fs::path> list_converted(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const bool hidden = entry.path().filename().string().starts_with('.');
    if (!hidden && entry.is_regular_file() && is_converted(entry.path())) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end(), precedes);
  return files;
}

// A name a line, those that are not absolute from the list's own folder.
std::vector<fs::path> read_list(const fs::path& list) {
  check_input_file(list);
  if (static_cast<int64_t>(fs::file_size(list)) > kMaxList_bytes)
    throw BadInput(list.string() + ": is longer than a list of photos can be: give a text file of one name a line");
  std::ifstream in(list);
  std::vector<fs::path> photos;
  for (std::string line; std::getline(in, line);) {
    if (line.ends_with('\r')) line.pop_back();
    if (!line.empty()) photos.push_back(list.parent_path() / line);
  }
  if (photos.empty()) throw BadInput(list.string() + ": names no photo: write one name a line");
  return photos;
}

[[noreturn]] void refuse_panorama(const fs::path& file) {
  throw BadInput(file.string() +
                 ": is a finished panorama already, not photos of one: render views of it with ldp render, or see "
                 "what is in it with ldp info");
}

void check_photos(const std::vector<fs::path>& photos) {
  std::set<std::string> names;
  for (const fs::path& photo : photos) {
    check_input_file(photo);
    const FileKind kind = is_converted(photo) ? FileKind::photo : kind_of_content(photo);
    if (kind == FileKind::panorama) refuse_panorama(photo);
    if (kind != FileKind::photo)
      throw BadInput(photo.string() + ": is no photo: of several names each must be a photo");
    if (!names.insert(photo.filename().string()).second)
      throw BadInput(photo.string() + ": two photos are named " + photo.filename().string() + ": rename one");
  }
}

}  // namespace

Intake::Intake(Intake&&) noexcept = default;
Intake& Intake::operator=(Intake&&) noexcept = default;
Intake::~Intake() = default;

Intake::Intake(const std::vector<std::string>& words, const IntakeOptions& options, const Job& job)
    : scratch_(options.scratch) {
  remove_abandoned_folders(scratch_);
  const fs::path only = words.size() == 1 ? words.front() : std::string();
  if (only.empty()) {
    std::vector<fs::path> photos(words.begin(), words.end());
    std::stable_sort(photos.begin(), photos.end(), precedes);
    take_photos(std::move(photos), job);
  } else if (std::error_code unknown; fs::is_directory(only, unknown)) {
    take_folder(only, job);
    inputs_.push_back(only / "capture.json");
  } else if (words.front().starts_with('@') && !fs::exists(only, unknown)) {
    const fs::path list = words.front().substr(1);
    take_photos(read_list(list), job);
    inputs_.push_back(list);
  } else {
    take_file(only, options, job);
  }
}

void Intake::take_folder(const fs::path& folder, const Job& job) {
  folder_ = folder;
  for (const fs::path& place : {folder, folder / "frames"}) {
    if (!photos_.empty() || !fs::is_directory(place)) continue;
    inputs_ = list_photos(place);
    photos_ = as_called(inputs_);
    if (photos_.empty()) take_photos(list_converted(place), job);
  }
}

void Intake::take_photos(std::vector<fs::path> photos, const Job& job) {
  check_photos(photos);
  inputs_ = std::move(photos);
  photos_ = as_called(inputs_);
  const auto first =
      std::find_if(photos_.begin(), photos_.end(), [](const PhotoFile& p) { return is_converted(p.path); });
  if (first == photos_.end()) return;
  converted_ = std::make_unique<UnpackedFolder>(scratch_, first->called);
  photos_ = converted_photos(photos_, *converted_, job);
}

std::vector<PhotoFile> Intake::as_called(const std::vector<fs::path>& files) const {
  std::vector<PhotoFile> photos;
  for (const fs::path& file : files)
    photos.push_back({file, archive_.empty() ? file.string() : archive_ + ": " + file.filename().string()});
  return photos;
}

void Intake::take_file(const fs::path& file, const IntakeOptions& options, const Job& job) {
  std::error_code unknown;
  if (fs::status(file, unknown).type() == fs::file_type::not_found)
    throw BadInput(file.string() + ": there is no such folder, photo, archive or film: check the name");
  const FileKind kind = kind_of_content(file);
  if (kind == FileKind::panorama) refuse_panorama(file);
  if (kind == FileKind::photo || kind == FileKind::heif || kind == FileKind::raw) {
    photos_ = as_called({file});  // too few anyway
    return;
  }
  archive_ = file.string();
  unpacked_ = std::make_unique<UnpackedFolder>(scratch_, archive_);
  if (kind == FileKind::zip)
    unpack_photos(file, *unpacked_, job);
  else
    take_film_frames(file, *unpacked_, {options.max_pixels, options.fov_rad}, job);
  take_folder(unpacked_->path(), job);
  inputs_ = {file};
}

}  // namespace ldp
