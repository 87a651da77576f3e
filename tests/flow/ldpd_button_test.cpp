// The service's button: missing, pressed at a bad moment, held to cancel or to switch off. It and the camera are
// simulated, the build is a stand-in.
#include "tests/flow/ldpd.h"

#include <random>

namespace ldp {
namespace {

TEST_F(LdpdTest, WithoutItsButtonItSaysSoAndWaits) {
  std::vector<std::string> words = command({"--status", "console:"});
  fs::remove(room_ / "script");
  Process service(words, room_ / "said");
  ASSERT_TRUE(service.says("the button is missing (script:"));
  script("press wait " + time_for_all(700) + " release");
  EXPECT_TRUE(service.says("sweep_000001.ldp is ready"));
  service.stop(SIGTERM);
}

TEST_F(LdpdTest, ASecondServiceOnTheSameFolderIsRefusedAndTouchesNothing) {
  script("wait 600000");
  Process first(command({"--status", "console:"}), room_ / "said");
  ASSERT_TRUE(first.says("ready"));
  std::ofstream(room_ / "out" / ".building" / "sweep_000009.ldp") << "half a panorama";
  std::ofstream(room_ / "out" / ".a.1.tmp") << "half a file";
  for (const char* const once : {"--once", "--mode=hold"}) {
    fs::remove(room_ / "second");
    Process second(command({once}), room_ / "second");
    ASSERT_TRUE(second.says("ldpd: another ldpd works in " + (room_ / "out").string() + ": stop it", 10));
    EXPECT_EQ(second.wait().status, 1);
  }
  EXPECT_TRUE(fs::exists(room_ / "out" / ".building" / "sweep_000009.ldp"));
  EXPECT_TRUE(fs::exists(room_ / "out" / ".a.1.tmp"));
  EXPECT_EQ(Process(command({"--check-config"}), room_ / "checked").wait().status, 0);
  first.stop(SIGKILL);
  Process third(command({"--status", "console:"}), room_ / "said_by_third");
  EXPECT_TRUE(third.says("ready"));
  EXPECT_FALSE(fs::exists(room_ / "out" / ".a.1.tmp"));
  third.stop(SIGTERM);
}

TEST_F(LdpdTest, APressWhileBuildingIsRefusedAndNothingIsLost) {
  build_program("sleep 0.6");
  const std::string sweep = "press wait " + time_for_all(1500) + " release";
  script(sweep + " wait 200 press wait 50 release wait " + time_for_all(3000) + " " + sweep);
  Process service(command({}), room_ / "said");
  EXPECT_TRUE(service.says("please wait"));
  EXPECT_TRUE(service.says("sweep_000002.ldp is ready"));
  EXPECT_TRUE(service.runs());
  const Finished end = service.stop(SIGTERM);
  EXPECT_EQ(end.status, 0);
  EXPECT_EQ(frames_in(capture(1)), 14);
  EXPECT_EQ(frames_in(capture(2)), 14);
  EXPECT_FALSE(fs::exists(capture(3)));
}

TEST_F(LdpdTest, InToggleModeAHeldButtonCancelsTheSweep) {
  configure("mode = \"toggle\"\nmax_seconds = 20\n");
  script("press wait 3300 release");
  const Finished run = run_once("&hold=yes");
  EXPECT_EQ(run.status, 1);
  EXPECT_THAT(run.said, HasSubstr("cancelled"));
  EXPECT_FALSE(fs::exists(capture()));
}

TEST_F(LdpdTest, AButtonHeldWithoutTurningSwitchesOff) {
  for (const char* const mode : {"hold", "toggle"}) {
    fs::remove_all(room_ / "frames");
    make_frames(1, 200, 150);
    configure_switch_off(mode);
    script("press wait 300000 release");
    const Finished end = Process(command({}, "&hold=yes"), room_ / mode).wait();
    EXPECT_EQ(end.status, 10) << end.said;
    EXPECT_THAT(end.said, HasSubstr("switching off: the button was held"));
    EXPECT_FALSE(fs::exists(capture()));
  }
}

TEST_F(LdpdTest, AButtonHeldForALongSweepSwitchesNothingOff) {
  configure_switch_off("hold");
  script("press wait " + std::to_string(kSanitized ? 40000 : 5500) + " release");
  Process service(command({}, "&hold=yes"), room_ / "said");
  EXPECT_TRUE(service.says("sweep_000001.ldp is ready")) << text_of(room_ / "said");
  EXPECT_EQ(service.stop(SIGTERM).status, 0);
  EXPECT_EQ(frames_in(capture()), 14);
}

TEST_F(LdpdTest, AButtonStillHeldAfterAFullSweepSwitchesNothingOff) {
  build_program("sleep 5");
  configure_switch_off("hold", "max_frames = 4\n");
  script("press wait 300000 release");
  Process service(command({}, "&hold=yes"), room_ / "said");
  EXPECT_TRUE(service.says("sweep_000001.ldp is ready")) << text_of(room_ / "said");
  EXPECT_EQ(service.stop(SIGTERM).status, 0);
}

TEST_F(LdpdTest, WhereNothingIsSeenAHeldButtonIsASweep) {
  fs::remove_all(room_ / "frames");
  fs::create_directories(room_ / "frames");
  std::mt19937 noise(5);
  for (int i = 0; i < 3; ++i) {
    RgbImage dark(200, 150);
    for (int at = 0; at < 200 * 150; ++at) {
      const auto grey = static_cast<uint8_t>(noise() % 12);
      dark.at(at % 200, at / 200) = {grey, grey, grey};
    }
    write_file(room_ / "frames" / ("frame_" + std::to_string(i) + ".jpg"), encode_jpeg(dark, 95));
  }
  configure_switch_off("hold", "min_frames = 3\n");
  script("press wait 5500 release");
  Process service(command({}, "&hold=yes"), room_ / "said");
  EXPECT_TRUE(service.says("the sweep was ended by the button")) << text_of(room_ / "said");
  EXPECT_EQ(service.stop(SIGTERM).status, 0);
}

TEST_F(LdpdTest, ACameraThatTakesLongToOpenIsNoHeldButton) {
  NOT_UNDER_SANITIZERS("between its times lies a second, which they slow down by too much or too little");
  for (const char* const mode : {"hold", "toggle"}) {
    fs::remove_all(room_ / "out");
    configure_switch_off(mode);
    script("press wait 6500 release wait 10 press");
    Process service(with_faults("open frames/frame_000.jpg 1 delay 5000", command({}, "&hold=yes")), room_ / mode);
    EXPECT_TRUE(service.says("sweep_000001.ldp is ready")) << text_of(room_ / mode);
    EXPECT_EQ(service.stop(SIGTERM).status, 0);
  }
}

TEST_F(LdpdTest, SwitchedOffInMidBuildTheNextStartBuildsIt) {
  build_program("[ -e \"$capture.go\" ] || exec sleep 100");
  configure_switch_off("hold");
  script("press wait " + time_for_all(1500) + " release wait 1000 press wait 300000 release");
  const Finished end = Process(command({}), room_ / "said").wait();
  EXPECT_EQ(end.status, 10) << end.said;
  EXPECT_THAT(end.said, HasSubstr("switching off"));
  std::ofstream(capture().string() + ".go") << "x";
  script("wait 1");
  Process again(command({}), room_ / "said2");
  EXPECT_TRUE(again.says("sweep_000001.ldp is ready"));
  again.stop(SIGTERM);
}

TEST_F(LdpdTest, InToggleModeASecondPressEndsTheSweep) {
  configure("mode = \"toggle\"\n");
  script("press wait 50 release wait " + time_for_all(1500) + " press wait 50 release");
  const Finished run = run_once("&hold=yes");
  EXPECT_EQ(run.status, 0) << run.said;
  EXPECT_EQ(frames_in(capture()), 14);
}

}  // namespace
}  // namespace ldp
