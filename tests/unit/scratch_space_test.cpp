#include "core/base/memory/scratch_space.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <limits>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include "core/base/job.h"
#include "core/base/plane.h"
#include "tests/sanitizers.h"

namespace ldp {
namespace {

namespace fs = std::filesystem;

constexpr int kSide = 4096;  // of planes of 16 MiB
constexpr const char* kShadow = "its shadow of what is touched stays in memory";
constexpr size_t kNothing = 1, kPlenty = std::numeric_limits<size_t>::max();

uint8_t pattern(int x, int y) { return static_cast<uint8_t>(x * 31 + y * 17 + (x * y >> 5)); }

Plane<uint8_t> patterned() {
  Plane<uint8_t> plane(kSide, kSide);
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) plane.at(x, y) = pattern(x, y);
  return plane;
}

size_t wrong_samples(const Plane<uint8_t>& plane) {
  size_t wrong = 0;
  for (int y = 0; y < plane.height; ++y)
    for (int x = 0; x < plane.width; ++x) wrong += plane.at(x, y) != pattern(x, y);
  return wrong;
}

size_t resident_mebibytes() {
  std::ifstream statm("/proc/self/statm");
  size_t all = 0, resident = 0;
  statm >> all >> resident;
  return resident * static_cast<size_t>(::sysconf(_SC_PAGESIZE)) >> 20;
}

class ScratchSpaceTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = testing::TempDir() + "ldp_scratch_XXXXXX";
    folder_ = mkdtemp(name.data());
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string folder_;
};

TEST_F(ScratchSpaceTest, PlanesKeepTheirSamplesHoweverOftenTheyAreLetGo) {
  ScratchSpace scratch(folder_, kNothing);
  Plane<uint8_t> plane = patterned();
  EXPECT_EQ(scratch.bytes(), plane.samples.size());
  EXPECT_TRUE(fs::is_empty(folder_)) << "a file has a name";
  EXPECT_EQ(wrong_samples(plane), 0U);
  const Plane<uint8_t> copy = plane;
  EXPECT_EQ(scratch.bytes(), 2 * plane.samples.size());
  const Plane<uint8_t> moved = std::move(plane);
  EXPECT_EQ(wrong_samples(copy), 0U);
  EXPECT_EQ(wrong_samples(moved), 0U);
}

TEST_F(ScratchSpaceTest, TheProcessIsBackWithinItsBudget) {
  NOT_UNDER_THREAD_SANITIZER(kShadow);
  const size_t before = resident_mebibytes();
  ScratchSpace scratch(folder_, (before + 8) << 20);
  const Plane<uint8_t> one = patterned(), two = patterned();
  const auto late = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  while (resident_mebibytes() > before + 8 && std::chrono::steady_clock::now() < late) std::this_thread::yield();
  EXPECT_LE(resident_mebibytes(), before + 8);
  EXPECT_EQ(wrong_samples(one) + wrong_samples(two), 0U);
}

TEST_F(ScratchSpaceTest, WhatWasTouchedInAMomentIsLetGoBeforeTheNextTask) {
  NOT_UNDER_THREAD_SANITIZER(kShadow);
  constexpr int kPlanes = 8, kPage = 4096;
  const size_t before = resident_mebibytes(), room = std::max<size_t>(16, before);  // most of the budget is arrays
  ScratchSpace scratch(folder_, (before + room) << 20);
  std::vector<Plane<uint8_t>> planes;
  for (int i = 0; i < kPlanes; ++i) planes.push_back(patterned());
  size_t most = 0;
  parallel_for({}, 4 * kPlanes, [&](int i) {
    if (i > 0) most = std::max(most, resident_mebibytes());
    const Plane<uint8_t>& plane = planes[static_cast<size_t>(i % kPlanes)];
    for (size_t k = 0; k < plane.samples.size(); k += kPage) *const_cast<volatile const uint8_t*>(&plane.samples[k]);
  });
  EXPECT_LE(most, before + room + 16);  // one plane where the space itself was just looking
}

// Each task would bring back what the one before it let go: a fault of the page that all of them touch.
TEST_F(ScratchSpaceTest, WhereMostThatIsHeldIsNoArrayTheyDoNotComeAndGoWithEachTask) {
  ScratchSpace scratch(folder_, kNothing);
  const Plane<uint8_t> plane = patterned();
  constexpr int kTasks = 20000;
  const auto faults = [] {
    rusage used{};
    ::getrusage(RUSAGE_SELF, &used);
    return used.ru_minflt + used.ru_majflt;
  };
  const auto before = faults();
  parallel_for({}, kTasks, [&](int) { *const_cast<volatile const uint8_t*>(plane.samples.data()); });
  EXPECT_LT(faults() - before, kTasks / 2);
}

TEST_F(ScratchSpaceTest, SmallArraysAndArraysFromBeforeStayInMemory) {
  Plane<uint8_t> before(kSide, kSide, 7);
  ScratchSpace scratch(folder_, kPlenty);
  Plane<uint8_t> small(500, 500, 7);
  EXPECT_EQ(scratch.bytes(), 0U);
  before = {};
  EXPECT_EQ(scratch.bytes(), 0U);
}

TEST_F(ScratchSpaceTest, RoomIsGivenBackAndArraysMayOutliveTheSpace) {
  Plane<uint8_t> last;
  {
    ScratchSpace scratch(folder_, kNothing);
    last = patterned();
    { const Plane<Rgb> gone(kSide, kSide); }
    EXPECT_EQ(scratch.bytes(), last.samples.size());
  }
  EXPECT_EQ(wrong_samples(last), 0U);
  ScratchSpace another(folder_, kPlenty);
  last = {};
  EXPECT_EQ(another.bytes(), 0U);
}

TEST_F(ScratchSpaceTest, WhereThereIsNoRoomArraysLiveInMemory) {
  ScratchSpace scratch(folder_, kNothing);
  fs::remove_all(folder_);
  EXPECT_EQ(wrong_samples(patterned()), 0U);
  EXPECT_EQ(scratch.bytes(), 0U);
}

TEST_F(ScratchSpaceTest, AFolderThatTakesNoFilesAndASecondSpaceAreRefused) {
  EXPECT_THROW(ScratchSpace(folder_ + "/missing", kPlenty), std::runtime_error);
  EXPECT_THROW(ScratchSpace("/dev/shm", kPlenty), std::runtime_error) << "files there are memory";
  ScratchSpace scratch(folder_, kPlenty);
  EXPECT_THROW(ScratchSpace(folder_, kPlenty), std::logic_error);
}

}  // namespace
}  // namespace ldp
