// Reading parts of a file of 100 megapixels: describing it, one layer, one range of angles. Writes the file (for
// `time ldp info FILE`) and prints wall seconds and bytes of the file that had to be read.
//
//   ldp_large FILE.ldp
#include <chrono>
#include <cstdio>
#include <exception>
#include <functional>

#include "core/base/files.h"
#include "core/panorama/file/ldp_file.h"
#include "core/photos/images.h"
#include "tests/golden/synthetic_panorama.h"

namespace ldp {
namespace {

constexpr int kWidth = 20000, kHeight = 5000;

double milliseconds(const std::function<void()>& action) {
  const auto begin = std::chrono::steady_clock::now();
  action();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
}

// Bytes of the chunks of one layer's strips that overlap the columns.
double bytes_of(const LdpDescription& file, int layer, const LdpColumns& columns) {
  const int strip_px = file.layers[static_cast<size_t>(layer)].strip_px;
  double sum = 0;
  for (const LdpChunk& chunk : file.chunks)
    if (chunk.layer == layer && chunk.strip >= columns.begin / strip_px && chunk.strip <= (columns.end - 1) / strip_px)
      sum += static_cast<double>(chunk.length);
  return sum;
}

void measure(const char* name) {
  write_file(name, encode_ldp(synthetic_panorama({kWidth, kHeight, 16, 2, false, Rays::pushbroom, false}), {}));
  const MappedFile mapped(name);
  LdpDescription file;
  const double describing = milliseconds([&] { file = describe_ldp(mapped.bytes()); });
  std::printf("%d x %d pixels, 2 layers, %.1f MB, %zu chunks\n", kWidth, kHeight,
              static_cast<double>(file.file_bytes) / 1e6, file.chunks.size());
  std::printf("description: %.2f ms\n", describing);
  const LdpReader reader(mapped.bytes());
  const auto part = [&](const char* what, int layer, const LdpColumns& columns, bool with_colour) {
    const double took = milliseconds([&] { reader.read_layer(layer, columns, with_colour, {}); });
    std::printf("%s: %.0f ms, %.2f MB of the file\n", what, took, bytes_of(file, layer, columns) / 1e6);
  };
  part("layer 2 alone", 1, {0, kWidth}, true);
  part("layer 1, columns 8000 to 9000 (5 %)", 0, {8000, 9000}, true);
  part("layer 1, columns 8000 to 8001", 0, {8000, 8001}, true);
  part("layer 1, columns 8000 to 9000, depth only", 0, {8000, 9000}, false);
  part("layer 1 whole", 0, {0, kWidth}, true);
}

}  // namespace
}  // namespace ldp

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: ldp_large FILE.ldp\n");
    return 2;
  }
  try {
    ldp::measure(argv[1]);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "ldp_large: %s\n", e.what());
    return 1;
  }
}
