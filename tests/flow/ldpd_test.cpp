// The service as a whole, as a process: simulated camera and button, a stand-in for the build, and everything that can
// go wrong on the way. LDP_KILLS=200 is the long form of the kill tests.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <lcm/lcm-cpp.hpp>
#include <random>
#include <set>
#include <sstream>
#include <thread>

#include "core/photos/images.h"
#include "device/backends/open.h"
#include "drivers/interface/status.h"
#include "tests/private_network.h"

namespace ldp {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;
using testing::HasSubstr;
using testing::Not;

double hashed(int x, int y) {
  uint32_t hash = static_cast<uint32_t>(x) * 0x9E3779B1U ^ static_cast<uint32_t>(y) * 0x85EBCA77U;
  hash = (hash ^ (hash >> 15)) * 0x2C1B3C6DU;
  return static_cast<double>((hash ^ (hash >> 13)) % 1000) / 999.0;
}

// Smooth noise with cells of one unit.
double value_noise(double x, double y) {
  const int column = static_cast<int>(std::floor(x)), row = static_cast<int>(std::floor(y));
  const double a = x - column, b = y - row;
  const double top = hashed(column, row) * (1 - a) + hashed(column + 1, row) * a;
  const double bottom = hashed(column, row + 1) * (1 - a) + hashed(column + 1, row + 1) * a;
  return top * (1 - b) + bottom * b;
}

// A view of an endless made-up landscape.
RgbImage view_at(double offset_px, int width, int height) {
  RgbImage image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double u = (x + offset_px) / width * 24, v = static_cast<double>(y) / width * 24;
      const double level = 20 + 90 * value_noise(u, v) + 50 * value_noise(u * 0.31, v * 0.31 + 100);
      const auto grey = static_cast<uint8_t>(std::clamp(level, 0.0, 255.0));
      image.at(x, y) = {grey, grey, static_cast<uint8_t>(grey / 2)};
    }
  }
  return image;
}

struct Finished {
  int status = -1;  // exit status, or -1 when killed
  std::string said;
};

std::string text_of(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

class Process {
 public:
  Process(std::vector<std::string> words, fs::path output) : output_(std::move(output)) {
    pid_ = fork();
    if (pid_ != 0) return;
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (!freopen(output_.c_str(), "a", stderr) || !freopen("/dev/null", "w", stdout)) _exit(126);
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    execvp(arguments[0], arguments.data());
    _exit(127);
  }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;
  ~Process() {
    if (!over_) stop(SIGKILL);
  }

  bool says(const std::string& what, int seconds = 60) const {
    const auto until = Clock::now() + std::chrono::seconds(seconds);
    for (;;) {
      if (text_of(output_).find(what) != std::string::npos) return true;
      if (Clock::now() >= until) return false;
      std::this_thread::sleep_for(milliseconds(5));
    }
  }
  bool runs() const {  // what it ended with stays to be waited for
    siginfo_t ended{};
    return waitid(P_PID, static_cast<id_t>(pid_), &ended, WEXITED | WNOHANG | WNOWAIT) == 0 && ended.si_pid == 0;
  }
  Finished stop(int signal) {
    kill(pid_, signal);
    return wait();
  }
  Finished wait() {
    int status = 0;
    waitpid(pid_, &status, 0);
    over_ = true;
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, text_of(output_)};
  }
  pid_t pid() const { return pid_; }
  // Whether there was one.
  bool kill_child() const {
    const std::string pid = std::to_string(pid_);
    const pid_t child = std::atoi(text_of("/proc/" + pid + "/task/" + pid + "/children").c_str());
    return child > 0 && kill(child, SIGKILL) == 0;
  }

 private:
  fs::path output_;
  pid_t pid_ = -1;
  bool over_ = false;
};

// With `hold=no` the sweep ends with the camera's last picture, however long it takes.
constexpr const char* kUntilTheCameraEnds = "press wait 300000 release";

constexpr std::array kQuick = {"--layers", "1", "--iterations", "1", "--labels", "4"};

class LdpdTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = testing::TempDir() + "ldpd_XXXXXX";
    room_ = mkdtemp(name.data());
    make_frames(14, 200, 150);
    build_program("echo '0.5 poses' >&3");
    script("press wait 1500 release");
  }
  void TearDown() override { fs::remove_all(room_); }

  void make_frames(int count, int width, int height) {
    fs::create_directories(room_ / "frames");
    for (int i = 0; i < count; ++i) {
      char file[32];
      std::snprintf(file, sizeof file, "frame_%03d.jpg", i);
      write_file(room_ / "frames" / file, encode_jpeg(view_at(i * width * 0.2, width, height), 95));
    }
  }

  // Stands for `ldp build CAPTURE -o FILE ...`: with --follow does `at_line` at each line it is told until the end;
  // then begins FILE, does `before`, and ends it.
  void build_program(const std::string& before, const std::string& at_line = "true") {
    std::ofstream(room_ / "build") << "#!/bin/bash\ncapture=$2\nfile=$4\n[ -d \"${file%/*}\" ] || exit 2\n"
                                   << "[[ \" $* \" != *' --follow '* ]] || while [ \"$line\" != end ]; do\n"
                                   << "read -r line || exit 130\n"
                                   << at_line << "\ndone\necho begun > \"$file\" || exit 2\n"
                                   << before << "\n(ls \"$capture\"; echo ended) >> \"$file\" || exit 2\n";
    fs::permissions(room_ / "build", fs::perms::owner_all);
  }
  void script(const std::string& words) { std::ofstream(room_ / "script") << words << "\n"; }
  void configure(const std::string& sweep = "", const std::string& build = "") {
    std::ofstream(room_ / "ldpd.toml") << "[build]\nprogram = \"" << (room_ / "build").string() << "\"\n"
                                       << build << "[sweep]\n"
                                       << sweep;
  }

  std::vector<std::string> command(const std::vector<std::string>& more, const std::string& camera_options = "") {
    if (!fs::exists(room_ / "ldpd.toml")) configure();
    std::vector<std::string> words{LDPD_PROGRAM,
                                   "--config",
                                   (room_ / "ldpd.toml").string(),
                                   "--camera",
                                   "folder:" + (room_ / "frames").string() + "?fps=" + fps_ + camera_options,
                                   "--button",
                                   "script:" + (room_ / "script").string(),
                                   "--output",
                                   (room_ / "out").string()};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
  // Under faults.c; what it did is in the file "faults".
  std::vector<std::string> with_faults(const std::string& rules, const std::vector<std::string>& words) const {
    std::vector<std::string> all{"env",
                                 "LD_PRELOAD=" LDP_FAULTS,
                                 "LDP_FAULTS=" + rules,
                                 "LDP_FAULTS_IN=" + fs::path(words[0]).filename().string(),
                                 "LDP_FAULTS_LOG=" + (room_ / "faults").string(),
                                 "ASAN_OPTIONS=verify_asan_link_order=0"};
    all.insert(all.end(), words.begin(), words.end());
    return all;
  }
  // Unless told otherwise the sweep is over with the last picture, so that a busy machine loses none.
  Finished run_once(const std::string& camera_options = "&hold=no") {
    return Process(command({"--once"}, camera_options), room_ / "said").wait();
  }

  fs::path capture(int number = 1) const { return room_ / "out" / ("sweep_00000" + std::to_string(number)); }
  fs::path panorama(int number = 1) const { return capture(number).string() + ".ldp"; }
  static int frames_in(const fs::path& folder) {
    int frames = 0;
    if (!fs::exists(folder)) return 0;
    for (const auto& entry : fs::directory_iterator(folder)) frames += entry.path().extension() == ".jpg" ? 1 : 0;
    return frames;
  }

  // A small synthetic sweep. Gives the number of its frames.
  int photograph_garden(const fs::path& folder) {
    script(kUntilTheCameraEnds);
    const std::string scene = "scene:garden?fps=1000&hold=no&width=160&height=120";
    const std::string button = "script:" + (room_ / "script").string();
    Process({LDP_DEVICE_PROGRAM, "capture", "--camera", scene, "--button", button, "-o", folder.string()},
            room_ / "captured")
        .wait();
    return frames_in(folder);
  }
  // Builds by ldp itself, as fast as it can.
  void configure_ldp() {
    std::ofstream(room_ / "ldpd.toml") << "[build]\nniceness = 0\noptions = [";
    for (const char* const word : kQuick) std::ofstream(room_ / "ldpd.toml", std::ios::app) << '"' << word << "\", ";
    std::ofstream(room_ / "ldpd.toml", std::ios::app) << "]\n";
  }

  // The greatest number of frames that the console was told are stored.
  int reported_stored() const {
    const std::string said = text_of(room_ / "said");
    const size_t at = said.rfind("stored: ");
    return at == std::string::npos ? 0 : std::atoi(said.c_str() + at + 8);
  }

  // Every frame under OUTPUT is byte by byte one of the camera's, and nothing temporary is left.
  void expect_whole(bool no_temporaries) const {
    std::vector<std::vector<uint8_t>> originals;
    for (const auto& entry : fs::directory_iterator(room_ / "frames")) originals.push_back(read_file(entry.path()));
    for (const auto& entry : fs::recursive_directory_iterator(room_ / "out")) {
      if (entry.path().extension() == ".jpg") {
        EXPECT_TRUE(std::count(originals.begin(), originals.end(), read_file(entry.path())) > 0) << entry.path();
      }
      if (no_temporaries) {
        EXPECT_NE(entry.path().extension(), ".tmp") << entry.path();
      }
      if (entry.path().extension() == ".ldp" && entry.path().parent_path() == room_ / "out") {
        EXPECT_THAT(text_of(entry.path()), testing::EndsWith("ended\n")) << entry.path();
      }
    }
  }

  fs::path room_;
  std::string fps_ = "60";  // of the camera
};

