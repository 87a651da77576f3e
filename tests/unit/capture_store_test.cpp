// Storage, the frame writer and the build as a child process.
#include "device/capture/capture_store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <sys/stat.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/base/files.h"
#include "device/capture/frame_writer.h"
#include "device/capture/log.h"
#include "device/service/builds/build_child.h"
#include "device/service/sweep_run.h"

namespace ldp {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class CaptureStoreTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = testing::TempDir() + "ldp_store_XXXXXX";
    output_ = mkdtemp(name.data());
  }
  void TearDown() override { fs::remove_all(output_); }

  static void touch(const fs::path& file) { std::ofstream(file) << "x"; }
  fs::path script(const std::string& text) const {
    std::ofstream(output_ / "program") << "#!/bin/bash\n" << text;
    fs::permissions(output_ / "program", fs::perms::owner_all);
    return output_ / "program";
  }

  fs::path output_;
};

TEST_F(CaptureStoreTest, NamesCountUpAndAreNeverGivenTwice) {
  const CaptureStore store(output_);
  store.prepare();
  EXPECT_EQ(store.create_capture(), "sweep_000001");
  EXPECT_EQ(store.create_capture(), "sweep_000002");
  store.discard("sweep_000001");
  store.discard("sweep_000002");
  EXPECT_EQ(store.create_capture(), "sweep_000003") << "a deleted capture's name was given again";
  touch(output_ / "sweep_000041.ldp");
  fs::remove(output_ / ".last_sweep");
  EXPECT_EQ(store.create_capture(), "sweep_000042") << "a panorama whose capture was deleted would be overwritten";
}

// A name that the next start would not know for a sweep's: its frames would never be built.
TEST_F(CaptureStoreTest, ANumberThatNoSweepCanHaveIsNotCountedOn) {
  const CaptureStore store(output_);
  store.prepare();
  EXPECT_EQ(store.create_capture(), "sweep_000001");
  for (const char* const number : {"999999999", "99999999999999999999", "-7", "2147483647"}) {
    std::ofstream(output_ / ".last_sweep") << number << "\n";
    const std::string name = store.create_capture();
    EXPECT_LE(name, "sweep_000005") << number;
    const auto known = store.recover();
    EXPECT_TRUE(std::any_of(known.begin(), known.end(), [&](const CaptureState& is) { return is.name == name; }));
  }
  std::ofstream(output_ / ".last_sweep") << "999999998\n";
  EXPECT_EQ(store.create_capture(), "sweep_999999999");
}

TEST_F(CaptureStoreTest, RecoveryRemovesTemporariesAndNothingElse) {
  const CaptureStore store(output_);
  store.prepare();
  const std::string name = store.create_capture();
  touch(store.folder_of(name) / "frame_000.jpg");
  touch(store.folder_of(name) / "frame_001.jpg.8123.tmp");
  touch(output_ / ".sweep_000001.ldp.8123.tmp");
  for (const char* const theirs : {"notes.txt", "letter.tmp"}) touch(output_ / theirs);
  fs::create_directory(output_ / "holiday");
  touch(output_ / "holiday" / "letter.tmp");
  store.clear_building();
  touch(store.building_of(name));
  const auto captures = store.recover();
  ASSERT_EQ(captures.size(), 1U);
  EXPECT_EQ(captures[0].frames, 1);
  EXPECT_FALSE(captures[0].built);
  EXPECT_FALSE(fs::exists(store.folder_of(name) / "frame_001.jpg.8123.tmp"));
  EXPECT_FALSE(fs::exists(store.building_of(name)));
  EXPECT_TRUE(fs::exists(store.folder_of(name) / "frame_000.jpg"));
  EXPECT_FALSE(fs::exists(output_ / ".sweep_000001.ldp.8123.tmp"));
  EXPECT_TRUE(fs::exists(output_ / "notes.txt"));
  EXPECT_TRUE(fs::exists(output_ / "letter.tmp")) << "a stranger's file";
  EXPECT_TRUE(fs::exists(output_ / "holiday" / "letter.tmp")) << "a stranger's file";
}

