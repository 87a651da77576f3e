// `ldp capture`: one sweep into a folder, by the service's own code.
#include "tests/flow/ldpd.h"

namespace ldp {
namespace {

// Of the room's frames, by its script, into its folder "cap".
std::vector<std::string> capture_words(const fs::path& room, const std::vector<std::string>& more = {}) {
  std::vector<std::string> words{LDP_DEVICE_PROGRAM,
                                 "capture",
                                 "--camera",
                                 "folder:" + (room / "frames").string() + "?fps=60",
                                 "--button",
                                 "script:" + (room / "script").string(),
                                 "-o",
                                 (room / "cap").string()};
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

TEST_F(LdpdTest, LdpCaptureWritesACaptureFolderAndNothingElse) {
  const std::vector<std::string> words = capture_words(room_);
  EXPECT_EQ(Process(words, room_ / "said").wait().status, 0);
  EXPECT_EQ(frames_in(room_ / "cap"), 14);
  EXPECT_EQ(std::distance(fs::directory_iterator(room_ / "cap"), fs::directory_iterator()), 15);
  const Finished again = Process(words, room_ / "said").wait();
  EXPECT_EQ(again.status, 2);
  EXPECT_THAT(again.said, HasSubstr("not empty"));
}

TEST_F(LdpdTest, LdpCaptureTakesAsFewFramesAsItIsAskedFor) {
  const Finished run = Process(capture_words(room_, {"--max-frames", "3"}), room_ / "said").wait();
  EXPECT_EQ(run.status, 0) << run.said;
  EXPECT_EQ(frames_in(room_ / "cap"), 3);
}

TEST_F(LdpdTest, LdpCaptureOnAFullDiskAsksForAnotherTime) {
  const auto where = [&](const std::string& faults) {
    return Process(with_faults(faults, capture_words(room_)), room_ / "said").wait();
  };
  for (const char* const faults : {"write .jpg * ENOSPC", "mkdir cap * ENOSPC"}) {
    const Finished full = where(faults);
    EXPECT_EQ(full.status, 75) << full.said;
    EXPECT_THAT(full.said, HasSubstr("No space left on device"));
    EXPECT_FALSE(fs::exists(room_ / "cap"));
  }
  const Finished other = where("write .jpg * ENXIO");
  EXPECT_EQ(other.status, 1) << "in whose words those of a device that is gone are: " << other.said;
  EXPECT_THAT(other.said, HasSubstr("No such device or address"));
}

TEST_F(LdpdTest, LdpCaptureTakesNoFileForAFolderAndNoNameForOne) {
  std::vector<std::string> words{LDP_DEVICE_PROGRAM, "capture",
                                 "--camera",         "folder:" + (room_ / "frames").string(),
                                 "--button",         "script:" + (room_ / "script").string()};
  const Finished unnamed = Process(words, room_ / "unnamed").wait();
  EXPECT_EQ(unnamed.status, 2);
  EXPECT_THAT(unnamed.said, HasSubstr("no output folder is named: add -o DIR"));
  std::ofstream(room_ / "file") << "kept";
  words.insert(words.end(), {"-o", (room_ / "file").string()});
  const Finished file = Process(words, room_ / "said").wait();
  EXPECT_EQ(file.status, 2);
  EXPECT_THAT(file.said, HasSubstr("file: is a file: name a new folder"));
  EXPECT_EQ(text_of(room_ / "file"), "kept");
}

TEST_F(LdpdTest, LdpCaptureTakesAFieldOfViewThatABuildTakes) {
  std::vector<std::string> words = capture_words(room_, {"--fov", "160"});
  const Finished wide = Process(words, room_ / "wide").wait();
  EXPECT_EQ(wide.status, 2);
  EXPECT_THAT(wide.said, HasSubstr("--fov: Value 160 not in range 5.000000 to 150.000000 and is not 0"));
  for (const char* const good : {"0", "5"}) {
    words.back() = good;
    EXPECT_EQ(Process(words, room_ / "said").wait().status, 0) << text_of(room_ / "said");
    fs::remove_all(room_ / "cap");
  }
}

TEST_F(LdpdTest, LdpCaptureLeavesNothingWhereNoFrameWasKept) {
  const std::string frames = "folder:" + (room_ / "frames").string() + "?fps=60",
                    button = "script:" + (room_ / "script").string();
  struct Attempt {
    std::string camera, button;
    int status;
    const char* said;
  };
  const Attempt attempts[] = {
      {"v4l2:" + (room_ / "nowhere").string(), button, 2, "nowhere"},
      {"folder:" + (room_ / "nowhere").string(), button, 2, "nowhere"},
      {frames, "script:" + (room_ / "no_script").string(), 2, "no_script"},
      {"folder:" + (room_ / "nowhere").string(), "script:" + (room_ / "no_script").string(), 2, "no_script"},
      {"scene:nope", button, 2, "no scene of that name"},
      {frames + "&lost_after=0", button, 1, "unplugged"},
  };
  fs::create_directory(room_ / "empty");
  for (const Attempt& attempt : attempts) {
    for (const char* const folder : {"new/cap", "empty"}) {
      fs::remove(room_ / "said");
      const Finished run = Process({LDP_DEVICE_PROGRAM, "capture", "--camera", attempt.camera, "--button",
                                    attempt.button, "-o", (room_ / folder).string()},
                                   room_ / "said")
                               .wait();
      EXPECT_EQ(run.status, attempt.status) << run.said;
      EXPECT_THAT(run.said, HasSubstr(attempt.said));
      EXPECT_FALSE(fs::exists(room_ / "new")) << attempt.said;
      EXPECT_TRUE(fs::is_empty(room_ / "empty")) << attempt.said;
    }
  }
  script("wait 600000");
  Process waiting({LDP_DEVICE_PROGRAM, "capture", "--camera", frames, "--button", button, "--status", "console:", "-o",
                   (room_ / "new").string()},
                  room_ / "interrupted");
  ASSERT_TRUE(waiting.says("ready"));
  EXPECT_EQ(waiting.stop(SIGINT).status, 130);
  EXPECT_FALSE(fs::exists(room_ / "new"));
}

}  // namespace
}  // namespace ldp
