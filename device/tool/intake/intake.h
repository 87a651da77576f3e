// What people bring to a build, as photos: a folder of them, photos one by one, @LIST (a text file of their names), a
// .zip archive, a film; HEIC and raw photos among them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/job.h"
#include "core/captures/folder_frames.h"

namespace ldp {

class UnpackedFolder;

struct IntakeOptions {
  std::filesystem::path scratch;   // where what is unpacked may lie meanwhile; empty = the system's temporary files
  int64_t max_pixels = 2'100'000;  // of a frame of a film
  std::optional<double> fov_rad;   // horizontal
};

class Intake {
 public:
  // Throws BadInput naming what cannot be read, and what to install.
  Intake(const std::vector<std::string>& words, const IntakeOptions& options, const Job& job);
  Intake(Intake&&) noexcept;
  Intake& operator=(Intake&&) noexcept;
  ~Intake();  // what was unpacked is gone

  // In order: of a list its own, else by name, with numbers by value. Empty when the folder holds none. What was
  // unpacked or converted is called by what it came in.
  const std::vector<PhotoFile>& photos() const { return photos_; }
  // Files as they were given, what photos were unpacked or converted from, and what belongs to them; may be absent.
  const std::vector<std::filesystem::path>& inputs() const { return inputs_; }
  const std::filesystem::path& folder() const { return folder_; }  // that a capture.json would be in; empty = none
  const std::string& archive() const { return archive_; }          // or film that `folder` was unpacked from; or empty

 private:
  std::vector<PhotoFile> as_called(const std::vector<std::filesystem::path>& files) const;
  void take_folder(const std::filesystem::path& folder, const Job& job);
  void take_photos(std::vector<std::filesystem::path> photos, const Job& job);
  void take_file(const std::filesystem::path& file, const IntakeOptions& options, const Job& job);

  std::unique_ptr<UnpackedFolder> unpacked_, converted_;
  std::filesystem::path scratch_, folder_;
  std::string archive_;
  std::vector<PhotoFile> photos_;
  std::vector<std::filesystem::path> inputs_;
};

}  // namespace ldp
