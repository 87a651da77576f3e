// What tests of the service share: it as a process, a room of its own with a simulated camera and button, a stand-in
// for the build, and what must hold of the files it leaves.
#pragma once

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
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <sstream>
#include <thread>

#include "core/base/files.h"
#include "core/photos/images.h"
#include "tests/sanitizers.h"

namespace ldp {
namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;
using testing::HasSubstr;
using testing::Not;

inline double hashed(int x, int y) {
  uint32_t hash = static_cast<uint32_t>(x) * 0x9E3779B1U ^ static_cast<uint32_t>(y) * 0x85EBCA77U;
  hash = (hash ^ (hash >> 15)) * 0x2C1B3C6DU;
  return static_cast<double>((hash ^ (hash >> 13)) % 1000) / 999.0;
}

// Smooth noise with cells of one unit.
inline double value_noise(double x, double y) {
  const int column = static_cast<int>(std::floor(x)), row = static_cast<int>(std::floor(y));
  const double a = x - column, b = y - row;
  const double top = hashed(column, row) * (1 - a) + hashed(column + 1, row) * a;
  const double bottom = hashed(column, row + 1) * (1 - a) + hashed(column + 1, row + 1) * a;
  return top * (1 - b) + bottom * b;
}

// A view of an endless made-up landscape.
inline RgbImage view_at(double offset_px, int width, int height) {
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

inline std::string text_of(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

class Process {
 public:
  // `prepare` is called in the process before it becomes the program.
  Process(std::vector<std::string> words, fs::path output, const std::function<void()>& prepare = {})
      : output_(std::move(output)) {
    std::fflush(stdout);  // freopen would write what is there once more
    pid_ = fork();
    if (pid_ != 0) return;
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (!freopen(output_.c_str(), "a", stderr) || !freopen("/dev/null", "w", stdout)) _exit(126);
    if (prepare) prepare();
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
  bool ends_within(int seconds) const {
    const auto until = Clock::now() + std::chrono::seconds(seconds);
    while (runs() && Clock::now() < until) std::this_thread::sleep_for(milliseconds(5));
    return !runs();
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

// Milliseconds, in a script, in which a whole sweep is looked at.
inline std::string time_for_all(int ms) { return std::to_string(kSanitized ? 8 * ms : ms); }

// With `hold=no` the sweep ends with the camera's last picture, however long it takes.
inline constexpr const char* kUntilTheCameraEnds = "press wait 300000 release";

inline constexpr std::array kQuick = {"--layers", "1", "--iterations", "1", "--labels", "4"};

class LdpdTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = testing::TempDir() + "ldpd_XXXXXX";
    room_ = mkdtemp(name.data());
    make_frames(14, 200, 150);
    build_program("echo '0.5 poses' >&3");
    script("press wait " + time_for_all(1500) + " release");
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
                                   << before << "\n{ ls \"$capture\"; echo ended; } >> \"$file\" || exit 2\n";
    fs::permissions(room_ / "build", fs::perms::owner_all);
  }
  void script(const std::string& words) { std::ofstream(room_ / "script") << words << "\n"; }
  void configure(const std::string& sweep = "", const std::string& build = "") {
    std::ofstream(room_ / "ldpd.toml") << "[build]\nprogram = \"" << (room_ / "build").string() << "\"\n"
                                       << build << "[sweep]\n"
                                       << sweep;
  }

  void configure_switch_off(const std::string& mode, const std::string& sweep = "") {
    configure("mode = \"" + mode + "\"\n" + sweep);
    const std::string rest = text_of(room_ / "ldpd.toml");
    std::ofstream(room_ / "ldpd.toml") << "switch_off_seconds = 4\n" << rest;
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
    std::vector<std::string> all{"env", "LD_PRELOAD=" LDP_FAULTS, "LDP_FAULTS=" + rules,
                                 "LDP_FAULTS_IN=" + fs::path(words[0]).filename().string(),
                                 "LDP_FAULTS_LOG=" + (room_ / "faults").string()};
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
  // Builds by ldp itself, as fast as it can; sanitizers reserve more than any limit.
  void configure_ldp() {
    std::ofstream(room_ / "ldpd.toml") << "[build]\nniceness = 0\n"
                                       << (kSanitized ? "memory_limit_mib = 0\n" : "") << "options = [";
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

inline bool is_gone(pid_t process) {
  for (int i = 0; i < 1000; ++i) {
    const std::string stat = text_of("/proc/" + std::to_string(process) + "/stat");
    if (stat.empty() || stat.find(") Z ") != std::string::npos) return true;
    std::this_thread::sleep_for(milliseconds(5));
  }
  return false;
}

template <typename Holds>
bool becomes_true(Holds holds) {
  for (int i = 0; i < 1000 && !holds(); ++i) std::this_thread::sleep_for(milliseconds(5));
  return holds();
}

// The service removes what was cancelled beside its other work.
inline bool becomes_empty(const fs::path& folder) {
  return becomes_true([&] { return !fs::exists(folder) || fs::is_empty(folder); });
}

inline bool has_temporary(const fs::path& folder) {
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().extension() == ".tmp") return true;
  return false;
}

inline int kills() {
  const char* const wanted = std::getenv("LDP_KILLS");
  return wanted != nullptr ? std::atoi(wanted) : 10;
}

}  // namespace ldp
