#include <gtest/gtest.h>

#include <filesystem>

#include "core/base/files.h"
#include "core/photos/images.h"
#include "tests/golden/golden_panoramas.h"

namespace ldp {
namespace {

std::vector<uint8_t> stored(const std::string& name) {
  return read_file(std::filesystem::path(LDP_TEST_DATA) / "golden" / name);
}

TEST(GoldenFiles, DecodeToTheirChecksumsForEver) {
  for (const Golden& golden : golden_files()) {
    const std::vector<uint8_t> text = stored(std::string(golden.name) + ".txt");
    EXPECT_EQ(plane_checksums(decode_ldp(stored(std::string(golden.name) + ".ldp"))),
              std::string(text.begin(), text.end()))
        << golden.name;
  }
}

TEST(GoldenFiles, AreSound) {
  for (const Golden& golden : golden_files())
    for (const std::string& damage : verify_ldp(stored(std::string(golden.name) + ".ldp")))
      ADD_FAILURE() << golden.name << ": " << damage;
}

// Colour and thumbnail may change with the codecs' libraries; nothing else may.
TEST(GoldenFiles, AreWhatTheEncoderStillWrites) {
  for (const Golden& golden : golden_files()) {
    if (!golden.still_written) continue;
    const std::vector<uint8_t> then = stored(std::string(golden.name) + ".ldp");
    const std::vector<uint8_t> now = encode_ldp(synthetic_panorama(golden.panorama), golden.encode);
    const std::vector<LdpChunk> a = describe_ldp(then).chunks;
    const std::vector<LdpChunk> b = describe_ldp(now).chunks;
    ASSERT_EQ(a.size(), b.size()) << golden.name;
    for (size_t i = 0; i < a.size(); ++i) {
      EXPECT_EQ(a[i].type, b[i].type);
      if (a[i].type == "COLR" || a[i].type == "thmb") continue;
      EXPECT_EQ(a[i].length, b[i].length) << golden.name << " " << a[i].type;
      EXPECT_EQ(a[i].crc32c, b[i].crc32c) << golden.name << " " << a[i].type;
    }
  }
}

}  // namespace
}  // namespace ldp
