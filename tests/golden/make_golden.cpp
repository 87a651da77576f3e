// Writes the golden .ldp files and the checksums of their planes. Only to be run when a new version of the format or
// another way of writing it gets new files: earlier ones stay as they are.
//
//   make_golden DIR
#include <cstdio>
#include <exception>

#include "core/base/files.h"
#include "core/photos/images.h"
#include "tests/golden/golden_panoramas.h"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: make_golden DIR\n");
    return 2;
  }
  try {
    for (const ldp::Golden& golden : ldp::golden_files()) {
      if (!golden.still_written) continue;
      const std::vector<uint8_t> file = ldp::encode_ldp(ldp::synthetic_panorama(golden.panorama), golden.encode);
      const std::string text = ldp::plane_checksums(ldp::decode_ldp(file));
      const std::filesystem::path stem = std::filesystem::path(argv[1]) / golden.name;
      ldp::write_file(stem.string() + ".ldp", file);
      ldp::write_file(stem.string() + ".txt", std::vector<uint8_t>(text.begin(), text.end()));
    }
  } catch (const std::exception& e) {
    std::fprintf(stderr, "make_golden: %s\n", e.what());
    return 1;
  }
}
