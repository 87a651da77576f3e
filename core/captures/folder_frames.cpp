#include "core/captures/folder_frames.h"

#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>

#include "core/base/files.h"
#include "core/captures/field_of_view.h"
#include "core/captures/json_fields.h"
#include "core/captures/transforms.h"
#include "core/photos/resize.h"

namespace ldp {
namespace {

namespace fs = std::filesystem;

// Photos whose sides differ by less than this share of them are of one camera: 4000 and 4032 pixels are of two.
constexpr double kTrimmedShare = 0.006;
constexpr int64_t kEnoughPixels = 4'000'000;  // that any photo is decoded to, where no more are asked for

bool is_digit(char c) { return c >= '0' && c <= '9'; }

fs::directory_iterator entries_of(const fs::path& folder) {
  std::error_code error;
  fs::directory_iterator entries(folder, error);
  if (error)
    throw std::runtime_error(folder.string() + ": cannot be read (" + error.message() + "): check its permissions");
  return entries;
}

// In lower case, with its dot.
std::string ending_of(const fs::path& file) {
  std::string ending = file.extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return ending;
}

// What to do where a folder has no photos but something that can become some; empty where it has nothing of the kind.
std::string what_else(const fs::path& folder) {
  std::map<std::string, int> pictures;
  fs::path film;
  for (const auto& entry : entries_of(folder)) {
    const std::string ending = ending_of(entry.path());
    if (entry.path().filename().string().starts_with('.')) continue;
    for (const char* kind : {".webp", ".tif", ".tiff", ".gif", ".bmp"})
      if (ending == kind) ++pictures[entry.path().extension().string()];
    for (const char* kind : {".mp4", ".mov", ".m4v", ".avi", ".mkv", ".webm", ".3gp", ".zip"})
      if (ending == kind) film = entry.path();
  }
  std::string list;
  for (const auto& [ending, count] : pictures)
    list += (list.empty() ? "" : ", ") + std::to_string(count) + " " + ending;
  if (!pictures.empty()) {
    const auto common =
        std::max_element(pictures.begin(), pictures.end(), [](auto& a, auto& b) { return a.second < b.second; });
    return "no .jpg or .png photos in it but " + list +
           ": convert them in there with: mogrify -format jpg -quality 95 '*" + common->first + "'";
  }
  if (film.empty()) return {};
  return "no .jpg or .png photos in it but " + film.filename().string() + ": give that itself, " + film.string();
}

bool is_photo(const fs::directory_entry& entry) {
  const std::string ending = ending_of(entry.path());
  const bool hidden = entry.path().filename().string().starts_with('.');
  std::error_code unknown;
  return !hidden && (ending == ".jpg" || ending == ".jpeg" || ending == ".png") && entry.is_regular_file(unknown);
}

// Names of the folders in a folder that hold photos, in order.
std::vector<std::string> folders_of_photos(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : entries_of(folder)) {
    const std::string name = entry.path().filename().string();
    std::error_code unreadable;
    if (name.starts_with('.') || !entry.is_directory(unreadable)) continue;
    for (fs::directory_iterator inside(entry.path(), unreadable), end; !unreadable && inside != end;
         inside.increment(unreadable)) {
      if (!is_photo(*inside)) continue;
      names.push_back(name);
      break;
    }
  }
  std::sort(names.begin(), names.end(), precedes_naturally);
  return names;
}

std::string text_of(ImageSize size) { return std::to_string(size.width) + "x" + std::to_string(size.height); }

double pixels_of(ImageSize size) { return static_cast<double>(size.width) * size.height; }

std::string name_of(const PhotoFile& file) { return file.path.filename().string(); }

std::vector<ImageSize> sizes_of(const std::vector<PhotoFile>& files, int orientation) {
  for (const PhotoFile& file : files)
    if (::access(file.path.c_str(), R_OK) != 0)
      throw std::runtime_error(file.called + ": cannot be read (" + std::strerror(errno) + "): check its permissions");
  std::vector<ImageSize> sizes;
  for (const PhotoFile& file : files) sizes.push_back(upright(read_image_size(file.path, file.called), orientation));
  return sizes;
}

// Programs that turn photos or take their lenses' bending out trim each a little differently.
bool of_one_camera(ImageSize a, ImageSize b, bool trimmed) {
  const auto near = [](int one, int other) { return std::abs(one - other) < kTrimmedShare * std::max(one, other); };
  return a == b || (trimmed && near(a.width, b.width) && near(a.height, b.height));
}

// That of more than half of the photos, or alike: a few others among them were turned or cropped.
ImageSize typical_size(const std::vector<PhotoFile>& files, const std::vector<ImageSize>& sizes, bool trimmed,
                       const std::string& shown) {
  const auto of_one = [&](ImageSize a, ImageSize b) { return of_one_camera(a, b, trimmed); };
  for (const ImageSize& size : sizes) {
    const auto same = std::count_if(sizes.begin(), sizes.end(), [&](ImageSize other) { return of_one(size, other); });
    if (2 * same > static_cast<std::ptrdiff_t>(sizes.size())) return size;
  }
  const auto other =
      std::find_if(sizes.begin(), sizes.end(), [&](ImageSize size) { return !of_one(size, sizes.front()); });
  throw std::runtime_error(shown + ": photos of several sizes, " + name_of(files.front()) + " is " +
                           text_of(sizes.front()) + " and " +
                           name_of(files[static_cast<size_t>(other - sizes.begin())]) + " " + text_of(*other) +
                           ": keep only the photos of one sweep");
}

// Of a photo that may have been made smaller when it was decoded.
RgbImage cut(const RgbImage& image, const Framing& framing) {
  const auto at = [](int stored_px, int have, int stored) {
    return static_cast<int>(int64_t{stored_px} * have / stored);
  };
  const int left = at(framing.left, image.width, framing.stored.width),
            top = at(framing.top, image.height, framing.stored.height);
  RgbImage part(at(framing.part.width, image.width, framing.stored.width),
                at(framing.part.height, image.height, framing.stored.height));
  for (int y = 0; y < part.height; ++y) std::copy_n(image.row(top + y) + left, part.width, part.row(y));
  return part;
}

std::string list_of(const std::vector<std::string>& names) {
  constexpr size_t kMostNames = 10;
  std::string list = names.front();
  for (size_t i = 1; i < std::min(names.size(), kMostNames); ++i)
    list += (i + 1 == names.size() ? " and " : ", ") + names[i];
  return names.size() > kMostNames ? list + " and " + std::to_string(names.size() - kMostNames) + " more" : list;
}

// Who copies one again, or leaves it out, would meet the next in another run. `met` is what was said of the first.
[[noreturn]] void refuse_all_damaged(const std::vector<PhotoFile>& files, const std::string& shown,
                                     const DamagedImage& met) {
  std::vector<std::string> damaged;
  for (const PhotoFile& file : files) {
    try {
      read_photo(file.path, kEnoughPixels, file.called);
    } catch (const DamagedImage&) {
      damaged.push_back(name_of(file));
    } catch (const std::runtime_error&) {  // of another kind: told when those are mended
    }
  }
  if (damaged.size() < 2) throw DamagedImage(met);
  throw DamagedImage(shown + ": " + std::to_string(damaged.size()) + " of " + std::to_string(files.size()) +
                     " photos are damaged (" + list_of(damaged) + "): copy them again, or leave them out");
}

Camera resized(Camera camera, ImageSize size) {
  Intrinsics& in = camera.intrinsics;
  const double x = static_cast<double>(size.width) / in.width, y = static_cast<double>(size.height) / in.height;
  // Rounding to whole pixels changes the shape by less than one of them.
  if (std::abs(x / y - 1) > 1.5 / std::min({in.width, in.height, size.width, size.height})) {
    throw std::runtime_error("camera " + camera.name + ": its image is " + text_of({in.width, in.height}) +
                             ", the photos are " + text_of(size) + ": give cameras of uncropped photos");
  }
  in.fx *= x;
  in.cx *= x;
  in.fy *= y;
  in.cy *= y;
  in.width = size.width;
  in.height = size.height;
  return camera;
}

std::optional<double> positive(const nlohmann::json& json, const char* key) {
  const std::optional<double> value = number_field(json, key);
  return value && *value > 0 ? value : std::nullopt;
}

// A field of view that no camera of a sweep has is a mistake, not one that is unknown.
std::optional<double> field_of_view_rad(const nlohmann::json& json, const std::string& file) {
  const auto degrees = positive(json, "fov_degrees");
  if (!degrees) return std::nullopt;
  if (*degrees < kLeastFov_deg || *degrees > kMostFov_deg) {
    std::ostringstream words;
    words << file << ": fov_degrees is " << *degrees << ", expected " << kLeastFov_deg << " to " << kMostFov_deg
          << ": correct it, or remove it to do without";
    throw std::runtime_error(words.str());
  }
  return *degrees * std::numbers::pi / 180;
}

}  // namespace

