// What the service and `ldp capture` do when the system refuses, hangs or goes away under them. Calls fail by faults.c.
#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/un.h>

#include "core/base/files.h"
#include "device/backends/open.h"
#include "device/service/builds/build_child.h"
#include "drivers/interface/status.h"
#include "tests/flow/ldpd.h"
#include "tests/private_network.h"

namespace ldp {
namespace {

// The disk takes its time for every photo; Ctrl-C comes when all are chosen and some not yet stored.
TEST_F(LdpdTest, TheFirstInterruptionOfLdpCaptureStoresWhatWasTakenAndTheSecondLeavesAtOnce) {
  script("press wait 600000 release");
  const auto slowed = [&](const std::string& rules, const std::string& folder) {
    return with_faults(
        rules,
        {LDP_DEVICE_PROGRAM, "capture", "--camera", "folder:" + (room_ / "frames").string() + "?fps=100", "--button",
         "script:" + (room_ / "script").string(), "--status", "console:", "-o", (room_ / folder).string()});
  };
  {
    Process first(slowed("fsync .jpg * delay " + time_for_all(80), "one"), room_ / "said");
    ASSERT_TRUE(first.says("stored: 2 frames") && first.says("sweep: 13 frames, 168 degrees"))
        << text_of(room_ / "said");
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

// What faults.c counted: how often the main thread asked for events.
int polls_in(const fs::path& log) {
  const std::string text = text_of(log);
  const size_t at = text.rfind("polls ");
  return at == std::string::npos ? -1 : std::atoi(text.c_str() + at + 6);
}

// A terminal of which this process is the other end.
class Terminal {
 public:
  Terminal() : master_(::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC)) {
    if (master_ < 0 || ::grantpt(master_) != 0 || ::unlockpt(master_) != 0) throw std::runtime_error("no terminal");
    slave_ = ::open(::ptsname(master_), O_RDWR | O_NOCTTY | O_CLOEXEC);
  }
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;
  ~Terminal() { hang_up(); }

  void become_input() const { ::dup2(slave_, STDIN_FILENO); }
  void type(const char* key) const { EXPECT_EQ(::write(master_, key, 1), 1); }
  void hang_up() {
    for (int* const fd : {&slave_, &master_}) {
      if (*fd >= 0) ::close(std::exchange(*fd, -1));
    }
  }

 private:
  int master_, slave_ = -1;
};

TEST_F(LdpdTest, AKeyboardThatHangsUpIsLostAndDoesNotKeepTheServiceAwake) {
  Terminal terminal;
  std::vector<std::string> words = command({"--status", "console:"});
  words[6] = "keyboard:";
  Process service(with_faults("", words), room_ / "said", [&] { terminal.become_input(); });
  ASSERT_TRUE(service.says("idle: ready"));
  terminal.hang_up();
  EXPECT_TRUE(service.says("the button was lost", 5)) << text_of(room_ / "said");
  std::this_thread::sleep_for(milliseconds(1500));
  EXPECT_EQ(service.stop(SIGTERM).status, 0);
  EXPECT_GT(polls_in(room_ / "faults"), 0);
  EXPECT_LT(polls_in(room_ / "faults"), 60);
}

// Between two ticks it sleeps, and every tick it does what a tick is for: a script that came late is found.
TEST_F(LdpdTest, AServiceThatWaitsWakesForItsTicksOnlyAndDoesMissNone) {
  const std::vector<std::string> words = command({"--status", "console:"});
  fs::remove(room_ / "script");
  Process service(with_faults("", words), room_ / "said");
  ASSERT_TRUE(service.says("the button is missing"));
  script("wait 600000");
  EXPECT_TRUE(service.says("idle: ready", 10)) << text_of(room_ / "said");
  std::this_thread::sleep_for(milliseconds(1500));
  EXPECT_EQ(service.stop(SIGTERM).status, 0);
  EXPECT_GT(polls_in(room_ / "faults"), 2);
  EXPECT_LT(polls_in(room_ / "faults"), 60);
}

TEST_F(LdpdTest, TheWatchdogOfAServiceThatWaitsIsFedInTime) {
  const std::string path = (room_ / "notify").string();
  const int socket = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, sizeof address.sun_path - 1);
  ASSERT_EQ(::bind(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  const timeval patience{20, 0};
  ASSERT_EQ(::setsockopt(socket, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience), 0);
  script("wait 600000");
  std::vector<std::string> words = command({});
  words.insert(words.begin(), {"env", "NOTIFY_SOCKET=" + path, "WATCHDOG_USEC=300000"});
  Process service(words, room_ / "said");
  int fed = 0, ready = 0;
  char text[256];
  for (ssize_t got = 0; fed < 8 && (got = ::recv(socket, text, sizeof text, 0)) > 0;) {
    const std::string notice(text, static_cast<size_t>(got));
    fed += notice == "WATCHDOG=1" ? 1 : 0;
    ready += notice == "READY=1" ? 1 : 0;
  }
  EXPECT_EQ(fed, 8);
  EXPECT_EQ(ready, 1);
  EXPECT_EQ(service.stop(SIGTERM).status, 0);
  ::close(socket);
}

TEST_F(LdpdTest, AKeyboardThatHangsUpEndsASingleRunThatWaitsForIt) {
  Terminal terminal;
  Process waiting({LDP_DEVICE_PROGRAM, "capture", "--camera", "folder:" + (room_ / "frames").string(), "--status",
                   "console:", "-o", (room_ / "one").string()},
                  room_ / "said", [&] { terminal.become_input(); });
  ASSERT_TRUE(waiting.says("ready"));
  terminal.hang_up();
  EXPECT_TRUE(waiting.says("ldp-device capture: the button was lost", 5)) << text_of(room_ / "said");
  EXPECT_TRUE(waiting.ends_within(5));
  EXPECT_EQ(waiting.stop(SIGKILL).status, 1);
  EXPECT_FALSE(fs::exists(room_ / "one"));
}

TEST_F(LdpdTest, AParentThatIgnoresTheEndOfChildrenHidesNoBuildFromTheService) {
  script(kUntilTheCameraEnds);
  Process service(with_faults("", command({"--once"}, "&hold=no")), room_ / "said", [] { ::signal(SIGCHLD, SIG_IGN); });
  EXPECT_TRUE(service.ends_within(15)) << text_of(room_ / "said");
  EXPECT_EQ(service.stop(SIGTERM).status, 0);
  EXPECT_TRUE(fs::exists(panorama()));
  EXPECT_LT(polls_in(room_ / "faults"), 1000);
}

// Where the program that uses it lets the kernel forget how children ended, some of them before they are looked for.
TEST(BuildChildTest, ABuildWhoseEndNobodyKeptIsOver) {
  ::signal(SIGCHLD, SIG_IGN);
  BuildCommand command;
  command.program = "/bin/true";
  for (int build = 0; build < 100; ++build) {
    BuildChild child(command);
    pollfd entry{child.end_fd(), POLLIN, 0};
    EXPECT_EQ(::poll(&entry, 1, 10'000), 1);
    std::optional<BuildEnd> end;
    for (int i = 0; i < 200 && !end; ++i) {
      end = child.end();
      if (!end) std::this_thread::sleep_for(milliseconds(5));
    }
    ASSERT_TRUE(end.has_value());
    EXPECT_FALSE(end->ok);
    EXPECT_TRUE(end->retry);
  }
  ::signal(SIGCHLD, SIG_DFL);
}

TEST_F(LdpdTest, StandardErrorThatNobodyReadsAnyMoreEndsNothing) {
  script(kUntilTheCameraEnds);
  int ends[2];
  ASSERT_EQ(::pipe2(ends, O_CLOEXEC), 0);
  Process service(command({"--once", "--status", "console:"}, "&hold=no"), room_ / "said",
                  [&] { ::dup2(ends[1], STDERR_FILENO); });
  for (const int end : ends) ::close(end);
  EXPECT_EQ(service.wait().status, 0);
  EXPECT_TRUE(fs::exists(panorama()));
}

// The folder's fourth flush is that of a cancelled sweep's removal.
TEST_F(LdpdTest, AStorageErrorWhileASweepIsCancelledIsSaidAndTheNextOneWorks) {
  configure("mode = \"toggle\"\nmin_frames = 3\n");
  script("press wait 3300 release wait 300 press wait 10 release wait " + time_for_all(1500) +
         " press wait 10 release");
  Process service(with_faults("fsync /out$ 4 EIO", command({"--status", "console:"})), room_ / "said");
  EXPECT_TRUE(service.says("sweep_000002.ldp is ready", 30)) << text_of(room_ / "said");
  const Finished end = service.stop(SIGTERM);
  EXPECT_EQ(end.status, 0);
  EXPECT_THAT(end.said, HasSubstr("Input/output error"));
  EXPECT_FALSE(fs::exists(capture(1)));
}

TEST_F(LdpdTest, AStorageErrorWhileABuildIsCancelledOrLeftIsSaidAndTheServiceGoesOn) {
  configure("mode = \"toggle\"\nmin_frames = 3\n");
  build_program("[ -e \"$capture.go\" ] || exec sleep 600");
  script("press wait 10 release wait " + time_for_all(1500) + " press wait 10 release wait " + time_for_all(1000) +
         " press wait 3300 release");
  Process service(with_faults("write build.json 2+ ENOSPC", command({"--status", "console:"})), room_ / "said");
  EXPECT_TRUE(service.says("idle: the build was cancelled", 30)) << text_of(room_ / "said");
  EXPECT_TRUE(service.runs());
  EXPECT_EQ(service.stop(SIGTERM).status, 0);
  EXPECT_THAT(text_of(room_ / "said"), HasSubstr("No space left on device"));
  EXPECT_GE(frames_in(capture()), 3);
}

TEST_F(LdpdTest, LinksThatLoopInTheOutputFolderDoNotKeepItFromStarting) {
  fs::create_directories(room_ / "out" / "sweep_000003");
  for (const char* const name : {"loop", "loop.tmp", "sweep_000001", "sweep_000002.ldp", "sweep_000003.ldp",
                                 "sweep_000003/frame_000.jpg", "sweep_000003/x.tmp", "sweep_000003/build.json"}) {
    const fs::path link = room_ / "out" / name;
    fs::create_symlink(link.filename(), link);
  }
  Process service(command({"--status", "console:"}), room_ / "said");
  EXPECT_TRUE(service.says("sweep_000004.ldp is ready", 30)) << text_of(room_ / "said");
  EXPECT_EQ(service.stop(SIGTERM).status, 0);
}

// As FUSE and some network shares are.
TEST_F(LdpdTest, AFileSystemThatCannotFlushFoldersStoresAllTheSameAndThatIsSaidOnce) {
  script(kUntilTheCameraEnds);
  const std::string rules = "fsync /out$ * EINVAL; fsync /sweep_000001$ * EINVAL";
  const Finished run = Process(with_faults(rules, command({"--once"}, "&hold=no")), room_ / "said").wait();
  EXPECT_EQ(run.status, 0) << run.said;
  EXPECT_EQ(frames_in(capture()), 14);
  EXPECT_TRUE(fs::exists(panorama()));
  const size_t at = run.said.find("cannot flush folders");
  ASSERT_NE(at, std::string::npos) << run.said;
  EXPECT_EQ(run.said.find("cannot flush folders", at + 1), std::string::npos) << run.said;
}

TEST_F(LdpdTest, ADiskThatHangsKeepsNoCancelledSweepFromEndingNorTheNextFromBeginning) {
  configure("mode = \"toggle\"\nmin_frames = 3\n");
  script("press wait 3300 release wait 100 press wait 10 release wait " + time_for_all(1500) +
         " press wait 10 release");
  const fs::path gate = room_ / "gate";
  Process service(with_faults("fsync .jpg * wait " + gate.string(), command({"--status", "console:"})), room_ / "said");
  EXPECT_TRUE(service.says("the sweep was cancelled", 10));
  for (int i = 0; i < 2000 && !fs::exists(capture(2)); ++i) std::this_thread::sleep_for(milliseconds(5));
  EXPECT_TRUE(fs::exists(capture(2)));
  write_file(gate, std::vector<uint8_t>(1));
  EXPECT_TRUE(service.says("sweep_000002.ldp is ready", 30)) << text_of(room_ / "said");
  EXPECT_FALSE(fs::exists(capture(1)));
  EXPECT_EQ(service.stop(SIGTERM).status, 0);
}

// Three frames are there and the fourth is being written.
TEST_F(LdpdTest, ARetryWhileACancelledSweepIsStillBeingWrittenLeavesThatAlone) {
  NEEDS_MULTICAST();
  configure("mode = \"toggle\"\nmin_frames = 3\n", "follow = false\n");
  script("wait 1");
  const std::string url = "lcm:" + private_network();
  const fs::path gate = room_ / "gate";
  Process service(
      with_faults("fsync .jpg 4+ wait " + gate.string(), command({"--status", "console:", "--status", url})),
      room_ / "said");
  ASSERT_TRUE(service.says("ready"));
  const auto person = open_status_listener(url);
  person->send(Command::press);
  ASSERT_TRUE(service.says("capturing")) << text_of(room_ / "said");
  ASSERT_TRUE(service.says("stored: 3 frames")) << text_of(room_ / "said");
  ASSERT_TRUE(becomes_true([&] { return has_temporary(capture()); }));
  person->send(Command::cancel);
  ASSERT_TRUE(service.says("the sweep was cancelled"));
  for (int i = 0; i < 3; ++i) person->send(Command::retry);
  person->send(Command::press);  // comes after them
  ASSERT_TRUE(becomes_true([&] { return fs::exists(capture(2)); })) << text_of(room_ / "said");
  EXPECT_TRUE(has_temporary(capture()));
  write_file(gate, std::vector<uint8_t>(1));
  EXPECT_TRUE(becomes_true([&] { return !fs::exists(capture()); }));
  const std::string said = service.stop(SIGTERM).said;
  EXPECT_THAT(said, Not(HasSubstr("cannot store")));
  EXPECT_THAT(said, Not(HasSubstr("building sweep_000001")));
}

TEST_F(LdpdTest, ACancelledSweepWhoseRemovalIsCutOffIsNotBuiltByTheNextStart) {
  configure("mode = \"toggle\"\nmin_frames = 3\n");
  script("press wait 3300 release wait 600000");
  const std::string rules = "unlink .jpg 5+ wait " + (room_ / "never").string();
  {
    Process service(with_faults(rules, command({"--status", "console:"})), room_ / "said");
    ASSERT_TRUE(service.says("stored: "));
    for (int i = 0; i < 2000 && fs::exists(capture()); ++i) std::this_thread::sleep_for(milliseconds(5));
    service.stop(SIGKILL);
  }
  EXPECT_FALSE(fs::exists(capture()));
  script("wait 1");
  Process again(command({"--status", "console:"}), room_ / "said2");
  ASSERT_TRUE(again.says("ready"));
  EXPECT_EQ(again.stop(SIGTERM).status, 0);
  EXPECT_FALSE(fs::exists(capture()));
  EXPECT_TRUE(fs::is_empty(room_ / "out" / ".building"));
  EXPECT_THAT(text_of(room_ / "said2"), Not(HasSubstr("sweep_000001")));
}

TEST_F(LdpdTest, ADiskThatHangsDoesNotKeepTheServiceFromEnding) {
  script("press wait 600000 release");
  const std::string rules = "fsync .jpg 3+ wait " + (room_ / "never").string();
  {
    Process service(with_faults(rules, command({"--status", "console:"})), room_ / "said");
    ASSERT_TRUE(service.says("stored: 2 frames"));
    ::kill(service.pid(), SIGTERM);
    EXPECT_TRUE(service.ends_within(15));
    const Finished end = service.stop(SIGKILL);
    EXPECT_EQ(end.status, 0);
    EXPECT_THAT(end.said, HasSubstr("the disk does not answer"));
    EXPECT_EQ(frames_in(capture()), 2);
  }
  Process once(with_faults(rules, command({"--once", "--status", "console:"})), room_ / "said2");
  ASSERT_TRUE(once.says("stored: 2 frames"));
  ::kill(once.pid(), SIGINT);
  ASSERT_TRUE(once.says("once more to leave at once"));
  const auto begin = Clock::now();
  EXPECT_EQ(once.stop(SIGINT).status, 1);
  EXPECT_LT(Clock::now() - begin, milliseconds(2000));
}

TEST_F(LdpdTest, ACancelledLdpCaptureLeavesNoFrame) {
  script("press wait 3300 release");
  const Finished run = Process({LDP_DEVICE_PROGRAM, "capture", "--mode", "toggle", "--camera",
                                "folder:" + (room_ / "frames").string() + "?fps=60", "--button",
                                "script:" + (room_ / "script").string(), "-o", (room_ / "one").string()},
                               room_ / "said")
                           .wait();
  EXPECT_EQ(run.status, 1);
  EXPECT_THAT(run.said, HasSubstr("its frames were removed"));
  EXPECT_FALSE(fs::exists(room_ / "one"));
}

TEST_F(LdpdTest, EveryRefusalOfASweepIsToldHoweverManyInARow) {
  script("press wait 200 release wait 500 press wait 200 release wait 600000");
  std::vector<std::string> words = command({"--status", "console:"});
  words[4] = "folder:" + (room_ / "nowhere").string();
  Process service(words, room_ / "said");
  const auto refusals = [&] {
    const std::string said = text_of(room_ / "said"),
                      refusal = "failed: " + (room_ / "nowhere").string() + ": there is no such folder";
    int count = 0;
    for (size_t at = 0; (at = said.find(refusal, at)) != std::string::npos; ++at) ++count;
    return count;
  };
  for (int i = 0; i < 2000 && refusals() < 2; ++i) std::this_thread::sleep_for(milliseconds(5));
  EXPECT_EQ(refusals(), 2);
}

// What is said would be written into whatever file is opened next.
TEST_F(LdpdTest, StandardStreamsThatAreClosedGetIntoNoFile) {
  script(kUntilTheCameraEnds);
  Process service(command({"--once", "--status", "console:"}, "&hold=no"), room_ / "said", [] {
    for (const int fd : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) ::close(fd);
  });
  EXPECT_EQ(service.wait().status, 0);
  EXPECT_EQ(frames_in(capture()), 14);
  EXPECT_TRUE(fs::is_empty(room_ / "out" / ".lock"));
  expect_whole(true);
}

TEST_F(LdpdTest, StandardErrorThatNobodyEmptiesHoldsUpNothing) {
  script(kUntilTheCameraEnds);
  int ends[2];
  ASSERT_EQ(::pipe2(ends, O_CLOEXEC), 0);
  const std::string noise(static_cast<size_t>(::fcntl(ends[1], F_SETPIPE_SZ, 4096)), 'x');
  ASSERT_EQ(::write(ends[1], noise.data(), noise.size()), static_cast<ssize_t>(noise.size()));
  Process service(command({"--once", "--status", "console:"}, "&hold=no"), room_ / "said",
                  [&] { ::dup2(ends[1], STDERR_FILENO); });
  EXPECT_TRUE(service.ends_within(30));
  EXPECT_TRUE(fs::exists(panorama()));
  for (const int end : ends) ::close(end);
}

TEST_F(LdpdTest, ABuildThatFoundNoRoomIsBegunAgainByTheNextStart) {
  script(kUntilTheCameraEnds);
  build_program("echo 'ldp build: cannot write: No space left on device' >&2; exit 75");
  EXPECT_EQ(run_once().status, 1);
  EXPECT_FALSE(fs::exists(panorama()));
  build_program("true");
  script("wait 600000");
  Process service(command({"--status", "console:"}), room_ / "said");
  EXPECT_TRUE(service.says("sweep_000001.ldp is ready", 30)) << text_of(room_ / "said");
  EXPECT_EQ(service.stop(SIGTERM).status, 0);
}

// Of another user, or on a bad block.
TEST_F(LdpdTest, WhatCannotBeRemovedFromUnfinishedBuildsKeepsNoneFromBeingBuilt) {
  script(kUntilTheCameraEnds);
  fs::create_directories(room_ / "out" / ".building");
  std::ofstream(room_ / "out" / ".building" / "stuck") << "x";
  const Finished run =
      Process(with_faults("unlink stuck * EACCES", command({"--once"}, "&hold=no")), room_ / "said").wait();
  EXPECT_EQ(run.status, 0) << run.said;
  EXPECT_TRUE(fs::exists(panorama()));
  EXPECT_THAT(run.said, HasSubstr("cannot remove"));
}

}  // namespace
}  // namespace ldp