bool is_gone(pid_t process) {
  for (int i = 0; i < 1000; ++i) {
    const std::string stat = text_of("/proc/" + std::to_string(process) + "/stat");
    if (stat.empty() || stat.find(") Z ") != std::string::npos) return true;
    std::this_thread::sleep_for(milliseconds(5));
  }
  return false;
}

int kills() {
  const char* const wanted = std::getenv("LDP_KILLS");
  return wanted != nullptr ? std::atoi(wanted) : 10;
}

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
  configure("lost_after_seconds = 0.3\n");
  script("press wait 60000 release");
  const Finished run = run_once("&stall_after=6");
  EXPECT_EQ(run.status, 0) << run.said;
  EXPECT_THAT(run.said, HasSubstr("no more frames"));
}

TEST_F(LdpdTest, ACameraFasterThanItsFramesCanBeLookedAtDoesNotKeepTheButtonWaiting) {
  fs::remove_all(room_ / "frames");
  make_frames(5, 480, 360);
  script("press wait 700 release");
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
  script("press wait 700 release");
  EXPECT_TRUE(service.says("sweep_000001.ldp is ready"));
  service.stop(SIGTERM);
}

TEST_F(LdpdTest, ASecondServiceOnTheSameFolderIsRefusedAndTouchesNothing) {
  script("wait 600000");
  Process first(command({"--status", "console:"}), room_ / "said");
  ASSERT_TRUE(first.says("ready"));
  std::ofstream(room_ / "out" / ".building" / "sweep_000009.ldp") << "half a panorama";
  std::ofstream(room_ / "out" / "a.tmp") << "half a file";
  for (const char* const once : {"--once", "--mode=hold"}) {
    fs::remove(room_ / "second");
    Process second(command({once}), room_ / "second");
    ASSERT_TRUE(second.says("ldpd: another ldpd works in " + (room_ / "out").string() + ": stop it", 10));
    EXPECT_EQ(second.wait().status, 1);
  }
  EXPECT_TRUE(fs::exists(room_ / "out" / ".building" / "sweep_000009.ldp"));
  EXPECT_TRUE(fs::exists(room_ / "out" / "a.tmp"));
  EXPECT_EQ(Process(command({"--check-config"}), room_ / "checked").wait().status, 0);
  first.stop(SIGKILL);
  Process third(command({"--status", "console:"}), room_ / "said_by_third");
  EXPECT_TRUE(third.says("ready"));
  EXPECT_FALSE(fs::exists(room_ / "out" / "a.tmp"));
  third.stop(SIGTERM);
}

TEST_F(LdpdTest, APressWhileBuildingIsRefusedAndNothingIsLost) {
  build_program("sleep 0.6");
  script("press wait 1500 release wait 200 press wait 50 release wait 3000 press wait 1500 release");
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

TEST_F(LdpdTest, InToggleModeASecondPressEndsTheSweep) {
  configure("mode = \"toggle\"\n");
  script("press wait 50 release wait 1500 press wait 50 release");
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
  const Way ways[] = {{"cancelled", "mode = \"toggle\"\n", "press wait 3300 release", 0, "its frames were removed"},
                      {"too short", "min_frames = 80\n", "press wait 400 release", 0, "are needed"},
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
    EXPECT_TRUE(!fs::exists(room_ / "out" / ".building") || fs::is_empty(room_ / "out" / ".building"));
  }
}

// On a disk that takes its time: the sweep is over, the button stays held until the build to come is cancelled, and the
// next press begins another sweep, all before the first one's frames are on disk.
TEST_F(LdpdTest, ASweepCancelledWhileItIsStoredKeepsItsFramesAndDoesNotMixWithTheNext) {
  configure("mode = \"toggle\"\nmin_frames = 3\n");
  fps_ = "20";
  script(
      "press wait 10 release wait 2000 press wait 3300 release press wait 10 release wait 2000 press wait 10 release");
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
  build_program("echo $$ > \"$capture.pid\"; echo '0.2 poses' >&3; sleep 0.3");
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
