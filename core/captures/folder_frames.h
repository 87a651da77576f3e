// A capture folder as a source of frames, and what its capture.json says about it.
//
// Takes a folder of .jpg, .jpeg or .png photos of any names (upper or lower case), in name order with numbers by value;
// when the folder itself holds none, its subfolder `frames`; or photos one by one, in the order given. Photos larger
// than `max_pixels` are scaled down, so that memory is bounded by that and not by the camera. More than half of the
// photos are of one size, give or take the few pixels that a program trims (whose borders are cut off), and their
// frames of one working size; the few others are scaled down by as much. Photos of several sizes of which none is that
// common, no photo at all, or an unreadable one are refused, naming the file; once one is found damaged all are
// decoded, and those damaged named together. Nothing is decoded before it is asked for.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/geometry.h"
#include "core/photos/frame_source.h"
#include "core/photos/images.h"

namespace ldp {

struct FolderFramesOptions {
  int64_t max_pixels = 2'100'000;  // 1920x1080 passes as it is
  int orientation = 1;  // as EXIF numbers them, of what the photos' own leave: a camera that was mounted on its side
  bool trimmed = true;  // photos whose sizes differ by a few pixels may be of one camera
};

struct PhotoFile {
  std::filesystem::path path;
  std::string called;  // in errors
};

// Which part of a photo its frame is, in the photo's pixels, upright.
struct Framing {
  ImageSize stored, part;
  int left = 0, top = 0;
};

class FolderFrames : public FrameSource {
 public:
  // Throws std::runtime_error naming the folder or file and what to do.
  explicit FolderFrames(const std::filesystem::path& folder, const FolderFramesOptions& options = {});
  // Of these files, at least one, of unlike names; errors that concern them all name them `shown`, those of one what it
  // is called.
  FolderFrames(std::vector<PhotoFile> files, const std::string& shown, const FolderFramesOptions& options);

  int size() const override { return static_cast<int>(files_.size()); }
  std::string name(int index) const override;
  RgbImage load(int index) const override;
  std::optional<double> focal_hint(int index) const override;

  const std::vector<PhotoFile>& files() const { return files_; }
  ImageSize stored_size() const { return common_; }    // what most files have, upright
  ImageSize working_size() const { return working_; }  // of their frames as loaded
  Framing framing(int index) const;

  // The same cameras for frames; those that no photo is named after whose frame has the working size are left out.
  // Throws std::runtime_error when a camera's image has another shape than the photos.
  std::vector<Camera> fit(const std::vector<Camera>& cameras) const;

 private:
  Photo read(int index) const;
  bool is_like_most(ImageSize stored) const;
  ImageSize scaled(ImageSize part) const;

  std::vector<PhotoFile> files_;
  std::string shown_;
  FolderFramesOptions options_;
  std::vector<ImageSize> stored_;  // by file, upright
  ImageSize typical_, common_, working_;
};

// Those FolderFrames takes of a folder, at least one. Only lists: what is in them is not looked at. Throws
// std::runtime_error naming the folder and what to do.
std::vector<PhotoFile> photos_of_capture(const std::filesystem::path& folder);

// Photos of a folder in order. Empty when there is none.
std::vector<std::filesystem::path> list_photos(const std::filesystem::path& folder);

// "b" after "a", "frame_10" after "frame_9".
bool precedes_naturally(const std::string& a, const std::string& b);

// What a build wants to know from capture.json. All absent when there is no such file.
struct CaptureNotes {
  std::optional<double> arm_length;  // metres
  std::optional<double> fov_rad;     // horizontal, of photos as they are stored; within field_of_view.h
  std::string device, captured_utc;
};
// Errors name the folder `shown`, where it is not empty.
CaptureNotes read_capture_notes(const std::filesystem::path& folder, const std::string& shown = {});

}  // namespace ldp