TEST_F(CaptureStoreTest, APublishedPanoramaIsInItsPlaceAndTheRecordGone) {
  const CaptureStore store(output_);
  store.prepare();
  const std::string name = store.create_capture();
  store.clear_building();
  store.write_build_record(name, {2, false, true, "why \"so\""});
  EXPECT_EQ(store.read_build_record(name).reason, "why \"so\"");
  EXPECT_EQ(store.read_build_record(name).interruptions, 2);
  EXPECT_TRUE(store.read_build_record(name).failed);
  touch(store.building_of(name));
  store.publish_panorama(name);
  EXPECT_TRUE(fs::exists(store.panorama_of(name)));
  EXPECT_FALSE(store.read_build_record(name).failed);
  EXPECT_THROW(store.publish_panorama(name), std::system_error) << "there is nothing to publish any more";
}

TEST_F(CaptureStoreTest, ADamagedBuildRecordCountsAsNone) {
  const CaptureStore store(output_);
  store.prepare();
  const std::string name = store.create_capture();
  std::ofstream(store.folder_of(name) / "build.json") << "{\"failed\": tru";
  EXPECT_FALSE(store.read_build_record(name).failed);
}

TEST_F(CaptureStoreTest, SweepsLeftShrinkWithTheReserve) {
  const CaptureStore store(output_);
  store.prepare();
  EXPECT_GT(store.sweeps_left(0), 0);
  EXPECT_EQ(store.sweeps_left(uint64_t{1} << 60), 0);
}

TEST_F(CaptureStoreTest, SweepsLeftGoByTheLastThatWereBuiltAndNotByOneThatIsBeingTaken) {
  const CaptureStore store(output_);
  store.prepare();
  const auto fill = [](const fs::path& file, size_t mebibytes) { write_file(file, std::string(mebibytes << 20, 'x')); };
  const int at_first = store.sweeps_left(0);
  const std::string name = store.create_capture();
  fill(store.folder_of(name) / "frame_000.jpg", 2);
  EXPECT_NEAR(store.sweeps_left(0), at_first, at_first / 10 + 1) << "it is not whole yet";
  fill(store.panorama_of(name), 2);
  const int by_the_first = store.sweeps_left(0);
  EXPECT_GT(by_the_first, at_first);
  fill(store.folder_of(store.create_capture()) / "frame_000.jpg", 3);
  EXPECT_NEAR(store.sweeps_left(0), by_the_first, by_the_first / 10 + 1);
}

TEST_F(CaptureStoreTest, AFolderThatCannotBeMadeIsNamedWithWhatToDo) {
  touch(output_ / "file");
  for (const fs::path& folder : {output_ / "file" / "folder", fs::path("/proc/folder")}) {
    try {
      CaptureStore(folder).prepare();
      FAIL() << folder;
    } catch (const std::system_error& error) {
      EXPECT_EQ(error.what(), "cannot make the folder " + folder.string() + ": " + error.code().message() +
                                  ": choose another folder to write to");
    }
  }
}

TEST(CaptureJson, SaysWhatIsKnown) {
  CaptureRecord record;
  record.device = "camera 7";
  record.width = 640;
  record.frames = {{"frame_000.jpg", 123, 4, 0.01, 2.0}, {"frame_001.jpg", 456, 9, {}, {}}};
  const auto json = nlohmann::json::parse(capture_json(record));
  EXPECT_EQ(json["clock_synchronized"], true);
  record.clock_synchronized = false;
  EXPECT_EQ(nlohmann::json::parse(capture_json(record))["clock_synchronized"], false);
  EXPECT_EQ(json["device"], "camera 7");
  EXPECT_EQ(json["frames"][0]["exposure_s"], 0.01);
  EXPECT_FALSE(json["frames"][1].contains("gain"));
  EXPECT_FALSE(json.contains("fov_degrees"));
}

// --- writer ----------------------------------------------------------------------------------------------------------

std::optional<WriteOutcome> wait_for(FrameWriter& writer) {
  for (int i = 0; i < 100; ++i) {
    if (auto outcome = writer.take()) return outcome;
    pollfd entry{writer.fd(), POLLIN, 0};
    poll(&entry, 1, 100);
  }
  return std::nullopt;
}

