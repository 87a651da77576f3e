// Captures with given cameras, up to the sweep.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/geometry.h"
#include "core/photos/frame_source.h"
#include "core/photos/upright_frame.h"

namespace ldp {

// The photos that cameras name, in a folder.
class CaptureFrames final : public FrameSource {
 public:
  CaptureFrames(std::filesystem::path folder, const std::vector<Camera>& cameras);
  int size() const override { return static_cast<int>(names_.size()); }
  std::string name(int index) const override { return names_[static_cast<size_t>(index)]; }
  RgbImage load(int index) const override;
  std::optional<double> focal_hint(int) const override { return {}; }

 private:
  std::filesystem::path folder_;
  std::vector<std::string> names_;
};

struct PreparedCapture {
  PanoramaGrid grid;
  std::vector<UprightFrame> upright;
};

// A folder with transforms.json and its photos, or `frames` with them.
PreparedCapture prepare_capture(const std::string& folder);

}  // namespace ldp
