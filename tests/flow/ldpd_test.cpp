// The service as a whole, as a process: single runs, interruptions, and what its configuration may not say. Simulated
// camera and button, a stand-in for the build.
#include <tuple>

#include "tests/flow/ldpd.h"

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

TEST_F(LdpdTest, WhatIsWrongWithTheSweepIsToldWhileItIsBuilt) {
  build_program("echo '1 so far: sweep again: it is dark' >&3");
  const Finished run = run_once();
  EXPECT_THAT(run.said, testing::ContainsRegex("building: sweep_[^\n]*; so far sweep again: it is dark"));
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

// The scene would take hours: what a camera needs before its first frame is given up.
TEST_F(LdpdTest, AsLongAsTheCameraIsPreparedASignalEndsItAtOnceAndNothingIsLeft) {
  for (const char* const words : {"press wait 600000 release", "press release"}) {
    for (const bool once : {false, true}) {
      script(words);
      std::vector<std::string> all = command({"--status", "console:"});
      if (once) all.push_back("--once");
      all[4] = "scene:room?frames=1000&width=1600&height=1200";
      Process service(all, room_ / "said");
      EXPECT_TRUE(once ? becomes_true([&] { return fs::exists(room_ / "out"); }) : service.says("opening the camera"));
      kill(service.pid(), SIGTERM);
      ASSERT_TRUE(service.ends_within(kSanitized ? 300 : 60));
      const Finished end = service.wait();
      EXPECT_EQ(end.status, once ? 1 : 0);
      EXPECT_THAT(end.said, once ? HasSubstr("nothing was kept\n") : HasSubstr("shutting down"));
      EXPECT_THAT(end.said, Not(HasSubstr("failed")));
      EXPECT_FALSE(fs::exists(capture())) << words;
      fs::remove(room_ / "said"), fs::remove_all(room_ / "out");
    }
  }
}

TEST_F(LdpdTest, ASweepWithoutAFrameLeavesNoFolder) {
  script("press release");
  const Finished run = run_once("&stall_after=0");
  EXPECT_EQ(run.status, 1);
  EXPECT_THAT(run.said, HasSubstr("only 0 frames"));
  EXPECT_FALSE(fs::exists(capture()));
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

TEST_F(LdpdTest, WhatCannotBePrintedAsksForAnotherTime) {
  for (const std::string what : {"--print-config", "--help", "--version"}) {
    const Finished run = Process({LDPD_PROGRAM, what}, room_ / ("said" + what), [] {
                           if (!freopen("/dev/full", "w", stdout)) _exit(126);
                         }).wait();
    EXPECT_EQ(run.status, 75) << what;
    EXPECT_EQ(run.said, "ldpd: cannot write to standard output: No space left on device\n");
  }
}

TEST_F(LdpdTest, TellsItsVersion) { EXPECT_EQ(Process({LDPD_PROGRAM, "--version"}, room_ / "said").wait().status, 0); }

TEST_F(LdpdTest, ASingleRunWithoutItsScriptOrPhotosIsRefusedBeforeItsFolderIsMade) {
  const std::string nowhere = (room_ / "nowhere").string();
  for (const auto& [word, option, url] :
       {std::tuple(4U, "--camera", "folder:"), std::tuple(6U, "--button", "script:")}) {
    std::vector<std::string> words = command({"--once"});
    words[word] = url + nowhere;
    const Finished run = Process(words, room_ / "said").wait();
    EXPECT_EQ(run.status, 2);
    EXPECT_THAT(run.said, HasSubstr(std::string("ldpd: ") + option + ": '" + url + nowhere + "': there is no "));
    EXPECT_THAT(run.said, HasSubstr("'" + nowhere + "': check its name\n"));
    EXPECT_FALSE(fs::exists(room_ / "out"));
  }
}

TEST_F(LdpdTest, AMissingDeviceOfASingleRunIsNamed) {
  std::vector<std::string> words = command({"--once"});
  words[4] = "v4l2:" + (room_ / "nowhere").string();
  const Finished run = Process(words, room_ / "said").wait();
  EXPECT_EQ(run.status, 1);
  EXPECT_THAT(run.said, HasSubstr("nowhere"));
}

TEST_F(LdpdTest, ASingleRunWithoutItsCameraLeavesNoFolderThatItMade) {
  fs::create_directory(room_ / "bare");
  fs::create_directory(room_ / "there");
  const std::string nested = (room_ / "new" / "out").string(), there = (room_ / "there").string();
  for (const std::string& camera : {"v4l2:" + (room_ / "nowhere").string(), "folder:" + (room_ / "bare").string()})
    for (const std::string& output : {nested, there}) {
      std::vector<std::string> words = command({"--once"});
      words[4] = camera, words[8] = output;
      EXPECT_EQ(Process(words, room_ / "said").wait().status, 1) << camera;
      EXPECT_FALSE(fs::exists(room_ / "new")) << camera;
      EXPECT_TRUE(fs::exists(there)) << "which it did not make";
    }
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

TEST_F(LdpdTest, NamesWriteNoControlSequencesOntoTheTerminal) {
  const fs::path odd = room_ / "odd\x1b]0;x\a.toml";
  std::ofstream(odd) << "nonsense = 1\n";
  const Finished mistaken = Process({LDPD_PROGRAM, "--check-config", "--config", odd.string()}, room_ / "said").wait();
  EXPECT_EQ(mistaken.status, 78);
  EXPECT_THAT(mistaken.said, HasSubstr("odd\\x1b]0;x\\x07.toml:1: "));
  std::vector<std::string> words = command({"--once", "--status", "console:"}, "&hold=no");
  words[8] += "\x1b]0;x\a";
  const Finished done = Process(words, room_ / "said").wait();
  EXPECT_EQ(done.status, 0);
  EXPECT_THAT(done.said, HasSubstr("out\\x1b]0;x\\x07/sweep_000001.ldp: built in"));
  for (const Finished& run : {mistaken, done}) EXPECT_EQ(run.said.find('\x1b'), std::string::npos) << run.said;
}

TEST_F(LdpdTest, AnUnknownKindOfDeviceIsRefusedAtOnce) {
  std::vector<std::string> words = command({});
  words[6] = "switch:1";
  const Finished run = Process(words, room_ / "said").wait();
  EXPECT_EQ(run.status, 2);
  EXPECT_THAT(run.said, HasSubstr("--button: 'switch:1': no button of that kind; known: gpiod:, script:, keyboard:"));
}

TEST_F(LdpdTest, AWrongOptionAndAMissingConfigurationSayWhatToDo) {
  const Finished option = Process({LDPD_PROGRAM, "--hel"}, room_ / "option").wait();
  EXPECT_EQ(option.status, 2);
  EXPECT_EQ(option.said, "ldpd: The following argument was not expected: --hel: see ldpd --help\n");
  const std::string file = (room_ / "none.toml").string();
  const Finished configuration = Process({LDPD_PROGRAM, "--config", file}, room_ / "configuration").wait();
  EXPECT_EQ(configuration.status, 78);
  EXPECT_EQ(configuration.said, file + ": cannot read the file (No such file or directory): check its name\n");
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
  const Finished unnamed = refused("--config");
  EXPECT_EQ(unnamed.status, 78);
  EXPECT_EQ(unnamed.said, "ldpd: the name of the configuration is empty: give the name of a file\n");
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

}  // namespace
}  // namespace ldp
