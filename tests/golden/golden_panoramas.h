// The golden files: their names, their panoramas and how they are encoded; and the checksums of decoded planes as
// tests/ldp_reader.py prints them.
#pragma once

#include <cstdio>
#include <string>
#include <vector>

#include "core/panorama/even_exposure.h"
#include "core/panorama/file/crc32c.h"
#include "core/panorama/file/ldp_file.h"
#include "tests/golden/synthetic_panorama.h"

namespace ldp {

struct Golden {
  const char* name;
  SyntheticOptions panorama;
  LdpEncodeOptions encode;
  bool still_written = true;  // does the encoder write it the same way today? Readers read it for ever
};

inline std::vector<Golden> golden_files() {
  return {{"uniform_lossless", {200, 90, 0, 3, false, Rays::pushbroom, false}, {101, LdpCodec::none}},
          {"blocks_alpha_wraps",
           {600, 60, 12, 4, true, Rays::central, true},
           {85, LdpCodec::webp},
           false},  // packed where few tiles are empty
          {"whole_strips", {600, 60, 12, 4, true, Rays::central, true}, {85, LdpCodec::webp}},
          {"jpeg_one_layer", {97, 53, 8, 1, false, Rays::pushbroom, false}, {95, LdpCodec::none}},
          {"gathered_jpeg", {230, 70, 16, 3, false, Rays::pushbroom, false}, {95, LdpCodec::jpeg}},
          {"gathered_lossless", {150, 60, 0, 3, false, Rays::central, false}, {101, LdpCodec::none}},
          {"local_exposure", {190, 60, 16, 2, false, Rays::pushbroom, true, true}, {101, LdpCodec::none}},
          {"tiny", {5, 3, 0, 2, false, Rays::pushbroom, false}, {90, LdpCodec::none}}};
}

inline Samples<uint8_t> colour_bytes(const Layer& layer) {
  Samples<uint8_t> bytes;
  for (const Rgb c : layer.colour.samples) bytes.insert(bytes.end(), {c.r, c.g, c.b});
  return bytes;
}

inline std::string plane_checksums(const LayeredPanorama& panorama) {
  std::string text;
  LayeredPanorama even;
  if (!panorama.exposure.empty()) {
    even = panorama;
    even_out(even);
  }
  for (size_t l = 0; l < panorama.layers.size(); ++l) {
    const Layer& layer = panorama.layers[l];
    Samples<uint8_t> disparity, alpha;
    for (const uint16_t d : decode_depth(layer.depth, layer.coverage).samples) {
      disparity.push_back(static_cast<uint8_t>(d & 255));
      disparity.push_back(static_cast<uint8_t>(d >> 8));
    }
    for (size_t i = 0; i < layer.coverage.samples.size(); ++i) {
      alpha.push_back(!layer.coverage.samples[i] ? 0 : layer.alpha.empty() ? 255 : layer.alpha.samples[i]);
    }
    const auto print = [&](const char* name, const Samples<uint8_t>& bytes) {
      char line[64];
      std::snprintf(line, sizeof line, "layer %d %s %08x\n", static_cast<int>(l) + 1, name,
                    static_cast<unsigned>(file::crc32c(bytes)));
      text += line;
    };
    print("disparity", disparity);
    print("coverage", layer.coverage.samples);
    print("alpha", alpha);
    print("colour", colour_bytes(layer));
    if (!even.layers.empty()) print("even", colour_bytes(even.layers[l]));
  }
  return text;
}

}  // namespace ldp