TEST_F(CaptureStoreTest, TheWriterReportsFilesThatAreWholeInOrder) {
  FrameWriter writer;
  for (int i = 0; i < 5; ++i) {
    writer.put(
        {output_, "frame_" + std::to_string(i) + ".jpg", std::vector<uint8_t>(1000, static_cast<uint8_t>(i)), "{}"});
  }
  for (int i = 0; i < 5; ++i) {
    const auto outcome = wait_for(writer);
    ASSERT_TRUE(outcome);
    EXPECT_EQ(outcome->error, "");
    EXPECT_EQ(outcome->file, "frame_" + std::to_string(i) + ".jpg");
    EXPECT_EQ(read_file(output_ / outcome->file), std::vector<uint8_t>(1000, static_cast<uint8_t>(i)));
  }
  EXPECT_EQ(writer.pending(), 0U);
  EXPECT_TRUE(fs::exists(output_ / "capture.json"));
}

TEST_F(CaptureStoreTest, TheWriterReportsWhatCouldNotBeWritten) {
  FrameWriter writer;
  writer.put({output_ / "missing", "frame_000.jpg", {1, 2, 3}, ""});
  const auto outcome = wait_for(writer);
  ASSERT_TRUE(outcome);
  EXPECT_THAT(outcome->error, HasSubstr("frame_000.jpg"));
}

// --- build child -----------------------------------------------------------------------------------------------------

struct ChildRun {
  BuildEnd end;
  std::vector<BuildProgress> progress;
};

ChildRun run_to_end(BuildChild& child) {
  ChildRun run;
  for (int i = 0; i < 1200; ++i) {
    pollfd entries[] = {{child.end_fd(), POLLIN, 0}, {child.progress_fd(), POLLIN, 0}, {child.error_fd(), POLLIN, 0}};
    poll(entries, 3, 100);
    child.read_errors();
    const auto end = child.end();
    if (auto progress = child.read_progress()) run.progress.push_back(*progress);  // all that it said before its end
    if (end) {
      run.end = *end;
      return run;
    }
  }
  ADD_FAILURE() << "the child does not end";
  return run;
}

TEST_F(CaptureStoreTest, ABuildTellsItsProgressThroughThePipe) {
  BuildChild child({script("echo '0.5 poses' >&3; [ \"$1 $2\" = 'a b' ] || exit 9; echo ignored"), {"a", "b"}, 0, 10});
  const ChildRun run = run_to_end(child);
  EXPECT_TRUE(run.end.ok) << run.end.reason;
  ASSERT_EQ(run.progress.size(), 1U);
  EXPECT_EQ(run.progress[0].fraction, 0.5);
  EXPECT_EQ(run.progress[0].stage, "poses");
}

TEST_F(CaptureStoreTest, ARemarkOfABuildIsNoProgressAndIsTakenOnce) {
  BuildChild child(
      {script("echo '0.5 poses' >&3; echo '1 so far: fair: it is dark' >&3; echo '0.7 layers' >&3"), {}, 0, 10});
  EXPECT_FALSE(child.take_remark());
  const ChildRun run = run_to_end(child);
  EXPECT_EQ(run.progress.back().stage, "layers");
  EXPECT_EQ(child.take_remark(), "fair: it is dark");
  EXPECT_FALSE(child.take_remark());
}

TEST_F(CaptureStoreTest, ABuildThatFailsGivesItsLastLineAsReason) {
  BuildChild child({script("echo first >&2; echo 'ldp build: only 2 frames' >&2; exit 1"), {}, 0, 10});
  const ChildRun run = run_to_end(child);
  EXPECT_FALSE(run.end.ok);
  EXPECT_EQ(run.end.reason, "ldp build: only 2 frames");
}

TEST_F(CaptureStoreTest, ABuildWhoseMachineIsAtFaultCameToNoVerdict) {
  for (const auto& [status, retry] : {std::pair(0, false), {1, false}, {2, true}, {70, false}, {75, true}}) {
    BuildChild build({script("echo 'how it went' >&2; exit " + std::to_string(status)), {}, 0, 10});
    const BuildEnd end = run_to_end(build).end;
    EXPECT_EQ(end.retry, retry) << status;
    EXPECT_EQ(end.reason, status == 0 ? "" : "how it went");
  }
}