bool precedes_naturally(const std::string& a, const std::string& b) {
  size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    if (!is_digit(a[i]) || !is_digit(b[j])) {
      if (a[i] != b[j]) return static_cast<unsigned char>(a[i]) < static_cast<unsigned char>(b[j]);
      ++i;
      ++j;
      continue;
    }
    const auto number = [](const std::string& text, size_t& at) {
      while (at < text.size() && text[at] == '0') ++at;
      const size_t begin = at;
      while (at < text.size() && is_digit(text[at])) ++at;
      return text.substr(begin, at - begin);
    };
    const std::string m = number(a, i), n = number(b, j);
    if (m != n) return m.size() != n.size() ? m.size() < n.size() : m < n;
  }
  const bool a_ended = i == a.size(), b_ended = j == b.size();
  return a_ended && b_ended ? a < b : a_ended;
}

std::vector<fs::path> list_photos(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : entries_of(folder)) {
    if (is_photo(entry)) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end(), [](const fs::path& a, const fs::path& b) {
    return precedes_naturally(a.filename().string(), b.filename().string());
  });
  return files;
}

std::vector<PhotoFile> photos_of_capture(const fs::path& folder) {
  std::error_code error;
  const fs::file_status status = fs::status(folder, error);
  if (status.type() == fs::file_type::not_found)
    throw std::runtime_error(folder.string() + ": there is no such folder: check the name");
  if (!fs::status_known(status))
    throw std::runtime_error(folder.string() + ": cannot be looked at (" + error.message() +
                             "): check its name and permissions");
  if (!fs::is_directory(status))
    throw std::runtime_error(folder.string() + ": is not a folder: give a folder of photos");
  std::vector<fs::path> files = list_photos(folder);
  const bool has_frames = fs::is_directory(folder / "frames", error);
  if (files.empty() && has_frames) files = list_photos(folder / "frames");
  if (!files.empty()) {
    std::vector<PhotoFile> photos;
    for (const fs::path& file : files) photos.push_back({file, file.string()});
    return photos;
  }
  const std::string other = what_else(has_frames ? folder / "frames" : folder);
  if (!other.empty()) throw std::runtime_error(folder.string() + ": " + other);
  const std::vector<std::string> inside = folders_of_photos(folder);
  std::string where = ": give a folder of photos";
  if (inside.size() == 1) where = " but in its folder " + inside[0] + ": give that";
  if (inside.size() > 1) where = " but in its folders " + list_of(inside) + ": give the one with the sweep's photos";
  throw std::runtime_error(folder.string() + ": no .jpg or .png photos in it" + where);
}

