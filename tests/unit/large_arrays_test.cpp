#include "core/base/memory/large_arrays.h"

#include <gtest/gtest.h>
#include <malloc.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <thread>
#include <vector>

#include "core/base/memory/scratch_space.h"
#include "core/base/plane.h"
#include "tests/sanitizers.h"

namespace ldp {
namespace {

using Bytes = Plane<uint8_t>;
constexpr int kMiB = 1 << 20;

Bytes mebibytes(int count) { return {1024, 1024 * count, 7}; }

TEST(RecycledArrays, AFreedArrayIsUsedAgainWithValuesOfItsOwn) {
  const RecycledArrays recycled;
  const void* first = nullptr;
  {
    Bytes plane = mebibytes(3);
    first = plane.samples.data();
  }
  EXPECT_EQ(RecycledArrays::kept_bytes(), 3U * kMiB);
  const Bytes again(1024, 1024 * 3);
  EXPECT_EQ(again.samples.data(), first);
  EXPECT_EQ(RecycledArrays::kept_bytes(), 0U);
  EXPECT_EQ(std::count(again.samples.begin(), again.samples.end(), 0), 3 * kMiB);
}

TEST(RecycledArrays, TheSmallestThatFitsIsTakenAndNoneMuchLarger) {
  const RecycledArrays recycled;
  mebibytes(30);  // so large the process may be
  std::vector<Bytes> planes;
  for (const int size : {4, 5, 9}) planes.push_back(mebibytes(size));
  const void *four = planes[0].samples.data(), *five = planes[1].samples.data();
  planes.clear();
  const Bytes wanted(1024, 1024 * 4 + 1);
  EXPECT_EQ(wanted.samples.data(), five);
  EXPECT_EQ(RecycledArrays::kept_bytes(), 13U * kMiB);
  EXPECT_NE(mebibytes(3).samples.data(), four) << "4 MiB are a third more than 3";
}

TEST(RecycledArrays, NeverTooManyAreKeptAndTheOldestGoFirst) {
  const RecycledArrays recycled;
  const auto most = static_cast<int>(RecycledArrays::kMostKept / kMiB);
  mebibytes(most + 1);
  EXPECT_EQ(RecycledArrays::kept_bytes(), 0U) << "too large alone";
  std::vector<Bytes> planes;
  for (int i = 0; i < 5; ++i) planes.push_back(mebibytes(most / 4));
  const void* youngest = planes[4].samples.data();
  for (Bytes& plane : planes) plane = {};
  EXPECT_EQ(RecycledArrays::kept_bytes(), RecycledArrays::kMostKept);
  EXPECT_EQ(mebibytes(most / 4).samples.data(), youngest) << "its pages are likeliest in the caches";
}

TEST(RecycledArrays, NothingIsKeptBeforeAndAfter) {
  mebibytes(2);
  EXPECT_EQ(RecycledArrays::kept_bytes(), 0U);
  Bytes outlives;
  {
    const RecycledArrays recycled;
    {
      const RecycledArrays another;
      outlives = mebibytes(2);
      mebibytes(2);
    }
    EXPECT_EQ(RecycledArrays::kept_bytes(), 2U * kMiB) << "one is left";
  }
  EXPECT_EQ(RecycledArrays::kept_bytes(), 0U);
  EXPECT_EQ(std::count(outlives.samples.begin(), outlives.samples.end(), 7), 2 * kMiB);
}

TEST(RecycledArrays, WhatIsKeptDoesNotMakeTheProcessLarger) {
  NOT_UNDER_SANITIZERS("their shadow is part of what the process holds");
  mallopt(M_MMAP_THRESHOLD, kLargeArray_bytes);  // what is freed goes back to the system,
  malloc_trim(0);                                // and has gone back
  const RecycledArrays recycled;
  mebibytes(20);
  ASSERT_EQ(RecycledArrays::kept_bytes(), 20U * kMiB);
  const Bytes other = mebibytes(12);
  EXPECT_EQ(RecycledArrays::kept_bytes(), 0U) << "with the 12 it would hold 32 MiB, 12 more than ever";
}

TEST(RecycledArrays, ThoseOfAScratchSpaceTooAndTheyCount) {
  std::string name = testing::TempDir() + "ldp_recycled_XXXXXX";
  const std::string folder = mkdtemp(name.data());
  {
    const ScratchSpace scratch(folder, std::numeric_limits<size_t>::max());
    const RecycledArrays recycled;
    mebibytes(3);
    EXPECT_EQ(RecycledArrays::kept_bytes(), 3U * kMiB);
    EXPECT_EQ(scratch.bytes(), 3U * kMiB);
    const Bytes again = mebibytes(3);
    EXPECT_EQ(scratch.bytes(), 3U * kMiB);
  }
  EXPECT_EQ(RecycledArrays::kept_bytes(), 0U);
  std::filesystem::remove_all(folder);
}

TEST(RecycledArrays, NoneIsCarriedIntoAScratchSpaceNorOutOfIt) {
  std::string name = testing::TempDir() + "ldp_recycled_XXXXXX";
  const std::string folder = mkdtemp(name.data());
  const RecycledArrays recycled;
  Bytes from_before = mebibytes(2), of_the_space;
  mebibytes(3);
  {
    const ScratchSpace scratch(folder, std::numeric_limits<size_t>::max());
    EXPECT_EQ(RecycledArrays::kept_bytes(), 0U);
    from_before = {};
    EXPECT_EQ(RecycledArrays::kept_bytes(), 0U) << "it cannot be let go";
    of_the_space = mebibytes(3);
    EXPECT_EQ(scratch.bytes(), 3U * kMiB);
    mebibytes(4);
    EXPECT_EQ(RecycledArrays::kept_bytes(), 4U * kMiB);
  }
  EXPECT_EQ(RecycledArrays::kept_bytes(), 0U);
  of_the_space = {};
  EXPECT_EQ(RecycledArrays::kept_bytes(), 0U);
  std::filesystem::remove_all(folder);
}

TEST(RecycledArrays, SmallArraysAreNotKept) {
  const RecycledArrays recycled;
  { const Bytes small(511, 512); }
  EXPECT_EQ(RecycledArrays::kept_bytes(), 0U);
  { const Bytes large(512, 512); }
  EXPECT_EQ(RecycledArrays::kept_bytes(), kLargeArray_bytes);
}

TEST(RecycledArrays, ThreadsShareThem) {
  const RecycledArrays recycled;
  std::vector<std::jthread> threads;
  std::vector<int> wrong(4, 0);
  for (int t = 0; t < 4; ++t)
    threads.emplace_back([t, &wrong] {
      for (int i = 0; i < 200; ++i) {
        const auto own = static_cast<uint8_t>(4 * i + t);
        const Plane<uint8_t> plane(600, 500 + 10 * ((i + t) % 5), own);
        if (std::any_of(plane.samples.begin(), plane.samples.end(), [own](uint8_t s) { return s != own; }))
          ++wrong[static_cast<size_t>(t)];
      }
    });
  threads.clear();
  EXPECT_EQ(wrong, std::vector<int>(4, 0));
}

}  // namespace
}  // namespace ldp
