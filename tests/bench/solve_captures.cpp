// The sweep's own volumes of captures with given cameras.
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "core/sweep/cost_volume.h"
#include "tests/bench/captures.h"
#include "tests/bench/solve_volumes.h"

namespace ldp {

namespace {

namespace fs = std::filesystem;

Volume whole(const CostSource& source) {
  Volume volume(source.width(), source.height(), source.labels(), source.wraps());
  volume.median.resize(volume.cost.size());
  for (int x = 0; x < source.width(); x += 128) {
    const Window window{x, 0, std::min(128, source.width() - x), source.height()};
    source.read(window, volume.cost.data() + volume.index(x, 0), volume.median.data() + volume.index(x, 0));
  }
  return volume;
}

}  // namespace

Problem capture_problem(const std::string& folder) {
  const PreparedCapture capture = prepare_capture(folder);
  return {fs::path(folder).filename(), whole(CostVolume(capture.upright, capture.grid, {}, {}, {})), {}, {}, 1};
}

void save_volume(const Volume& volume, const std::string& file) {
  std::ofstream out(file, std::ios::binary);
  out << volume.width() << ' ' << volume.height() << ' ' << volume.labels() << ' ' << volume.wraps() << '\n';
  out.write(reinterpret_cast<const char*>(volume.cost.data()), static_cast<std::streamsize>(volume.cost.size()));
  out.write(reinterpret_cast<const char*>(volume.median.data()), static_cast<std::streamsize>(volume.median.size()));
}

Problem saved_problem(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  int width = 0, height = 0, labels = 0;
  bool wraps = false;
  in >> width >> height >> labels >> wraps;
  in.get();
  if (!in) throw std::runtime_error(file + ": not a volume saved by this program");
  Volume volume(width, height, labels, wraps);
  volume.median.resize(volume.cost.size());
  in.read(reinterpret_cast<char*>(volume.cost.data()), static_cast<std::streamsize>(volume.cost.size()));
  in.read(reinterpret_cast<char*>(volume.median.data()), static_cast<std::streamsize>(volume.median.size()));
  return {fs::path(file).stem(), std::move(volume), {}, {}, 1};
}

}  // namespace ldp
