// What tests of the program `ldp` share: a room of their own, running it, a small capture, and what a refusal is.
#pragma once

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/base/files.h"
#include "core/photos/images.h"

extern char** environ;

namespace ldp {

namespace fs = std::filesystem;
using testing::HasSubstr;

inline std::string text_of(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

struct Outcome {
  int status = 0;
  std::string out, err;
};

class Running {
 public:
  // `through`: a program, found on the path, that runs the rest of its command line.
  Running(const std::vector<std::string>& words, const fs::path& room, const std::vector<std::string>& through = {})
      : out_(room / "stdout"), err_(room / "stderr") {
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    constexpr int kFlags = O_WRONLY | O_CREAT | O_TRUNC;
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, out_.c_str(), kFlags, 0600);
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, err_.c_str(), kFlags, 0600);
    std::vector<std::string> all = through;
    all.emplace_back(LDP_PROGRAM);
    all.insert(all.end(), words.begin(), words.end());
    std::vector<char*> arguments;
    for (std::string& word : all) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    if (posix_spawnp(&pid_, all[0].c_str(), &actions, nullptr, arguments.data(), environ) != 0)
      throw std::runtime_error("cannot start " LDP_PROGRAM);
    posix_spawn_file_actions_destroy(&actions);
  }
  void interrupt() const { ::kill(pid_, SIGINT); }
  void kill() const {
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
  }
  Outcome wait() const {
    int status = 0;
    ::waitpid(pid_, &status, 0);
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, text_of(out_), text_of(err_)};
  }

 private:
  fs::path out_, err_;
  pid_t pid_ = -1;
};

class Flow : public testing::Test {
 protected:
  void SetUp() override {
    room_ = fs::path(testing::TempDir()) / ("flow_" + std::to_string(::getpid()));
    fs::remove_all(room_);
    fs::create_directories(room_ / "work");
  }
  void TearDown() override { fs::remove_all(room_); }

  Outcome ldp(const std::vector<std::string>& words) const { return Running(words, room_).wait(); }
  // What the shell command prints as the standard input.
  static std::vector<std::string> fed_by(const std::string& command) {
    return {"bash", "-c", "exec \"$0\" \"$@\" < <(" + command + ")"};
  }
  std::string path(const std::string& name) const { return (room_ / "work" / name).string(); }

  // Eight small photos over 70 degrees.
  std::string capture() const {
    const Outcome made = ldp({"scene", "courtyard", "-o", path("capture"), "--size", "240x180", "--frames", "8",
                              "--arc", "70", "--jitter-position", "0.005", "--jitter-angle", "0.4"});
    EXPECT_EQ(made.status, 0) << made.err;
    return path("capture");
  }
  std::string panorama(const std::string& from) const {
    const Outcome built = ldp({"build", from, "-o", path("a.ldp"), "--cameras", from + "/transforms.json",
                               "--iterations", "1", "--layers", "2"});
    EXPECT_EQ(built.status, 0) << built.err;
    return path("a.ldp");
  }
  void photo(const std::string& name, int width = 64, int height = 48) const {
    fs::create_directories(fs::path(path(name)).parent_path());
    RgbImage image(width, height);
    for (size_t i = 0; i < image.samples.size(); ++i) image.samples[i].g = static_cast<uint8_t>(i * 2654435761U >> 7);
    write_file(path(name), encode_jpeg(image, 90));
  }
  // One line that names the command and says where; the right status; nothing left but what was there.
  void expect_refusal(const std::vector<std::string>& words, int status, const std::string& says,
                      const std::vector<std::string>& through = {}) const {
    const auto before = contents();
    const Outcome outcome = Running(words, room_, through).wait();
    EXPECT_EQ(outcome.status, status) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(says));
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_EQ(outcome.err.rfind("ldp", 0), 0U) << outcome.err;
    EXPECT_EQ(contents(), before);
  }
  std::vector<std::string> contents() const {
    std::vector<std::string> all;
    for (const auto& entry : fs::recursive_directory_iterator(room_ / "work")) all.push_back(entry.path().string());
    std::sort(all.begin(), all.end());
    return all;
  }

  fs::path room_;
};

}  // namespace ldp
