// The small chunks (FORMAT.md, "HEAD", "LAYR", "cams", "qual", "meta", "expo") to and from bytes. Reading checks every
// bound. They are written in encode.cpp and found in reader.cpp; CONTRIBUTING.md lists all that a new one takes.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "core/panorama/file/bytes.h"
#include "core/panorama/file/ldp_file.h"
#include "core/panorama/panorama.h"

namespace ldp::file {

struct Head {
  PanoramaGrid grid;
  ViewingLimits limits;
  int layers = 0;
};

struct LayerRecord {
  LdpLayerSummary summary;
  BlockRange range;  // of the whole layer when block_px is 0
};

std::vector<uint8_t> write_head(const Head& head);
Head read_head(ByteReader reader, const LdpReadLimits& limits);

std::vector<uint8_t> write_layer_record(const LayerRecord& record);
LayerRecord read_layer_record(ByteReader reader, const PanoramaGrid& grid);

std::vector<uint8_t> write_cameras(const std::vector<Camera>& cameras);
std::vector<Camera> read_cameras(ByteReader reader);

std::vector<uint8_t> write_quality(const std::map<std::string, double>& quality);
std::map<std::string, double> read_quality(ByteReader reader);

std::vector<uint8_t> write_metadata(const std::map<std::string, std::string>& metadata);
std::map<std::string, std::string> read_metadata(ByteReader reader);

std::vector<uint8_t> write_exposure(const DisplayExposure& exposure);
DisplayExposure read_exposure(ByteReader reader, const PanoramaGrid& grid);

// Refuses more pixels in all layers together than a file of so many bytes may declare.
void check_work(const Head& head, uint64_t file_bytes, const Place& place);

// Number of strips of a layer; the last may be narrower.
int strip_count(const PanoramaGrid& grid, int strip_px);

}  // namespace ldp::file
