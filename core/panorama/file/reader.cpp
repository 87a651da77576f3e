#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <utility>

#include "core/panorama/file/coders/alpha_coding.h"
#include "core/panorama/file/coders/colour_coding.h"
#include "core/panorama/file/coders/depth_coding.h"
#include "core/panorama/file/container.h"
#include "core/panorama/file/ldp_file.h"
#include "core/panorama/file/records.h"

namespace ldp::file {
namespace {

// Where the chunks of one strip are in the table.
struct StripChunks {
  std::optional<size_t> depth, alpha, colour;
};

struct LayerIndex {
  std::optional<size_t> record;
  BlockRange range;
  std::vector<StripChunks> strips;
};

struct FileIndex {
  std::optional<size_t> head, thumbnail, cameras, quality, metadata, exposure;
  std::vector<LayerIndex> layers;
};

void claim(std::optional<size_t>& slot, size_t i, const LdpChunk& chunk) {
  if (slot) place_of(chunk).refuse("it is there a second time");
  slot = i;
}

// The place of a chunk that belongs to the whole file or to a layer; null for chunks this version does not know.
std::optional<size_t>* slot_of(FileIndex& index, const LdpChunk& chunk) {
  const std::array<std::pair<const char*, std::optional<size_t>*>, 6> whole = {{{"HEAD", &index.head},
                                                                                {"thmb", &index.thumbnail},
                                                                                {"cams", &index.cameras},
                                                                                {"qual", &index.quality},
                                                                                {"meta", &index.metadata},
                                                                                {"expo", &index.exposure}}};
  for (const auto& [type, slot] : whole) {
    if (chunk.type != type) continue;
    if (chunk.layer >= 0 || chunk.strip >= 0) place_of(chunk).refuse("layer and strip", "none", "one");
    return slot;
  }
  return nullptr;
}

bool is_layer_type(const std::string& type) {
  return type == "LAYR" || type == "DPTH" || type == "ALPH" || type == "COLR";
}

LayerIndex& layer_of(FileIndex& index, const LdpChunk& chunk) {
  if (chunk.layer < 0 || static_cast<size_t>(chunk.layer) >= index.layers.size())
    place_of(chunk).refuse("layer", "1 to " + std::to_string(index.layers.size()), std::to_string(chunk.layer + 1));
  return index.layers[static_cast<size_t>(chunk.layer)];
}

std::optional<size_t>& strip_slot_of(LayerIndex& layer, const LdpChunk& chunk) {
  if (chunk.strip < 0 || static_cast<size_t>(chunk.strip) >= layer.strips.size())
    place_of(chunk).refuse("strip", "1 to " + std::to_string(layer.strips.size()), std::to_string(chunk.strip + 1));
  StripChunks& strip = layer.strips[static_cast<size_t>(chunk.strip)];
  return chunk.type == "DPTH" ? strip.depth : chunk.type == "ALPH" ? strip.alpha : strip.colour;
}

// A capital first letter: the file cannot be understood without it.
void refuse_if_needed(const LdpChunk& chunk) {
  if (chunk.type[0] >= 'A' && chunk.type[0] <= 'Z')
    place_of(chunk).refuse("needed to read the file, but unknown to this version");
}

[[noreturn]] void refuse_missing(const std::string& chunk) {
  throw LdpError("chunk " + chunk + ": expected one, found none");
}

template <typename T>
void paste_columns(const Plane<T>& part, int part_begin, int begin, int end, Plane<T>& whole, int whole_begin) {
  for (int y = 0; y < whole.height; ++y)
    std::copy(part.row(y) + begin - part_begin, part.row(y) + end - part_begin, whole.row(y) + begin - whole_begin);
}

int blocks(int pixels, int block_px) { return block_px == 0 ? 1 : (pixels + block_px - 1) / block_px; }

uint64_t count_present(const Plane<uint8_t>& coverage) {
  return static_cast<uint64_t>(std::count(coverage.samples.begin(), coverage.samples.end(), 1));
}

}  // namespace
}  // namespace ldp::file

namespace ldp {

using namespace file;

struct LdpReader::State {
  std::span<const uint8_t> bytes;
  LdpDescription description;
  FileIndex index;

  State(std::span<const uint8_t> file, const LdpReadLimits& limits) : bytes(file) {
    Container container = read_container(file);
    description.version = container.version;
    description.file_bytes = file.size();
    description.chunks = std::move(container.chunks);
    read_head_chunk(limits);
    read_layer_records();
    index_strips();
    read_extras();
  }

  const LdpChunk& chunk(size_t i) const { return description.chunks[i]; }
  std::span<const uint8_t> content(size_t i) const { return checked_bytes(bytes, chunk(i)); }
  ByteReader reader(size_t i) const { return {content(i), place_of(chunk(i))}; }

  void read_head_chunk(const LdpReadLimits& limits) {
    for (size_t i = 0; i < description.chunks.size(); ++i) {
      if (std::optional<size_t>* slot = slot_of(index, chunk(i)))
        claim(*slot, i, chunk(i));
      else if (!is_layer_type(chunk(i).type))
        refuse_if_needed(chunk(i));
    }
    if (!index.head) refuse_missing("HEAD");
    const Head head = read_head(reader(*index.head), limits);
    check_work(head, bytes.size(), place_of(chunk(*index.head)));
    description.panorama.grid = head.grid;
    description.panorama.limits = head.limits;
    index.layers.resize(static_cast<size_t>(head.layers));
  }