FolderFrames::FolderFrames(const fs::path& folder, const FolderFramesOptions& options)
    : FolderFrames(photos_of_capture(folder), folder.string(), options) {}

FolderFrames::FolderFrames(std::vector<PhotoFile> files, const std::string& shown, const FolderFramesOptions& options)
    : files_(std::move(files)), shown_(shown), options_(options) {
  if (options.max_pixels < 1024) throw std::logic_error("FolderFrames: max_pixels must be at least 1024");
  if (files_.empty()) throw std::logic_error("FolderFrames: no files");
  try {
    stored_ = sizes_of(files_, options.orientation);
  } catch (const DamagedImage& met) {
    refuse_all_damaged(files_, shown_, met);
  }
  typical_ = typical_size(files_, stored_, options.trimmed, shown_);
  common_ = typical_;
  for (const ImageSize& size : stored_)
    if (is_like_most(size)) common_ = {std::min(common_.width, size.width), std::min(common_.height, size.height)};
  working_ = scaled(common_);
}

std::string FolderFrames::name(int index) const { return name_of(files_.at(static_cast<size_t>(index))); }

bool FolderFrames::is_like_most(ImageSize stored) const { return of_one_camera(stored, typical_, options_.trimmed); }

// Scaled down by as much as the others: one cropped to the same shape is not to pass for one of them.
ImageSize FolderFrames::scaled(ImageSize part) const {
  const double pixels = std::max(pixels_of(part), pixels_of(common_));
  if (pixels <= static_cast<double>(options_.max_pixels)) return part;
  const double scale = std::sqrt(static_cast<double>(options_.max_pixels) / pixels);
  return {std::max(1, static_cast<int>(part.width * scale)), std::max(1, static_cast<int>(part.height * scale))};
}

