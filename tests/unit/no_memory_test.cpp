// What becomes of threads, files and what is read when memory ends: at every allocation once, and from every allocation
// on. The program's own operator new refuses. (JSON is left out: the library's destructor allocates, and ends the
// program where it cannot.)
#include <gtest/gtest.h>
#include <poll.h>

#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <new>
#include <optional>

#include "core/base/files.h"
#include "core/base/job.h"
#include "core/base/task_order.h"
#include "core/panorama/file/ldp_file.h"
#include "core/photos/images.h"
#include "device/capture/frame_writer.h"
#include "tests/sanitizers.h"

namespace {

constexpr int kNever = 1 << 30;

std::atomic<int> allocations_left = kNever;
std::atomic<bool> for_good = false;
thread_local bool is_spared = false;  // what the test itself needs

bool refuses() {
  if (is_spared || allocations_left.load() == kNever) return false;
  const int left = --allocations_left;
  return left == -1 || (left < -1 && for_good.load());
}

void* allocated(std::size_t bytes) {
  if (refuses()) throw std::bad_alloc();
  if (void* const memory = std::malloc(bytes == 0 ? 1 : bytes)) return memory;
  throw std::bad_alloc();
}

}  // namespace

void* operator new(std::size_t bytes) { return allocated(bytes); }
void* operator new[](std::size_t bytes) { return allocated(bytes); }
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }

namespace ldp {
namespace {

namespace fs = std::filesystem;

constexpr const char* kOthersAllocate = "what libraries allocate comes from its own operator new";

// While one is alive, the allocation after `spared` others fails; with `then_all` every one after it too.
class MemoryEnds {
 public:
  MemoryEnds(int spared, bool then_all) {
    for_good = then_all;
    allocations_left = spared;
  }
  ~MemoryEnds() { allocations_left = kNever; }
  MemoryEnds(const MemoryEnds&) = delete;
  MemoryEnds& operator=(const MemoryEnds&) = delete;

  static bool came() { return allocations_left.load() < 0; }
};

class Spared {
 public:
  Spared() { is_spared = true; }
  ~Spared() { is_spared = false; }
  Spared(const Spared&) = delete;
  Spared& operator=(const Spared&) = delete;
};

// `work` ends well, or by bad_alloc and nothing else, wherever memory ends. Gives how many allocations were tried.
template <typename Work>
int expect_bad_alloc_only(const Work& work) {
  int tried = 0;
  for (const bool then_all : {false, true}) {
    bool came = true;
    for (int spared = 0; came; spared += 1 + spared / 24, ++tried) {
      bool refused = false;
      std::string other;
      {
        const MemoryEnds ends(spared, then_all);
        try {
          work();
        } catch (const std::bad_alloc&) {
          refused = true;
        } catch (const std::exception& error) {
          const Spared here;
          other = error.what();
        }
        came = MemoryEnds::came();
      }
      EXPECT_EQ(other, "") << "at allocation " << spared;
      EXPECT_TRUE(came || !refused);
    }
  }
  return tried;
}

class NoMemory : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = testing::TempDir() + "ldp_no_memory_XXXXXX";
    folder_ = mkdtemp(name.data());
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path folder_;
};

std::optional<WriteOutcome> outcome_of(FrameWriter& writer) {
  pollfd entry{writer.fd(), POLLIN, 0};
  while (::poll(&entry, 1, 10'000) == 1)
    if (auto outcome = writer.take()) return outcome;
  return std::nullopt;
}

TEST_F(NoMemory, TheThreadThatStoresFramesTellsAndGoesOn) {
  const Spared here;
  for (const bool then_all : {false, true}) {
    bool came = true;
    for (int spared = 0; came; ++spared) {
      FrameWriter writer;
      {
        const MemoryEnds ends(spared, then_all);
        writer.put({folder_, "frame_000.jpg", std::vector<uint8_t>(100, 7), "{}"});
        const auto outcome = outcome_of(writer);
        came = MemoryEnds::came();
        ASSERT_TRUE(outcome);
        EXPECT_EQ(outcome->file, "frame_000.jpg");
        EXPECT_EQ(outcome->error.empty(), !came) << outcome->error;
        EXPECT_EQ(writer.pending(), 0U);
      }
      writer.put({folder_, "frame_001.jpg", std::vector<uint8_t>(100, 8), ""});
      const auto next = outcome_of(writer);
      ASSERT_TRUE(next);
      EXPECT_EQ(next->error, "");
      EXPECT_EQ(read_file(folder_ / "frame_001.jpg"), std::vector<uint8_t>(100, 8));
      for (const auto& entry : fs::directory_iterator(folder_)) EXPECT_NE(entry.path().extension(), ".tmp");
    }
  }
}

TEST_F(NoMemory, AFileIsWrittenWholeOrNotAtAll) {
  const fs::path file = folder_ / "a.ldp";
  const std::vector<uint8_t> before(50, 1), after(5000, 2);
  EXPECT_GT(expect_bad_alloc_only([&] {
              {
                const Spared here;
                write_file(file, before);
              }
              write_file(file, after);
            }),
            4);
  EXPECT_EQ(read_file(file), after);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()), 1);
}

TEST_F(NoMemory, WorkOnThreadsEndsWithTheFailureOrWithAllItems) {
  Job job;
  job.threads = 3;
  EXPECT_GT(expect_bad_alloc_only([&] {
              std::atomic<int> done = 0;
              parallel_for(job, 20, [&](int i) { done += static_cast<int>(std::vector<int>(10, 1 + i)[9] > 0); });
              EXPECT_EQ(done, 20);
            }),
            10);
  EXPECT_GT(expect_bad_alloc_only([&] {
              std::atomic<int> done = 0;
              TaskOrder order;
              const auto first = order.add([&] { ++done; }, {});
              for (int i = 0; i < 5; ++i) order.add([&] { done += std::vector<int>(10, 1)[9]; }, {first});
              order.run(job);
              EXPECT_EQ(done, 6);
            }),
            10);
}

TEST_F(NoMemory, APanoramaIsReadOrMemoryIsToldToHaveEnded) {
  NOT_UNDER_THREAD_SANITIZER(kOthersAllocate);
  for (const char* const name : {"tiny", "gathered_jpeg", "whole_strips"}) {
    const std::vector<uint8_t> bytes = read_file(LDP_TEST_DATA "/golden/" + std::string(name) + ".ldp");
    EXPECT_GT(expect_bad_alloc_only([&] { decode_ldp(bytes); }), 50);
    EXPECT_GT(expect_bad_alloc_only([&] { describe_ldp(bytes); }), 20);
  }
}

TEST_F(NoMemory, APhotoIsReadOrMemoryIsToldToHaveEnded) {
  NOT_UNDER_THREAD_SANITIZER(kOthersAllocate);
  RgbImage image(40, 30);
  for (size_t i = 0; i < image.samples.size(); ++i) image.samples[i].g = static_cast<uint8_t>(i * 2654435761U >> 7);
  for (const auto& bytes : {encode_jpeg(image, 90), encode_png(image), encode_webp(image, 90)})
    EXPECT_GT(expect_bad_alloc_only([&] { decode_image(bytes, "photo"); }), 2);
}

}  // namespace
}  // namespace ldp
