// The service as a whole, as a process: simulated camera and button, a stand-in for the build, and everything that can
// go wrong on the way. toolchain/kills runs the long form of the kill tests.
#include "tests/flow/ldpd.h"

#include <lcm/lcm-cpp.hpp>
#include <random>
#include <set>

#include "device/backends/open.h"
#include "drivers/interface/status.h"
#include "tests/private_network.h"

namespace ldp {
namespace {

TEST_F(LdpdTest, OneSweepBecomesAPanorama) {
  const Finished run = run_once();
  EXPECT_EQ(run.status, 0) << run.said;
  EXPECT_EQ(frames_in(capture()), 14) << run.said;
  EXPECT_THAT(text_of(panorama()), HasSubstr("frame_013.jpg"));
  EXPECT_THAT(text_of(capture() / "capture.json"), HasSubstr("\"complete\": true"));
  EXPECT_FALSE(fs::exists(capture() / "build.json"));
  expect_whole(true);
}

TEST_F(LdpdTest, AFailedBuildKeepsTheFramesAndTheReason) {
  build_program("echo 'ldp build: no parallax' >&2; exit 1");
  const Finished run = run_once();
  EXPECT_EQ(run.status, 1);
  EXPECT_THAT(run.said, HasSubstr("no parallax"));
  EXPECT_EQ(frames_in(capture()), 14);
  EXPECT_THAT(text_of(capture() / "build.json"), HasSubstr("no parallax"));
  EXPECT_FALSE(fs::exists(panorama()));
}

TEST_F(LdpdTest, AFileThatCannotBeWrittenIsToldByTheNameItWouldHaveHad) {
  build_program("echo \"ldp build: cannot write $file: No space left on device\" >&2; exit 1");
  const Finished run = run_once();
  const std::string reason = "ldp build: cannot write " + panorama().string() + ": No space left on device";
  EXPECT_THAT(run.said, HasSubstr("failed: " + reason));
  EXPECT_THAT(text_of(capture() / "build.json"), HasSubstr(reason));
}

TEST_F(LdpdTest, ACrashOfTheBuildIsAFailureWithItsReason) {
  build_program("kill -SEGV $$");
  const Finished run = run_once();
  EXPECT_EQ(run.status, 1);
  EXPECT_THAT(run.said, HasSubstr("Segmentation fault"));
}

TEST_F(LdpdTest, AnUnpluggedCameraBuildsWhatWasTaken) {
  const Finished run = run_once("&lost_after=8");
  EXPECT_EQ(run.status, 0) << run.said;
  EXPECT_THAT(run.said, HasSubstr("unplugged"));
  EXPECT_EQ(frames_in(capture()), 8);
  EXPECT_TRUE(fs::exists(panorama()));
}

TEST_F(LdpdTest, ASilentCameraCountsAsLost) {
  configure(kSanitized ? "lost_after_seconds = 5\n" : "lost_after_seconds = 0.3\n");
  script("press wait 60000 release");
  const Finished run = run_once("&stall_after=6");
  EXPECT_EQ(run.status, 0) << run.said;
  EXPECT_THAT(run.said, HasSubstr("no more frames"));
}

TEST_F(LdpdTest, ACameraFasterThanItsFramesCanBeLookedAtDoesNotKeepTheButtonWaiting) {
  fs::remove_all(room_ / "frames");
  make_frames(5, 480, 360);
  script("press wait " + time_for_all(700) + " release");
  std::vector<std::string> words = command({"--once"});
  words[4] = "folder:" + (room_ / "frames").string() + "?fps=1000";
  const Finished run = Process(words, room_ / "said").wait();
  EXPECT_EQ(run.status, 0);
  EXPECT_THAT(run.said, HasSubstr("ended by the button"));
}

TEST_F(LdpdTest, ATooShortSweepSaysWhatToDo) {
  script("press wait 40 release");
  const Finished run = run_once();
  EXPECT_EQ(run.status, 1);
  EXPECT_THAT(run.said, HasSubstr("at least 4 are needed: the sweep lasted 0."));
  EXPECT_THAT(run.said, HasSubstr("degrees: hold the button while you turn slowly"));
}

TEST_F(LdpdTest, InToggleModeATooShortSweepWasPressedTwice) {
  configure("mode = \"toggle\"\n");
  script("press release wait 40 press");
  EXPECT_THAT(run_once().said, HasSubstr("degrees: press, turn slowly through at least a quarter circle, press again"));
}

TEST_F(LdpdTest, ASweepThatTheCameraCutShortIsNotBlamedOnTheButton) {
  const Finished run = run_once("&lost_after=2");
  EXPECT_EQ(run.status, 1);
  EXPECT_THAT(run.said, HasSubstr("at least 4 are needed: the simulated camera was unplugged"));
}

TEST_F(LdpdTest, ASignalInMidSweepIsNotTakenForTheButton) {
  script("press wait 60000 release");
  Process service(command({"--once"}), room_ / "said");
  ASSERT_TRUE(service.says("stored: 2"));
  const Finished end = service.stop(SIGINT);
  EXPECT_EQ(end.status, 1);
  EXPECT_THAT(end.said, HasSubstr("shutting down"));
  EXPECT_THAT(end.said, Not(HasSubstr("button")));
  EXPECT_THAT(text_of(capture() / "capture.json"), HasSubstr("\"end_reason\": \"shutting down\""));
}

TEST_F(LdpdTest, AnInterruptedSingleRunTellsWhatIsKept) {
  const auto interrupt = [&](const std::string& when, const std::string& log, const std::string& camera = "") {
    Process service(command({"--once"}, camera), room_ / log);
    EXPECT_TRUE(service.says(when)) << log;
    const Finished end = service.stop(SIGINT);
    EXPECT_EQ(end.status, 1) << log;
    EXPECT_THAT(end.said, HasSubstr("stopped before a panorama was made; ")) << log;
    return end.said;
  };
  const auto kept = [&](int number) {
    return "the sweep is kept in " + capture(number).string() + " (" + std::to_string(frames_in(capture(number))) +
           " frames)\n";
  };
  script("wait 600000");
  EXPECT_THAT(interrupt("ready", "idle"), HasSubstr("made; nothing was kept\n"));
  script("press wait 600000 release");
  EXPECT_THAT(interrupt("capturing", "nothing", "&stall_after=0"), HasSubstr("made; nothing was kept\n"));
  EXPECT_FALSE(fs::exists(capture(1)));
  const std::string in_sweep = interrupt("stored: 2", "in_sweep");
  EXPECT_THAT(in_sweep, HasSubstr(kept(2)));
  EXPECT_GE(frames_in(capture(2)), 2);
  build_program("echo '0.5 poses' >&3; sleep 600");
  const std::string in_build = interrupt("building sweep_000003: poses", "in_build", "&hold=no");
  EXPECT_THAT(in_build, HasSubstr(kept(3)));
  EXPECT_GE(frames_in(capture(3)), 4);
}

TEST_F(LdpdTest, AServiceStoppedInABuildOfAnEarlierSweepKeepsIt) {
  script("press wait 600000 release");
  build_program("echo '0.5 poses' >&3; sleep 600");
  for (const char* const log : {"first", "second"}) {
    if (log == std::string("second")) script("wait 600000");
    Process service(command({"--status", "console:"}, "&hold=no"), room_ / log);
    EXPECT_TRUE(service.says("building sweep_000001: poses"));
    EXPECT_THAT(service.stop(SIGTERM).said, Not(HasSubstr("stopped before")));
    EXPECT_GE(frames_in(capture()), 4);
  }
}

TEST_F(LdpdTest, AKeyboardKnowsPressesOnly) {
  std::vector<std::string> words = command({"--mode", "hold"});
  words[6] = "keyboard:";
  const Finished held = Process(words, room_ / "said").wait();
  EXPECT_EQ(held.status, 2);
  EXPECT_THAT(held.said, HasSubstr("--mode: a terminal does not tell when a key is let go"));
  words.resize(words.size() - 2);
  words.emplace_back("--print-config");
  const Finished unsaid = Process(words, room_ / "said").wait();
  EXPECT_EQ(unsaid.status, 0) << unsaid.said;
  std::ofstream(room_ / "ldpd.toml") << "button = \"keyboard:\"\n[sweep]\nmode = \"hold\"\n";
  const Finished file =
      Process({LDPD_PROGRAM, "--config", (room_ / "ldpd.toml").string(), "--check-config"}, room_ / "said").wait();
  EXPECT_EQ(file.status, 78);
  EXPECT_THAT(file.said, HasSubstr("ldpd.toml:3: sweep.mode: a terminal"));
}

TEST_F(LdpdTest, AConfigurationThatCannotBePrintedAsksForAnotherTime) {
  const Finished run = Process({LDPD_PROGRAM, "--print-config"}, room_ / "said", [] {
                         if (!freopen("/dev/full", "w", stdout)) _exit(126);
                       }).wait();
  EXPECT_EQ(run.status, 75);
  EXPECT_EQ(run.said, "ldpd: cannot write the configuration: No space left on device\n");
}

TEST_F(LdpdTest, TellsItsVersion) { EXPECT_EQ(Process({LDPD_PROGRAM, "--version"}, room_ / "said").wait().status, 0); }

TEST_F(LdpdTest, AMissingCameraIsNamed) {
  std::vector<std::string> words = command({"--once"});
  words[4] = "folder:" + (room_ / "nowhere").string();
  const Finished run = Process(words, room_ / "said").wait();
  EXPECT_EQ(run.status, 1);
  EXPECT_THAT(run.said, HasSubstr("nowhere"));
}

TEST_F(LdpdTest, AFullDiskRefusesTheSweepInSweepsLeft) {
  configure("reserve_mib = 1000000\n");
  const Finished run = run_once();
  EXPECT_EQ(run.status, 1);
  EXPECT_THAT(run.said, HasSubstr("0 sweeps left"));
}

TEST_F(LdpdTest, BadConfigurationIsExitStatus78WithTheLine) {
  std::ofstream(room_ / "ldpd.toml") << "camera = 7\n";
  const Finished run = run_once();
  EXPECT_EQ(run.status, 78);
  EXPECT_THAT(run.said, HasSubstr("ldpd.toml:1: camera"));
}

TEST_F(LdpdTest, AnUnknownKindOfDeviceIsRefusedAtOnce) {
  std::vector<std::string> words = command({});
  words[6] = "switch:1";
  const Finished run = Process(words, room_ / "said").wait();
  EXPECT_EQ(run.status, 2);
  EXPECT_THAT(run.said, HasSubstr("--button: 'switch:1': no button of that kind; known: gpiod:, script:, keyboard:"));
}

TEST_F(LdpdTest, EmptyNamesAreRefusedAndDoNotMeanTheDefaults) {
  const auto refused = [&](const std::string& option) {
    return Process({LDPD_PROGRAM, "--check-config", option, ""}, room_ / ("said" + option)).wait();
  };
  for (const char* const option : {"--camera", "--button", "--status", "--output"}) {
    const Finished run = refused(option);
    EXPECT_EQ(run.status, 2) << option;
    EXPECT_THAT(run.said, HasSubstr(std::string(option) + ": "));
  }
  EXPECT_EQ(refused("--config").status, 78);
}

TEST_F(LdpdTest, TheCheckNamesAMissingFolderAndAMissingScript) {
  fs::remove(room_ / "script");
  const Finished told = Process(command({"--check-config"}), room_ / "told").wait();
  EXPECT_EQ(told.status, 2);
  EXPECT_THAT(told.said, HasSubstr("--button: 'script:" + (room_ / "script").string() + "': there is no file"));
  std::ofstream(room_ / "ldpd.toml", std::ios::trunc) << "\ncamera = 'folder:/nowhere'\n";
  const Finished read =
      Process({LDPD_PROGRAM, "--config", (room_ / "ldpd.toml").string(), "--check-config"}, room_ / "read").wait();
  EXPECT_EQ(read.status, 78);
  EXPECT_THAT(read.said, HasSubstr("ldpd.toml:2: camera: 'folder:/nowhere': there is no folder '/nowhere'"));
}

TEST_F(LdpdTest, WithoutAnLdpBesideItAProgramHasToBeNamed) {
  const fs::path alone = room_ / "alone";
  fs::copy_file(LDPD_PROGRAM, alone);
  std::vector<std::string> words{alone.string(), "--check-config", "--output", room_.string()};
  const Finished run = Process(words, room_ / "said").wait();
  EXPECT_EQ(run.status, 78);
  EXPECT_THAT(run.said, HasSubstr("there is no " + (room_ / "ldp").string() + ": install ldp there, or name"));
  EXPECT_EQ(Process({alone.string(), "--print-config"}, room_ / "said").wait().status, 0);
  std::ofstream(room_ / "ldpd.toml") << "[build]\nprogram = '" << LDPD_PROGRAM << "'\n";
  words.insert(words.end(), {"--config", (room_ / "ldpd.toml").string()});
  EXPECT_EQ(Process(words, room_ / "said").wait().status, 0);
}

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
    build_program("", std::string("[ $line != frame_003.jpg ] || { ") + death + "; }");
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

// After a kill at any moment: what was reported stored is there and whole, and the next start builds it.
TEST_F(LdpdTest, KilledAtAnyMomentNothingStoredIsLostAndTheNextStartBuildsIt) {
  build_program("sleep 0.15");
  configure("min_frames = 3\n");
  std::mt19937 random(
      static_cast<unsigned>(std::getenv("LDP_KILL_SEED") ? std::atoi(std::getenv("LDP_KILL_SEED")) : 1));
  for (int i = 0; i < kills(); ++i) {
    SCOPED_TRACE("kill " + std::to_string(i));
    fs::remove_all(room_ / "out");
    fs::remove(room_ / "said");
    fs::remove(room_ / "said2");
    script("press wait 400 release");
    int stored = 0;
    {
      Process service(command({"--status", "console:"}), room_ / "said");
      std::this_thread::sleep_for(std::chrono::microseconds(random() % 900'000));
      service.stop(SIGKILL);
    }
    if (!fs::exists(capture())) continue;  // killed before the press
    stored = frames_in(capture());
    EXPECT_GE(stored, reported_stored());
    expect_whole(false);
    script("wait 1");
    Process again(command({"--status", "console:"}), room_ / "said2");
    ASSERT_TRUE(again.says("ready"));
    if (stored >= 3 && !fs::exists(panorama())) {
      EXPECT_TRUE(again.says("sweep_000001.ldp is ready", 20)) << text_of(room_ / "said2");
    }
    again.stop(SIGTERM);
    EXPECT_EQ(frames_in(capture()), stored);
    EXPECT_EQ(fs::exists(panorama()), stored >= 3);
    expect_whole(true);
  }
}

TEST_F(LdpdTest, ABuildKilledAtAnyMomentIsAFailureAndTheServiceGoesOn) {
  // It works until it is killed, however late that comes; the next one ends.
  build_program("echo $$ > \"$capture.pid\"; echo '0.2 poses' >&3; [ -e \"$capture.killed\" ] || exec sleep 600");
  script(kUntilTheCameraEnds);
  std::mt19937 random(2);
  for (int i = 0; i < (kills() > 10 ? kills() : 2); ++i) {
    SCOPED_TRACE("kill " + std::to_string(i));
    fs::remove_all(room_ / "out");
    fs::remove(room_ / "said");
    Process service(command({}, "&hold=no"), room_ / "said");
    const fs::path pid_file = capture().string() + ".pid";
    ASSERT_TRUE(service.says("building sweep_000001")) << text_of(room_ / "said");
    while (text_of(pid_file).find('\n') == std::string::npos) std::this_thread::sleep_for(milliseconds(2));
    const int stored = frames_in(capture());
    std::this_thread::sleep_for(std::chrono::microseconds(random() % 280'000));
    kill(std::atoi(text_of(pid_file).c_str()), SIGKILL);
    EXPECT_TRUE(service.says("failed: the build was killed"));
    EXPECT_TRUE(service.runs());
    service.stop(SIGTERM);
    EXPECT_EQ(frames_in(capture()), stored);
    EXPECT_FALSE(fs::exists(panorama()));
    EXPECT_TRUE(fs::is_empty(room_ / "out" / ".building"));
    std::ofstream(capture().string() + ".killed") << "\n";
    fs::remove(room_ / "said2");
    script("wait 1");
    Process again(command({}), room_ / "said2");
    EXPECT_TRUE(again.says("sweep_000001.ldp is ready")) << "the next start does not try again";
    again.stop(SIGTERM);
    expect_whole(true);
    script(kUntilTheCameraEnds);
  }
}

// The same with ldp itself: killed at any moment of its work it leaves nothing behind, and the panorama that a later
// start builds is, byte by byte, that of a build in peace.
TEST_F(LdpdTest, LdpKilledAtAnyMomentOfItsBuildIsBegunAgainByTheNextStart) {
  fs::create_directories(room_ / "out");
  const int frames = photograph_garden(capture());
  ASSERT_GT(frames, 3) << text_of(room_ / "captured");
  configure_ldp();
  script("wait 1");
  const auto build_in_peace = [&] {
    fs::remove(room_ / "said");
    Process service(command({}), room_ / "said");
    ASSERT_TRUE(service.says("building sweep_000001"));
    ASSERT_TRUE(service.says("sweep_000001.ldp is ready", 300)) << text_of(room_ / "said");
    service.stop(SIGTERM);
  };
  const auto begin = Clock::now();
  build_in_peace();
  const auto build_us = std::chrono::duration_cast<std::chrono::microseconds>(Clock::now() - begin).count();
  const std::vector<uint8_t> wanted = read_file(panorama());
  std::mt19937 random(4);
  int killed = 0;
  for (int i = 0; i < (kills() > 10 ? kills() : 2); ++i) {
    SCOPED_TRACE("kill " + std::to_string(i));
    for (const fs::path& file : {panorama(), capture() / "build.json", room_ / "said"}) fs::remove(file);
    Process service(command({}), room_ / "said");
    ASSERT_TRUE(service.says("building sweep_000001")) << text_of(room_ / "said");
    const auto ended = [&] {
      return service.says("done: ", 0) || service.says("failed: the build was killed", 0) || !service.runs();
    };
    if (i > 0) {  // the first is killed at once
      std::this_thread::sleep_for(std::chrono::microseconds(random() % static_cast<uint64_t>(build_us)));
    }
    while (!ended() && !service.kill_child()) std::this_thread::sleep_for(milliseconds(1));
    while (!ended()) std::this_thread::sleep_for(milliseconds(5));
    EXPECT_TRUE(service.runs());
    service.stop(SIGTERM);
    EXPECT_EQ(frames_in(capture()), frames);
    EXPECT_TRUE(fs::is_empty(room_ / "out" / ".building"));
    killed += fs::exists(panorama()) ? 0 : 1;
  }
  EXPECT_GE(killed, 1);
  fs::remove(panorama());
  build_in_peace();
  EXPECT_EQ(read_file(panorama()), wanted);
  EXPECT_FALSE(fs::exists(capture() / "build.json"));
}

// ldp follows the sweep; killed at any moment of sweep and build, the panorama is in the end, byte by byte, that of a
// build of the finished folder.
TEST_F(LdpdTest, WhetherLdpFollowsTheSweepOrIsKilledAtItChangesNoByte) {
  fs::remove_all(room_ / "frames");
  const int frames = photograph_garden(room_ / "frames");
  ASSERT_GT(frames, 3) << text_of(room_ / "captured");
  configure_ldp();
  std::vector<std::string> words = command({});
  words[4] = "folder:" + (room_ / "frames").string() + "?fps=25&hold=no";
  int killed_in_sweep = 0, killed_in_build = 0;
  std::mt19937 random(5);
  const int rounds = kills() > 10 ? kills() : 1;
  int64_t whole_us = 0;
  for (int i = 0; i <= rounds; ++i) {
    SCOPED_TRACE("kill " + std::to_string(i));
    fs::remove_all(room_ / "out");
    fs::remove(room_ / "said");
    script(kUntilTheCameraEnds);
    const auto begin = Clock::now();
    Process service(words, room_ / "said");
    ASSERT_TRUE(service.says("capturing"));
    const auto ended = [&] { return service.says("is ready", 0) || service.says("failed: ", 0) || !service.runs(); };
    // The first is left in peace, the second loses its child when that has begun to follow, the others at any moment.
    if (i == 1) {
      while (!ended() && (frames_in(capture()) < 2 || !service.kill_child())) {
        std::this_thread::sleep_for(milliseconds(1));
      }
    } else if (i > 1) {
      std::this_thread::sleep_for(std::chrono::microseconds(random() % static_cast<uint64_t>(whole_us)));
      service.kill_child();
    }
    while (!ended()) std::this_thread::sleep_for(milliseconds(5));
    if (i == 0) whole_us = std::chrono::duration_cast<std::chrono::microseconds>(Clock::now() - begin).count();
    const bool failed = service.says("failed: the build was killed", 0);
    killed_in_build += failed ? 1 : 0;
    killed_in_sweep += service.says("is built after its end", 0) ? 1 : 0;
    service.stop(SIGTERM);
    EXPECT_GE(frames_in(capture()), reported_stored());
    if (failed) {
      script("wait 1");
      fs::remove(room_ / "said");
      Process again(words, room_ / "said");
      EXPECT_TRUE(again.says("is ready")) << text_of(room_ / "said");
      again.stop(SIGTERM);
    }
    std::vector<std::string> plain{fs::path(LDPD_PROGRAM).replace_filename("ldp").string(), "build", capture().string(),
                                   "-o", (room_ / "plain.ldp").string()};
    plain.insert(plain.end(), kQuick.begin(), kQuick.end());
    ASSERT_EQ(Process(plain, room_ / "plain").wait().status, 0) << text_of(room_ / "plain");
    EXPECT_TRUE(read_file(panorama()) == read_file(room_ / "plain.ldp"));
    EXPECT_TRUE(fs::is_empty(room_ / "out" / ".building"));
    if (i == 0) {
      EXPECT_EQ(killed_in_sweep, 0) << text_of(room_ / "said");
    }
  }
  RecordProperty("killed_in_sweep", killed_in_sweep);
  RecordProperty("killed_in_build", killed_in_build);
  EXPECT_GE(killed_in_sweep + killed_in_build, 1);
}

// A small disk of its own, which is filled up but for so many KiB once the sweep has begun: every write in turn, of
// frames, records and the panorama, is the first that does not fit. Then there is room again, and the next start
// builds.
TEST_F(LdpdTest, ADiskThatFillsUpKeepsEveryFrameThatWasStored) {
  configure("reserve_mib = 0\nmin_frames = 3\n");
  fs::create_directories(room_ / "out");
  const std::string out = (room_ / "out").string(), copy = (room_ / "copy").string();
  const auto run = [&](const std::vector<std::string>& words) {
    std::string line;
    for (const std::string& word : words) line += "'" + word + "' ";
    return line;
  };
  int without_room = 0, built_later = 0;
  const auto fill_up_at_each_write = [&] {
    for (int left_kib = 0; left_kib <= 240; left_kib += kills() >= 100 ? 4 : 40) {
      SCOPED_TRACE(left_kib);
      for (const char* const said : {"said", "said2"}) fs::remove(room_ / said);
      script(kUntilTheCameraEnds);
      const std::string filler = "(until [ -e " + out +
                                 "/sweep_000001 ]; do sleep 0.002; done; head -c $(($(df -k --output=avail " + out +
                                 " | tail -1) - " + std::to_string(left_kib) + "))K /dev/zero > " + out + "/filler) & ";
      // The second run ends when there is nothing left to build.
      const std::string wait_for_build = "if [ $(ls " + out + "/sweep_000001 | grep -c jpg) -ge 3 ] && [ ! -e " + out +
                                         "/sweep_000001.ldp ]; then until [ -e " + out +
                                         "/sweep_000001.ldp ] || [ $((tries++)) = 3000 ]; do sleep 0.01; done; fi; ";
      const std::string said2 = (room_ / "said2").string();
      const std::string line = "mount -t tmpfs -o size=32m none " + out + " || exit 99; " + filler +
                               run(command({"--once", "--status", "console:"}, "&hold=no")) + "; status=$?; rm -f " +
                               out + "/filler; echo 'wait 1' > " + (room_ / "script").string() + "; " +
                               run(command({})) + " 2> " + said2 + " & service=$!; until grep -q ready " + said2 +
                               " || ! kill -0 $service" + "; do sleep 0.01; done; " + wait_for_build +
                               "kill $service; wait $service; cp -r " + out + " " + copy + "; exit $status";
      const Finished first = Process({"unshare", "-rm", "bash", "-c", line}, room_ / "said").wait();
      if (first.status == 99 || first.status == 127 || first.said.find("unshare") != std::string::npos) {
        GTEST_SKIP() << "no small disk can be mounted here: " << first.said;
      }
      if (first.status != 0) {
        ++without_room;
        EXPECT_THAT(first.said, HasSubstr("No space left on device"));
      }
      fs::remove_all(room_ / "out");
      fs::rename(copy, room_ / "out");
      const int frames = frames_in(capture());
      EXPECT_GE(frames, reported_stored()) << first.said;
      EXPECT_EQ(fs::exists(panorama()), frames >= 3) << first.said << text_of(room_ / "said2");
      if (first.status != 0 && fs::exists(panorama())) ++built_later;
      expect_whole(true);
      fs::remove_all(room_ / "out");
      fs::create_directories(room_ / "out");
    }
  };
  // On a busy machine the filler comes too late for a fast camera.
  for (const char* const fps : {"60", "6", "1"}) {
    fps_ = fps;
    without_room = built_later = 0;
    fill_up_at_each_write();
    if (IsSkipped() || HasFailure() || without_room >= 3) break;
  }
  EXPECT_GE(without_room, 3);
  EXPECT_GE(built_later, 1);
}

TEST_F(LdpdTest, TheMessagesOfASweepPassOverLcm) {
  const std::string url = "lcm:" + private_network();
  std::unique_ptr<StatusListener> listener;
  try {
    listener = open_status_listener(url);
  } catch (const std::exception& error) {
    GTEST_SKIP() << error.what();
  }
  Process service(command({"--once", "--status", url}), room_ / "said");
  EXPECT_EQ(service.wait().status, 0);
  std::vector<int> kinds(4, 0);
  while (const auto heard = listener->read()) ++kinds[heard->message.index()];
  if (kinds == std::vector<int>(4, 0)) GTEST_SKIP() << "multicast does not come back here";
  EXPECT_GT(kinds[0], 3);
  EXPECT_EQ(kinds[1], 1);
  EXPECT_GT(kinds[2], 0);
  EXPECT_EQ(kinds[3], 1);
}

TEST_F(LdpdTest, ARecordedSessionReplaysThroughLdpWatch) {
  const std::string url = private_network();
  std::unique_ptr<StatusListener> listener;
  try {
    listener = open_status_listener("lcm:" + url);
  } catch (const std::exception& error) {
    GTEST_SKIP() << error.what();
  }
  const fs::path log = room_ / "session.log";
  {
    Process logger({"lcm-logger", "--lcm-url=" + url, "--flush-interval=10", log.string()}, room_ / "logger");
    // Its file appears when it has seen something.
    for (int i = 0; i < 200 && (!fs::exists(log) || fs::file_size(log) == 0); ++i) {
      listener->send(Command::release);
      std::this_thread::sleep_for(milliseconds(20));
    }
    if (!fs::exists(log) || fs::file_size(log) == 0)
      GTEST_SKIP() << "no lcm-logger, or multicast does not come back here";
    Process service(command({"--once", "--status", "lcm:" + url}), room_ / "said");
    EXPECT_EQ(service.wait().status, 0);
    std::this_thread::sleep_for(milliseconds(100));
    logger.stop(SIGINT);
  }
  std::vector<std::string> heard;
  while (const auto message = listener->read())
    heard.push_back("\"monotonic_ns\":" + std::to_string(message->monotonic_ns));
  const std::string watch = std::string(LDP_DEVICE_PROGRAM) + " watch --json --status 'lcm:file://" + log.string() +
                            "?speed=0' > " + (room_ / "replayed").string();
  EXPECT_EQ(Process({"bash", "-c", watch}, room_ / "watch").wait().status, 0) << text_of(room_ / "watch");
  const std::string replayed = text_of(room_ / "replayed");
  EXPECT_GT(heard.size(), 5U);
  for (const std::string& message : heard) EXPECT_THAT(replayed, HasSubstr(message));
  EXPECT_EQ(static_cast<size_t>(std::count(replayed.begin(), replayed.end(), '\n')), heard.size());
  for (const char* const type : {"status", "progress", "guidance", "result"}) {
    EXPECT_THAT(replayed, HasSubstr("\"type\":\"" + std::string(type) + "\""));
  }
}

// One message a line, as many as were asked for; a log that is at its end before that ends it, too.
TEST_F(LdpdTest, LdpWatchEndsAfterAsManyMessagesAsWereAskedFor) {
  const std::string url = private_network();
  lcm::LCM stranger(url);
  if (!stranger.good()) GTEST_SKIP() << "no multicast here (ip route add 224.0.0.0/4 dev lo)";
  const auto publisher = open_status("lcm:" + url);
  for (const int count : {1, 3}) {
    const fs::path printed = room_ / ("printed_" + std::to_string(count));
    const std::string watch = std::string("exec ") + LDP_DEVICE_PROGRAM + " watch --status 'lcm:" + url + "' --count " +
                              std::to_string(count) + " > " + printed.string();
    Process watching({"bash", "-c", watch}, room_ / "watch");
    Status status;
    for (int i = 0; i < 500 && watching.runs(); ++i) {
      status.text = "message " + std::to_string(i);
      publisher->publish(status);
      std::this_thread::sleep_for(milliseconds(10));
    }
    if (watching.runs()) GTEST_SKIP() << "multicast does not come back here";
    EXPECT_EQ(watching.wait().status, 0);
    const std::string lines = text_of(printed);
    EXPECT_EQ(std::count(lines.begin(), lines.end(), '\n'), count) << lines;
    EXPECT_THAT(lines, HasSubstr("message "));
  }
}

// Noise on every channel, commands among them: the service and who watches it count it and go on as if nothing had
// been.
TEST_F(LdpdTest, AHundredThousandRandomDatagramsOnEveryChannelChangeNothingButACounter) {
  const std::string url = private_network();
  lcm::LCM stranger(url);
  if (!stranger.good()) GTEST_SKIP() << "no multicast here (ip route add 224.0.0.0/4 dev lo)";
  script("wait 1");
  Process service(command({"--status", "lcm:" + url, "--status", "console:"}), room_ / "said");
  ASSERT_TRUE(service.says("ready"));
  const auto watcher = open_status_listener("lcm:" + url);
  const auto drain = [&] {
    while (watcher->read()) {
    }
  };
  std::mt19937 random(3);
  std::array<uint8_t, 256> noise{};
  for (int i = 0; i < 100'000; ++i) {
    const size_t at = random() % noise.size();
    noise[at] = static_cast<uint8_t>(random());
    for (const char* const channel : {"LDP_COMMAND", "LDP_STATUS", "LDP_PROGRESS", "LDP_GUIDANCE", "LDP_RESULT"}) {
      stranger.publish(channel, noise.data(), static_cast<unsigned>(random() % noise.size()));
    }
    // LCM keeps 30 messages that were not looked at, and drops the rest.
    if (i % 25 != 24) continue;
    const int64_t all = 4 * (i + 1);
    for (int waits = 0; waits < 2 && watcher->ignored() < all; ++waits) {
      std::this_thread::sleep_for(std::chrono::microseconds(200));
      drain();
    }
  }
  RecordProperty("ignored_by_watcher", std::to_string(watcher->ignored()));
  if (text_of(room_ / "said").find("ignored so far") == std::string::npos && !service.says("ignored so far", 3)) {
    service.stop(SIGKILL);
    GTEST_SKIP() << "multicast does not come back here";
  }
  EXPECT_THAT(text_of(room_ / "said"), Not(HasSubstr("capturing")));
  EXPECT_FALSE(fs::exists(capture()));
  const auto person = open_status_listener("lcm:" + url);
  for (int i = 0; i < 100 && !service.says("capturing", 0); ++i) {
    person->send(Command::press);
    std::this_thread::sleep_for(milliseconds(20));
  }
  EXPECT_TRUE(service.says("capturing", 5));
  const std::string said = service.stop(SIGTERM).said;
  const int ignored = std::atoi(said.c_str() + said.rfind("ignored so far: ") + 16);
  RecordProperty("ignored_by_service", ignored);
  EXPECT_GE(ignored, 10'000);  // of the 100,000; a busy machine drops some on their way
  EXPECT_GE(watcher->ignored(), 40'000);
}

// Who sends a press sends no release: the gallery's Start, `ldp watch --send press`.
TEST_F(LdpdTest, ASweepIsBegunAndEndedByCommandInEitherMode) {
  const std::string url = "lcm:" + private_network();
  script("wait 1");
  for (const char* const mode : {"hold", "toggle"}) {
    fs::remove_all(room_ / "out");
    configure("mode = \"" + std::string(mode) + "\"\nmin_frames = 3\n");
    Process service(command({"--status", url, "--status", "console:"}, "&hold=yes"), room_ / mode);
    ASSERT_TRUE(service.says("ready")) << text_of(room_ / mode);
    const auto person = open_status_listener(url);
    person->send(Command::press);
    if (!service.says("capturing", 5)) GTEST_SKIP() << "multicast does not come back here";
    ASSERT_TRUE(service.says("stored: 4")) << text_of(room_ / mode);
    person->send(Command::stop);
    EXPECT_TRUE(service.says("sweep_000001.ldp is ready")) << text_of(room_ / mode);
    EXPECT_THAT(text_of(capture() / "capture.json"), HasSubstr("ended by command"));
    EXPECT_EQ(service.stop(SIGTERM).status, 0);
  }
}

TEST_F(LdpdTest, APressByCommandIsNoButtonThatIsHeld) {
  const std::string url = "lcm:" + private_network();
  fs::remove_all(room_ / "frames");
  make_frames(1, 200, 150);
  script("wait 1");
  for (const char* const mode : {"hold", "toggle"}) {
    configure_switch_off(mode);
    Process service(command({"--status", url, "--status", "console:"}, "&hold=yes"), room_ / mode);
    ASSERT_TRUE(service.says("ready")) << text_of(room_ / mode);
    const auto person = open_status_listener(url);
    person->send(Command::press);
    if (!service.says("capturing", 5)) GTEST_SKIP() << "multicast does not come back here";
    ASSERT_FALSE(service.ends_within(5)) << text_of(room_ / mode);
    EXPECT_THAT(text_of(room_ / mode), Not(HasSubstr("cancelled")));
    person->send(Command::stop);
    EXPECT_TRUE(service.says("the sweep was ended by command")) << text_of(room_ / mode);
    EXPECT_EQ(service.stop(SIGTERM).status, 0);
  }
}

TEST_F(LdpdTest, LdpCaptureWritesACaptureFolderAndNothingElse) {
  const std::vector<std::string> words{LDP_DEVICE_PROGRAM,
                                       "capture",
                                       "--camera",
                                       "folder:" + (room_ / "frames").string() + "?fps=60",
                                       "--button",
                                       "script:" + (room_ / "script").string(),
                                       "-o",
                                       (room_ / "cap").string()};
  EXPECT_EQ(Process(words, room_ / "said").wait().status, 0);
  EXPECT_EQ(frames_in(room_ / "cap"), 14);
  EXPECT_EQ(std::distance(fs::directory_iterator(room_ / "cap"), fs::directory_iterator()), 15);
  const Finished again = Process(words, room_ / "said").wait();
  EXPECT_EQ(again.status, 2);
  EXPECT_THAT(again.said, HasSubstr("not empty"));
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
  std::vector<std::string> words{LDP_DEVICE_PROGRAM,
                                 "capture",
                                 "--camera",
                                 "folder:" + (room_ / "frames").string() + "?fps=60",
                                 "--button",
                                 "script:" + (room_ / "script").string(),
                                 "-o",
                                 (room_ / "cap").string(),
                                 "--fov",
                                 "160"};
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