  void read_layer_records() {
    for (size_t i = 0; i < description.chunks.size(); ++i) {
      if (chunk(i).type != "LAYR") continue;
      if (chunk(i).strip >= 0) place_of(chunk(i)).refuse("strip", "none", std::to_string(chunk(i).strip + 1));
      claim(layer_of(index, chunk(i)).record, i, chunk(i));
    }
    for (size_t l = 0; l < index.layers.size(); ++l) {
      LayerIndex& layer = index.layers[l];
      if (!layer.record) refuse_missing("LAYR of layer " + std::to_string(l + 1));
      const LayerRecord record = read_layer_record(reader(*layer.record), description.panorama.grid);
      description.layers.push_back(record.summary);
      layer.range = record.range;
      layer.strips.resize(static_cast<size_t>(strip_count(description.panorama.grid, record.summary.strip_px)));
    }
  }

  void index_strips() {
    for (size_t i = 0; i < description.chunks.size(); ++i)
      if (is_layer_type(chunk(i).type) && chunk(i).type != "LAYR")
        claim(strip_slot_of(layer_of(index, chunk(i)), chunk(i)), i, chunk(i));
    for (size_t l = 0; l < index.layers.size(); ++l)
      for (size_t s = 0; s < index.layers[l].strips.size(); ++s) {
        const StripChunks& strip = index.layers[l].strips[s];
        const std::string where = " of layer " + std::to_string(l + 1) + ", strip " + std::to_string(s + 1);
        if (!strip.depth) refuse_missing("DPTH" + where);
        if (!strip.colour) refuse_missing("COLR" + where);
        if (description.layers[l].has_alpha && !strip.alpha) refuse_missing("ALPH" + where);
        if (!description.layers[l].has_alpha && strip.alpha)
          place_of(chunk(*strip.alpha)).refuse("the layer has no alpha");
      }
  }

  void read_extras() {
    if (index.cameras) description.panorama.cameras = read_cameras(reader(*index.cameras));
    if (index.quality) description.panorama.quality = read_quality(reader(*index.quality));
    if (index.metadata) description.panorama.metadata = read_metadata(reader(*index.metadata));
    if (index.exposure)
      description.panorama.exposure = read_exposure(reader(*index.exposure), description.panorama.grid);
    if (!index.thumbnail) return;
    const auto thumbnail = content(*index.thumbnail);
    description.thumbnail.assign(thumbnail.begin(), thumbnail.end());
  }

  struct Part {
    int begin = 0, end = 0;  // columns of the grid
    DepthStrip depth;
    Plane<uint8_t> alpha;
    RgbImage colour;
  };

