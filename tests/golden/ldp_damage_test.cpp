// Golden files cut short at every length, with bytes changed at random, and with bytes changed behind checksums made
// right: refused or decoded to what they hold, within 1 s of processor time and 64 MiB.
//
// LDP_FLIPS=N sets how many bytes are changed; `ctest -C Long -R Damage` changes 100,000.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "core/base/files.h"
#include "core/photos/images.h"
#include "tests/golden/golden_panoramas.h"
#include "tests/golden/sealed_file.h"
#include "tests/sanitizers.h"

namespace ldp {
namespace {

constexpr LdpReadLimits kLimits{1 << 16};  // what a small device would set; all golden files are within it
constexpr double kMostSeconds = 1;
constexpr long kMostKibibytes = 64 << 10;

struct Original {
  std::string name;
  std::vector<uint8_t> bytes;
  std::string planes;
};

std::vector<Original> originals() {
  const std::filesystem::path folder = std::filesystem::path(LDP_TEST_DATA) / "golden";
  std::vector<Original> files;
  for (const Golden& golden : golden_files()) {
    const std::vector<uint8_t> text = read_file(folder / (std::string(golden.name) + ".txt"));
    files.push_back({golden.name, read_file(folder / (std::string(golden.name) + ".ldp")), {text.begin(), text.end()}});
  }
  return files;
}

int flips() {
  const char* text = std::getenv("LDP_FLIPS");
  return text ? std::max(1, std::atoi(text)) : 2000;
}

// The largest resident size this process ever had, in KiB; 0 where the system does not tell.
long peak_kibibytes() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("VmHWM:")) return std::atol(line.c_str() + 6);
  return 0;
}

struct Tally {
  int refused = 0, decoded = 0;
  double slowest_s = 0;
};

enum class Outcome { refused, decoded };

// Anything but LdpError ends the test; what is decoded is returned by its planes' checksums.
Outcome attempt(std::span<const uint8_t> file, Tally& tally, std::string* planes = nullptr) {
  const std::clock_t begin = std::clock();
  Outcome outcome = Outcome::decoded;
  try {
    const LayeredPanorama panorama = decode_ldp(file, kLimits);
    if (planes) *planes = plane_checksums(panorama);
  } catch (const LdpError&) {
    outcome = Outcome::refused;
  }
  ++(outcome == Outcome::refused ? tally.refused : tally.decoded);
  tally.slowest_s = std::max(tally.slowest_s, static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC);
  return outcome;
}

void expect_within_bounds(const Tally& tally, long peak_before) {
  EXPECT_LT(tally.slowest_s, kMostSeconds);
  if (!kSanitized) {  // which keep more
    EXPECT_LT(peak_kibibytes() - peak_before, kMostKibibytes);
  }
  std::printf("refused %d, decoded %d; slowest %.3f s; peak %ld KiB above %ld KiB\n", tally.refused, tally.decoded,
              tally.slowest_s, peak_kibibytes() - peak_before, peak_before);
}

TEST(GoldenDamage, EveryTruncationIsRefused) {
  const long peak = peak_kibibytes();
  Tally tally;
  for (const Original& file : originals())
    for (size_t length = 0; length < file.bytes.size(); ++length)
      ASSERT_EQ(attempt(std::span(file.bytes).first(length), tally), Outcome::refused) << file.name << " " << length;
  expect_within_bounds(tally, peak);
}

TEST(GoldenDamage, AChangedByteIsRefusedOrTheImageIsRight) {
  const long peak = peak_kibibytes();
  std::mt19937 random(31);
  std::vector<Original> files = originals();
  Tally tally;
  for (int i = 0; i < flips(); ++i) {
    Original& file = files[random() % files.size()];
    uint8_t& byte = file.bytes[random() % file.bytes.size()];
    const uint8_t was = byte;
    byte = static_cast<uint8_t>(byte ^ (1 + random() % 255));
    std::string planes;
    if (attempt(file.bytes, tally, &planes) == Outcome::decoded) {
      ASSERT_EQ(planes, file.planes) << file.name;
    }
    byte = was;
  }
  expect_within_bounds(tally, peak);
}

// A forger makes the checksums right. What is then decoded need not be the truth, but must be decoded safely.
TEST(GoldenDamage, AForgedByteIsRefusedOrDecodedWithinBounds) {
  const long peak = peak_kibibytes();
  std::mt19937 random(37);
  const std::vector<Original> files = originals();
  Tally tally;
  for (int i = 0; i < flips(); ++i) {
    std::vector<uint8_t> forged = files[random() % files.size()].bytes;
    for (auto count = 1 + random() % 3; count > 0; --count) {
      const size_t at = random() % forged.size();
      forged[at] = static_cast<uint8_t>(forged[at] ^ (1 + random() % 255));
    }
    seal(forged);
    attempt(forged, tally);
  }
  EXPECT_GT(tally.refused, 0);
  EXPECT_GT(tally.decoded, 0) << "the test never got past the first checks";
  expect_within_bounds(tally, peak);
}

// Cut at about 3,000 lengths of each file, behind right checksums: the table is shortened or the last chunks are.
TEST(GoldenDamage, AForgedTruncationIsRefused) {
  const long peak = peak_kibibytes();
  Tally tally;
  for (const Original& file : originals())
    for (size_t length = 32; length < file.bytes.size(); length += std::max<size_t>(1, file.bytes.size() / 3000)) {
      std::vector<uint8_t> forged(file.bytes.begin(), file.bytes.begin() + static_cast<std::ptrdiff_t>(length));
      seal(forged);
      ASSERT_EQ(attempt(forged, tally), Outcome::refused) << file.name << " " << length;
    }
  expect_within_bounds(tally, peak);
}

}  // namespace
}  // namespace ldp
