// Pictures of what the stages made, for looking at: written only when a folder was named.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/base/plane.h"
#include "core/base/source_map.h"
#include "core/geometry/disparity.h"
#include "core/geometry/visibility_map.h"
#include "core/panorama/panorama.h"

namespace ldp {

class DebugPictures {
 public:
  explicit DebugPictures(const std::string& directory) : directory_(directory) {}
  bool wanted() const { return !directory_.empty(); }
  void labels(const std::string& name, const Plane<uint8_t>& labels,
              int largest) const;                                                  // grey; above `largest`: black
  void disparity(const std::string& name, const DisparityMap& disparity) const;    // absent: dark blue
  void sources(const std::string& name, const SourceMap& sources) const;           // one hue a frame, absent: black
  void agreement(const std::string& name, const Plane<uint8_t>& agreement) const;  // a colour a class; agrees: white
  void colour(const std::string& name, const RgbImage& colour) const;
  void visibility(const std::string& name, const std::vector<VisibilityMap>& maps) const;  // NAME camera 000 ...

 private:
  void write(const std::string& name, const std::vector<uint8_t>& png) const;
  std::filesystem::path directory_;
};

}  // namespace ldp