TEST_F(CaptureStoreTest, ABuildThatTalksWithoutEndHoldsNobodyUp) {
  BuildChild child({script("yes 0.5 >&3 & exec yes >&2"), {}, 0, 10});
  pollfd entry{child.progress_fd(), POLLIN, 0};
  ASSERT_EQ(::poll(&entry, 1, 60'000), 1);
  EXPECT_TRUE(child.read_progress());
  for (int i = 0; i < 100; ++i) {
    child.read_progress();
    child.read_errors();
    EXPECT_FALSE(child.end());
  }
}

TEST_F(CaptureStoreTest, ABuildThatIsKilledSaysSo) {
  BuildChild child({script("kill -9 $$"), {}, 0, 10});
  EXPECT_THAT(run_to_end(child).end.reason, HasSubstr("Killed"));
}

TEST_F(CaptureStoreTest, AMissingProgramSaysSo) {
  BuildChild child({output_ / "nothing", {}, 0, 10});
  EXPECT_THAT(run_to_end(child).end.reason, HasSubstr("cannot run the build program"));
}

TEST_F(CaptureStoreTest, ABuildBeyondItsMemoryFailsAlone) {
  BuildChild child(
      {script("x=$(head -c 60000000 /dev/zero | tr '\\0' 'a'); echo ${#x}; [ ${#x} -gt 1 ]"), {}, 16 << 20, 10});
  EXPECT_FALSE(run_to_end(child).end.ok);
}

TEST_F(CaptureStoreTest, DroppingABuildKillsIt) {
  const fs::path told = output_ / "pid";
  ASSERT_EQ(::mkfifo(told.c_str(), 0600), 0);
  pid_t pid = 0;
  {
    BuildChild child({script("echo $$ >" + told.string() + "; exec sleep 1000"), {}, 0, 10});
    ASSERT_TRUE(std::ifstream(told) >> pid);
    EXPECT_FALSE(child.end());
  }
  EXPECT_NE(::kill(pid, 0), 0);
}

TEST(BuildProgress, OnlyFractionsCount) {
  EXPECT_EQ(parse_progress("0.25 depth layer 1")->stage, "depth layer 1");
  for (const char* line : {"", "x", "-1 a", "1.5 a", "nan a"}) EXPECT_FALSE(parse_progress(line)) << line;
}

// Pictures wider than a JPEG can be.
class TooWideCamera final : public CameraDevice {
 public:
  std::string name() const override { return "wide"; }
  CameraMode mode() const override { return {PixelFormat::rgb24, kWidth, kHeight, 30, 0}; }
  void start() override {}
  void stop() override {}
  int fd() const override { return -1; }
  bool lock_exposure(bool) override { return true; }
  std::optional<CameraFrame> read() override {
    auto pixels = std::make_shared<std::vector<uint8_t>>(size_t{kWidth} * kHeight * 3);
    for (size_t i = 0; i < pixels->size(); ++i) (*pixels)[i] = static_cast<uint8_t>(i * 2654435761U >> 11);
    CameraFrame frame;
    frame.time_ns = 1 + 33'000'000 * next_;
    frame.sequence = next_++;
    frame.format = PixelFormat::rgb24;
    frame.width = kWidth;
    frame.height = kHeight;
    frame.planes = {{pixels->data(), pixels->size(), kWidth * 3}};
    frame.lease = std::move(pixels);
    return frame;
  }

 private:
  static constexpr int kWidth = 66'000, kHeight = 8;
  int64_t next_ = 0;
};

TEST_F(CaptureStoreTest, AFrameThatCannotBeEncodedIsNotRecorded) {
  {
    FrameWriter writer;
    SweepRun sweep(Config(), std::make_unique<TooWideCamera>(), output_, writer);
    for (int i = 0; i < 3; ++i) sweep.read_frame();
    EXPECT_EQ(sweep.chosen(), 0);
    sweep.end({Why::sweep_complete, {}}, true);
  }
  std::ifstream file(output_ / "capture.json");
  EXPECT_TRUE(nlohmann::json::parse(file).at("frames").empty());
}

TEST(Log, NamesWriteNoControlSequencesOntoTheTerminal) {
  testing::internal::CaptureStderr();
  log_warning("cannot store: \x1b]0;x\a.jpg");
  log_note("kept in a\nb");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "warning: cannot store: \\x1b]0;x\\x07.jpg\nkept in a\\x0ab\n");
}

}  // namespace
}  // namespace ldp