  Part decode_strip(size_t layer, size_t strip, bool with_colour) const {
    const LdpLayerSummary& summary = description.layers[layer];
    const PanoramaGrid& grid = description.panorama.grid;
    Part part;
    part.begin = static_cast<int>(strip) * summary.strip_px;
    part.end = std::min(grid.width, part.begin + summary.strip_px);
    const int width = part.end - part.begin;
    DepthStrip& depth = part.depth;
    depth.block_px = summary.block_px;
    depth.tiles = {blocks(width, kTile), blocks(grid.height, kTile)};
    depth.coverage = {width, grid.height};
    depth.codes = {width, grid.height};
    depth.ranges = {blocks(width, summary.block_px), blocks(grid.height, summary.block_px), BlockRange{0, 0}};
    if (summary.block_px == 0) depth.ranges.samples[0] = index.layers[layer].range;
    const StripChunks& chunks = index.layers[layer].strips[strip];
    decode_depth_strip(content(*chunks.depth), place_of(chunk(*chunks.depth)), depth);
    if (chunks.alpha)
      part.alpha = decode_alpha_strip(content(*chunks.alpha), place_of(chunk(*chunks.alpha)), depth.coverage);
    if (with_colour)
      part.colour =
          decode_colour_strip(content(*chunks.colour), place_of(chunk(*chunks.colour)), depth, description.version);
    return part;
  }
};

LdpReader::LdpReader(std::span<const uint8_t> bytes, const LdpReadLimits& limits)
    : state_(std::make_unique<State>(bytes, limits)) {}
LdpReader::~LdpReader() = default;
LdpReader::LdpReader(LdpReader&&) noexcept = default;
LdpReader& LdpReader::operator=(LdpReader&&) noexcept = default;

const LdpDescription& LdpReader::description() const { return state_->description; }

std::set<ColourCoding> LdpReader::colour_codings(int layer) const {
  std::set<ColourCoding> codings;
  for (const StripChunks& strip : state_->index.layers.at(static_cast<size_t>(layer)).strips) {
    const LdpChunk& chunk = state_->chunk(*strip.colour);
    const auto coding = coding_of_colour(state_->content(*strip.colour), place_of(chunk), state_->description.version);
    if (coding) codings.insert(*coding);
  }
  return codings;
}

Layer LdpReader::read_layer(int layer, const Job& job) const {
  Layer decoded = read_layer(layer, {0, state_->description.panorama.grid.width}, true, job);
  check_present(layer, count_present(decoded.coverage));
  return decoded;
}

void LdpReader::check_present(int layer, uint64_t found) const {
  const auto l = static_cast<size_t>(layer);
  const uint64_t expected = state_->description.layers[l].present_pixels;
  if (found != expected)
    place_of(state_->chunk(*state_->index.layers[l].record))
        .refuse("number of present pixels", std::to_string(found) + " (as decoded)", std::to_string(expected));
}

Layer LdpReader::read_layer(int layer_number, const LdpColumns& columns, bool with_colour, const Job& job) const {
  const LdpDescription& file = state_->description;
  const PanoramaGrid& grid = file.panorama.grid;
  if (layer_number < 0 || static_cast<size_t>(layer_number) >= file.layers.size())
    throw std::logic_error("read_layer: there is no layer " + std::to_string(layer_number));
  const auto l = static_cast<size_t>(layer_number);
  const LdpLayerSummary& summary = file.layers[l];
  if (columns.begin < 0 || columns.begin >= columns.end || columns.end > grid.width)
    throw std::logic_error("read_layer: columns must lie within the grid");
  const int block_px = summary.block_px;
  if (block_px > 0 && columns.begin % block_px != 0)
    throw std::logic_error("read_layer: the first column must be a multiple of " + std::to_string(block_px));

  const int width = columns.end - columns.begin;
  Layer layer;
  layer.depth.block_px = block_px;
  layer.depth.codes = {width, grid.height};
  layer.depth.ranges = {blocks(width, block_px), blocks(grid.height, block_px), BlockRange{0, 0}};
  layer.coverage = {width, grid.height};
  if (summary.has_alpha) layer.alpha = {width, grid.height};
  if (with_colour) layer.colour = {width, grid.height};

  const int first = columns.begin / summary.strip_px;
  const int last = (columns.end - 1) / summary.strip_px;
  parallel_for(job, last - first + 1, [&](int i) {
    const State::Part part = state_->decode_strip(l, static_cast<size_t>(first + i), with_colour);
    const int begin = std::max(columns.begin, part.begin);
    const int end = std::min(columns.end, part.end);
    paste_columns(part.depth.codes, part.begin, begin, end, layer.depth.codes, columns.begin);
    paste_columns(part.depth.coverage, part.begin, begin, end, layer.coverage, columns.begin);
    if (summary.has_alpha) paste_columns(part.alpha, part.begin, begin, end, layer.alpha, columns.begin);
    if (with_colour) paste_columns(part.colour, part.begin, begin, end, layer.colour, columns.begin);
    if (block_px > 0)
      paste_columns(part.depth.ranges, part.begin / block_px, begin / block_px, (end + block_px - 1) / block_px,
                    layer.depth.ranges, columns.begin / block_px);
  });
  if (block_px == 0) layer.depth.ranges.samples[0] = state_->index.layers[l].range;
  return layer;
}

LayeredPanorama decode_ldp(std::span<const uint8_t> bytes, const LdpReadLimits& limits, const Job& job) {
  const LdpReader reader(bytes, limits);
  LayeredPanorama panorama = reader.description().panorama;
  for (size_t i = 0; i < reader.description().layers.size(); ++i)
    panorama.layers.push_back(reader.read_layer(static_cast<int>(i), job));
  return panorama;
}

LdpDescription describe_ldp(std::span<const uint8_t> bytes) { return LdpReader(bytes).description(); }

std::vector<std::string> verify_ldp(std::span<const uint8_t> bytes, const Job& job) {
  std::vector<std::string> damages;
  const auto attempt = [&](const auto& action) {
    try {
      action();
      return true;
    } catch (const LdpError& e) {
      if (std::find(damages.begin(), damages.end(), e.what()) == damages.end()) damages.emplace_back(e.what());
      return false;
    }
  };
  std::vector<LdpChunk> chunks;
  if (!attempt([&] { chunks = read_container(bytes).chunks; })) return damages;
  for (const LdpChunk& chunk : chunks) {
    job.check();
    attempt([&] { checked_bytes(bytes, chunk); });
  }
  std::optional<LdpReader> reader;
  if (!attempt([&] { reader.emplace(bytes); })) return damages;
  for (size_t layer = 0; layer < reader->description().layers.size(); ++layer) {
    const LdpLayerSummary& summary = reader->description().layers[layer];
    const int width = reader->description().panorama.grid.width;
    uint64_t present = 0;
    bool whole = true;
    for (int begin = 0; begin < width; begin += summary.strip_px) {
      job.check();
      whole &= attempt([&] {
        const Layer part =
            reader->read_layer(static_cast<int>(layer), {begin, std::min(width, begin + summary.strip_px)}, true);
        present += count_present(part.coverage);
      });
    }
    if (whole) attempt([&] { reader->check_present(static_cast<int>(layer), present); });
  }
  return damages;
}

}  // namespace ldp
