// The service and its builds, by a stand-in for ldp: shut down in their midst, failed, following the sweep, cancelled.
#include "tests/flow/ldpd.h"

#include <set>

namespace ldp {
namespace {

TEST_F(LdpdTest, ShutDownInMidBuildLeavesItForTheNextStart) {
  build_program("[ -e \"$capture.go\" ] || exec sleep 100");
  Process service(command({}), room_ / "said");
  ASSERT_TRUE(service.says("building sweep_000001"));
  const Finished end = service.stop(SIGTERM);
  EXPECT_EQ(end.status, 0);
  EXPECT_FALSE(fs::exists(panorama()));
  std::ofstream(capture().string() + ".go") << "x";
  script("wait 1");
  Process again(command({}), room_ / "said2");
  EXPECT_TRUE(again.says("sweep_000001.ldp is ready"));
  again.stop(SIGTERM);
}

TEST_F(LdpdTest, AFailedBuildIsNotTriedAgainByItself) {
  build_program("echo broken >&2; exit 1");
  run_once();
  build_program("");
  script("wait 1");
  Process service(command({}), room_ / "said2");
  EXPECT_TRUE(service.says("ready"));
  std::this_thread::sleep_for(milliseconds(300));
  service.stop(SIGTERM);
  EXPECT_FALSE(fs::exists(panorama()));
}

TEST_F(LdpdTest, TheBuildDiesWithTheService) {
  build_program("echo $$ > \"$capture.pid\"; exec sleep 100");
  Process service(command({}), room_ / "said");
  const fs::path pid_file = capture().string() + ".pid";
  ASSERT_TRUE(service.says("building sweep_000001"));
  while (text_of(pid_file).find('\n') == std::string::npos) std::this_thread::sleep_for(milliseconds(5));
  const pid_t build = std::atoi(text_of(pid_file).c_str());
  service.stop(SIGKILL);
  EXPECT_TRUE(is_gone(build));
}

// A stand-in that notes its process and what it is told, outside the capture.
constexpr const char* kNoteLines = "echo $$ $line >> \"$(dirname \"$0\")/told\"";

TEST_F(LdpdTest, TheBuildIsToldOfEveryFrameWhileTheArmMovesAndThenOfTheEnd) {
  build_program("", kNoteLines);
  Process service(command({"--once"}), room_ / "said");
  while (text_of(room_ / "told").find("frame_002.jpg\n") == std::string::npos && service.runs()) {
    std::this_thread::sleep_for(milliseconds(2));
  }
  EXPECT_FALSE(service.says("ended by the button", 0)) << "it was told late";
  const Finished run = service.wait();
  EXPECT_EQ(run.status, 0) << run.said;
  std::istringstream told(text_of(room_ / "told"));
  std::set<int> processes;
  std::vector<std::string> lines;
  int process = 0;
  for (std::string line; told >> process >> line; lines.push_back(line)) processes.insert(process);
  EXPECT_EQ(processes.size(), 1U);
  std::vector<std::string> wanted;
  for (const auto& entry : fs::directory_iterator(capture())) {
    if (entry.path().extension() == ".jpg") wanted.push_back(entry.path().filename().string());
  }
  std::sort(wanted.begin(), wanted.end());
  wanted.emplace_back("end");
  EXPECT_EQ(lines, wanted);
  EXPECT_THAT(text_of(panorama()), HasSubstr(wanted[wanted.size() - 2]));
  EXPECT_FALSE(fs::exists(capture() / "build.json"));
}

TEST_F(LdpdTest, FollowingCanBeSwitchedOff) {
  configure("", "follow = false\n");
  build_program("", kNoteLines);
  EXPECT_EQ(run_once().status, 0);
  EXPECT_TRUE(fs::exists(panorama()));
  EXPECT_FALSE(fs::exists(room_ / "told"));
}

TEST_F(LdpdTest, ABuildThatDiesInMidSweepIsBegunAgainAfterIt) {
  for (const char* const death : {"kill -9 $$", "exit 0", "echo no such photo >&2; exit 2"}) {
    SCOPED_TRACE(death);
    fs::remove_all(room_ / "out");
    fs::remove(room_ / "said");
    build_program("", std::string("[ $line != frame_001.jpg ] || { ") + death + "; }");
    const Finished run = run_once();
    EXPECT_EQ(run.status, 0) << run.said;
    EXPECT_THAT(run.said, HasSubstr("is built after its end"));
    EXPECT_GT(frames_in(capture()), 4);
    EXPECT_FALSE(fs::exists(capture() / "build.json"));
    expect_whole(true);
  }
}

// Cancelled, too short, shut down, killed: no process and no half panorama stays.
TEST_F(LdpdTest, TheBuildThatFollowsEndsWithItsSweep) {
  struct Way {
    const char* name;
    std::string sweep, buttons;
    int signal;
    const char* says = "";
  };
  const Way ways[] = {
      {"cancelled", "mode = \"toggle\"\n", "press wait 3300 release", 0, "its frames were removed"},
      {"too short", "min_frames = 80\n", "press wait " + time_for_all(3000) + " release", 0, "are needed"},
      {"shut down", "", "press wait 60000 release", SIGTERM},
      {"killed", "", "press wait 60000 release", SIGKILL}};
  build_program("", kNoteLines);
  for (const Way& way : ways) {
    SCOPED_TRACE(way.name);
    fs::remove_all(room_ / "out");
    for (const char* const file : {"said", "told"}) fs::remove(room_ / file);
    configure(way.sweep);
    script(way.buttons);
    Process service(command({}), room_ / "said");
    for (int i = 0; i < 4000 && text_of(room_ / "told").find('\n') == std::string::npos; ++i) {
      std::this_thread::sleep_for(milliseconds(5));
    }
    const pid_t follower = std::atoi(text_of(room_ / "told").c_str());
    ASSERT_GT(follower, 0) << text_of(room_ / "said");
    if (way.signal != 0) {
      service.stop(way.signal);
    } else {
      EXPECT_TRUE(service.says(way.says)) << text_of(room_ / "said");
    }
    EXPECT_TRUE(is_gone(follower));
    EXPECT_THAT(text_of(room_ / "told"), Not(HasSubstr("end")));
    EXPECT_FALSE(fs::exists(panorama()));
    EXPECT_TRUE(becomes_empty(room_ / "out" / ".building"));
  }
}

// On a disk that takes its time: the sweep is over, the button stays held until the build to come is cancelled, and the
// next press begins another sweep, all before the first one's frames are on disk.
TEST_F(LdpdTest, ASweepCancelledWhileItIsStoredKeepsItsFramesAndDoesNotMixWithTheNext) {
  configure("mode = \"toggle\"\nmin_frames = 3\n");
  fps_ = "20";
  const std::string sweep = "press wait 10 release wait " + time_for_all(2000) + " press wait ";
  script(sweep + "3300 release " + sweep + "10 release");
  const fs::path gate = room_ / "gate";
  const auto words = with_faults("fsync .jpg * wait " + gate.string(), command({"--status", "console:"}, "&hold=yes"));
  {
    Process service(words, room_ / "said");
    ASSERT_TRUE(service.says("the frames are kept in sweep_000001")) << text_of(room_ / "said");
    EXPECT_EQ(frames_in(capture()), 0);
    for (int i = 0; i < 2000 && !fs::exists(capture(2)); ++i) std::this_thread::sleep_for(milliseconds(5));
    write_file(gate, std::vector<uint8_t>(1));
    ASSERT_TRUE(service.says("is ready")) << text_of(room_ / "said");
    EXPECT_THAT(service.stop(SIGTERM).said, Not(HasSubstr("the build that followed the sweep is over")));
  }
  EXPECT_GT(frames_in(capture(1)), 0);
  EXPECT_EQ(frames_in(capture(2)), reported_stored());
  EXPECT_FALSE(fs::exists(panorama(1)));
  EXPECT_TRUE(fs::exists(panorama(2)));
  script("wait 1");
  Process again(command({}), room_ / "said2");
  EXPECT_TRUE(again.says("ready"));
  EXPECT_THAT(again.stop(SIGTERM).said, Not(HasSubstr("building")));
  expect_whole(true);
}

}  // namespace
}  // namespace ldp
