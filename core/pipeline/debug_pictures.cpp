#include "core/pipeline/debug_pictures.h"

#include <algorithm>
#include <array>
#include <cstdio>

#include "core/base/files.h"
#include "core/consistency/consistency.h"
#include "core/photos/images.h"

namespace ldp {
namespace {

constexpr Rgb kAbsent{20, 20, 70};

}  // namespace

void DebugPictures::labels(const std::string& name, const Plane<uint8_t>& labels, int largest) const {
  if (!wanted()) return;
  GreyImage grey(labels.width, labels.height);
  for (size_t i = 0; i < grey.samples.size(); ++i) {
    const int l = labels.samples[i];
    grey.samples[i] = l > largest ? uint8_t{0} : static_cast<uint8_t>(l * 255 / std::max(1, largest));
  }
  write(name, encode_png(grey));
}

void DebugPictures::disparity(const std::string& name, const DisparityMap& disparity) const {
  if (!wanted()) return;
  RgbImage image(disparity.width, disparity.height, kAbsent);
  for (size_t i = 0; i < image.samples.size(); ++i) {
    if (disparity.samples[i] == kNoDisparity) continue;
    const auto g = static_cast<uint8_t>(disparity.samples[i] * 255 / kDisparitySteps);
    image.samples[i] = {g, g, g};
  }
  write(name, encode_png(image));
}

void DebugPictures::sources(const std::string& name, const SourceMap& sources) const {
  if (!wanted()) return;
  RgbImage image(sources.width(), sources.height());
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const int s = sources.at(x, y);
      if (s != kNoSource)
        image.at(x, y) = {static_cast<uint8_t>(60 + s * 97 % 196), static_cast<uint8_t>(60 + s * 57 % 196),
                          static_cast<uint8_t>(60 + s * 151 % 196)};
    }
  write(name, encode_png(image));
}

void DebugPictures::agreement(const std::string& name, const Plane<uint8_t>& agreement) const {
  if (!wanted()) return;
  constexpr std::array<Rgb, kAgreements> kHues = {{{255, 255, 255},    // agrees
                                                   {0, 0, 0},          // hole
                                                   {190, 190, 190},    // exposure
                                                   {70, 110, 255},     // wrong_colour
                                                   {255, 30, 30},      // missing
                                                   {255, 170, 0},      // wrong_depth
                                                   {160, 60, 200},     // moved
                                                   {120, 200, 120}}};  // alone
  RgbImage image(agreement.width, agreement.height);
  for (size_t i = 0; i < image.samples.size(); ++i) image.samples[i] = kHues.at(agreement.samples[i]);
  write(name, encode_png(image));
}

void DebugPictures::colour(const std::string& name, const RgbImage& colour) const {
  if (wanted()) write(name, encode_png(colour));
}

void DebugPictures::visibility(const std::string& name, const std::vector<VisibilityMap>& maps) const {
  if (!wanted()) return;
  for (size_t i = 0; i < maps.size(); ++i) {
    char camera[32];
    std::snprintf(camera, sizeof camera, " camera %03zu", i);
    const Plane<uint16_t>& from = maps[i].inverse_z;
    RgbImage image(from.height, from.width, kAbsent);
    for (int column = 0; column < from.height; ++column)
      for (int row = 0; row < from.width; ++row) {
        if (from.at(row, column) == 0) continue;
        const auto g = static_cast<uint8_t>(std::min(255, from.at(row, column) / 64));
        image.at(column, row) = {g, g, g};
      }
    write(name + camera, encode_png(image));
  }
}

void DebugPictures::write(const std::string& name, const std::vector<uint8_t>& png) const {
  std::filesystem::create_directories(directory_);
  write_file(directory_ / (name + ".png"), png);
}

}  // namespace ldp
