// What the C++ reader finds in .ldp files: of each the name, then checksums of its planes or why it was refused.
//
//   ldp_planes FILE.ldp ...
#include <cstdio>
#include <exception>

#include "core/base/files.h"
#include "core/photos/images.h"
#include "tests/golden/golden_panoramas.h"

int main(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    std::printf("file %s\n", argv[i]);
    try {
      std::fputs(ldp::plane_checksums(ldp::decode_ldp(ldp::read_file(argv[i]))).c_str(), stdout);
    } catch (const ldp::LdpError& e) {
      std::printf("refused %s\n", e.what());
    } catch (const std::exception& e) {
      std::fprintf(stderr, "ldp_planes: %s\n", e.what());
      return 1;
    }
  }
}