// Of photos of one camera the middle that all have; all of the others.
Framing FolderFrames::framing(int index) const {
  const ImageSize stored = stored_.at(static_cast<size_t>(index));
  if (!is_like_most(stored)) return {stored, stored};
  return {stored, common_, (stored.width - common_.width) / 2, (stored.height - common_.height) / 2};
}

// Decoding at a whole fraction of the size saves memory; the rest of the way is averaged.
Photo FolderFrames::read(int index) const {
  const PhotoFile& file = files_.at(static_cast<size_t>(index));
  const ImageSize part = framing(index).part, frame = scaled(part);
  const int64_t enough = std::max<int64_t>(int64_t{4} * frame.width * frame.height, kEnoughPixels);
  try {
    return read_photo(file.path, frame == part ? kMaxImagePixels : enough, file.called);
  } catch (const DamagedImage& met) {
    refuse_all_damaged(files_, shown_, met);
  }
}

RgbImage FolderFrames::load(int index) const {
  Photo photo = read(index);
  const ImageSize found = upright(photo.full_size, options_.orientation);
  const Framing framed = framing(index);
  if (found != framed.stored) {
    throw std::runtime_error(files_[static_cast<size_t>(index)].called + ": is " + text_of(found) + " by now and was " +
                             text_of(framed.stored) + ": leave the photos alone while they are worked on");
  }
  RgbImage image = upright(std::move(photo.image), options_.orientation);
  if (framed.part != framed.stored) image = cut(image, framed);
  const ImageSize frame = scaled(framed.part);
  return frame == framed.part ? image : resize_by_area(image, frame.width, frame.height);
}

std::optional<double> FolderFrames::focal_hint(int index) const {
  return read_focal_hint(files_.at(static_cast<size_t>(index)).path);
}

std::vector<Camera> FolderFrames::fit(const std::vector<Camera>& cameras) const {
  std::vector<Camera> fitted;
  for (int i = 0; i < size(); ++i) {
    const Camera* camera = find_camera(cameras, name(i));
    const auto [stored, part, left, top] = framing(i);
    if (camera == nullptr || scaled(part) != working_) continue;
    Camera of_part = resized(*camera, stored);
    Intrinsics& in = of_part.intrinsics;
    in.cx -= left, in.cy -= top;
    in.width = part.width, in.height = part.height;
    fitted.push_back(resized(of_part, working_));
    fitted.back().name = name(i);
  }
  return fitted;
}

CaptureNotes read_capture_notes(const fs::path& folder, const std::string& shown) {
  CaptureNotes notes;
  const fs::path file = folder / "capture.json";
  if (!fs::exists(file)) return notes;
  if (!fs::is_regular_file(file))
    throw std::runtime_error(file.string() + ": is no regular file: remove it to do without");
  const std::vector<uint8_t> bytes = read_file(file);
  const auto json = nlohmann::json::parse(bytes, nullptr, false);
  const std::string name = shown.empty() ? file.string() : shown + ": capture.json";
  if (!json.is_object())
    throw std::runtime_error(name + ": is not a JSON object: repair it, or remove it to do without");
  notes.arm_length = positive(json, "arm_length");
  notes.fov_rad = field_of_view_rad(json, name);
  notes.device = text_field(json, "device").value_or("");
  notes.captured_utc = text_field(json, "begin_utc").value_or("");
  return notes;
}

}  // namespace ldp
