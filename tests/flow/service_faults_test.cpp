// What the service and `ldp capture` do when the system refuses, hangs or goes away under them. Calls fail by faults.c.
#include "ldpd.h"

namespace ldp {
namespace {

// The disk takes its time for every photo; Ctrl-C comes when some are chosen and not yet stored.
TEST_F(LdpdTest, TheFirstInterruptionOfLdpCaptureStoresWhatWasTakenAndTheSecondLeavesAtOnce) {
  script("press wait 600000 release");
  const auto slowed = [&](const std::string& rules, const std::string& folder) {
    return with_faults(
        rules,
        {LDP_DEVICE_PROGRAM, "capture", "--camera", "folder:" + (room_ / "frames").string() + "?fps=100", "--button",
         "script:" + (room_ / "script").string(), "--status", "console:", "-o", (room_ / folder).string()});
  };
  {
    Process first(slowed("fsync .jpg * delay 80", "one"), room_ / "said");
    ASSERT_TRUE(first.says("stored: 2 frames")) << text_of(room_ / "said");
    const Finished end = first.stop(SIGINT);
    EXPECT_EQ(end.status, 130) << end.said;
    EXPECT_EQ(frames_in(room_ / "one"), 14) << end.said;
    EXPECT_THAT(end.said, HasSubstr("interrupted: storing what was taken"));
    EXPECT_THAT(end.said, HasSubstr("the sweep is kept in " + (room_ / "one").string() + " (14 frames)"));
    EXPECT_THAT(text_of(room_ / "one" / "capture.json"), HasSubstr("frame_013.jpg"));
    EXPECT_THAT(text_of(room_ / "one" / "capture.json"), HasSubstr("\"complete\": false"));
    EXPECT_EQ(std::distance(fs::directory_iterator(room_ / "one"), fs::directory_iterator()), 15);
  }
  fs::remove(room_ / "said");
  Process second(slowed("fsync .jpg 4+ wait " + (room_ / "never").string(), "two"), room_ / "said");
  ASSERT_TRUE(second.says("stored: 3 frames")) << text_of(room_ / "said");
  kill(second.pid(), SIGINT);
  ASSERT_TRUE(second.says("interrupted: storing")) << text_of(room_ / "said");
  const auto begin = Clock::now();
  EXPECT_EQ(second.stop(SIGINT).status, 130);
  EXPECT_LT(Clock::now() - begin, milliseconds(2000));
  EXPECT_EQ(frames_in(room_ / "two"), 3);
  for (const auto& entry : fs::directory_iterator(room_ / "two")) EXPECT_NE(entry.path().extension(), ".tmp");
}

}  // namespace
}  // namespace ldp
