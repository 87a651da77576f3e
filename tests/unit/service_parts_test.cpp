// Parts of the service, each alone: what it says, its loop, its button, its notices, the folders of its sweeps.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <set>
#include <thread>

#include "device/service/builds/build_queue.h"
#include "device/service/events/button_port.h"
#include "device/service/events/end_request.h"
#include "device/service/events/last_frames.h"
#include "device/service/events/poll_loop.h"
#include "device/service/events/service_notice.h"
#include "device/service/reasons.h"
#include "device/service/session_tuning.h"
#include "device/service/sweep_folders.h"
#include "drivers/interface/clocks.h"
#include "drivers/led_light.h"
#include "drivers/led_pattern.h"

namespace ldp {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

class Room : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = testing::TempDir() + "ldp_parts_XXXXXX";
    room_ = mkdtemp(name.data());
  }
  void TearDown() override { fs::remove_all(room_); }

  fs::path room_;
};

// --- reasons ---------------------------------------------------------------------------------------------------------

constexpr int kReasons = static_cast<int>(Why::ready_without_button) + 1;

TEST(Reasons, EveryOneIsOneLineAndNoTwoAreTheSame) {
  std::set<std::string> told;
  for (int i = 1; i < kReasons; ++i) {
    const std::string text = text_of({static_cast<Why>(i), "detail " + std::to_string(i)});
    EXPECT_NE(text, "") << i;
    EXPECT_EQ(text.find('\n'), std::string::npos) << text;
    EXPECT_TRUE(told.insert(text).second) << text;
  }
  EXPECT_EQ(text_of({}), "");
}

TEST(Reasons, TellWhatABackEndSaid) {
  for (const Why why :
       {Why::camera_lost, Why::storage_failed, Why::cannot_begin, Why::too_few_frames, Why::build_failed})
    EXPECT_EQ(text_of({why, "it broke"}), "it broke");
  for (const Why why : {Why::button_lost, Why::built, Why::built_but_poor, Why::captured, Why::ready_without_button})
    EXPECT_THAT(text_of({why, "gpiod:7"}), AllOf(HasSubstr("gpiod:7"), Not(testing::StrEq("gpiod:7"))));
  EXPECT_THAT(text_of({Why::built_but_poor, "a.ldp"}), HasSubstr("sweep again"));
  EXPECT_THAT(text_of({Why::held_to_cancel, {}}), HasSubstr(std::to_string(kLongPress_s) + " s"));
}

TEST(Reasons, NumbersHaveTheirUnits) {
  EXPECT_EQ(frames_text(0), "0 frames");
  EXPECT_EQ(frames_text(1), "1 frame");
  EXPECT_EQ(frames_text(12), "12 frames");
  EXPECT_EQ(seconds_text(12.34), "12.3 s");
  EXPECT_EQ(seconds_text(0), "0.0 s");
}

TEST(Reasons, AShortSweepNamesWhatMadeItShortAndWhatToDo) {
  ShortSweep sweep;
  sweep.frames = 2, sweep.frames_needed = 4, sweep.seconds = 1.5, sweep.covered_rad = 0.5;
  for (const Why person : {Why::ended_by_button, Why::ended_by_command}) {
    sweep.end = {person, {}};
    EXPECT_EQ(too_few_frames(sweep).why, Why::too_few_frames);
    EXPECT_EQ(
        text_of(too_few_frames(sweep)),
        "only 2 frames, at least 4 are needed: the sweep lasted 1.5 s and turned by 29 degrees: press, turn slowly "
        "through at least a quarter circle, press again");
  }
  sweep.mode = ButtonMode::hold;
  sweep.end = {Why::sweep_complete, {}};
  EXPECT_THAT(text_of(too_few_frames(sweep)),
              AllOf(HasSubstr("hold the button while you turn"), Not(HasSubstr("again"))));
  sweep.end = {Why::camera_lost, "the cable was pulled"};
  EXPECT_EQ(text_of(too_few_frames(sweep)), "only 2 frames, at least 4 are needed: the cable was pulled");
  sweep.storage_problem = {Why::storage_failed, "the disk is full",
                           std::make_error_code(std::errc::no_space_on_device)};
  EXPECT_EQ(text_of(too_few_frames(sweep)), "only 2 frames, at least 4 are needed: the disk is full");
  EXPECT_EQ(too_few_frames(sweep).code, std::errc::no_space_on_device);
}

// --- the loop --------------------------------------------------------------------------------------------------------

struct Pipe {
  Pipe() {
    if (::pipe(ends) != 0) throw std::runtime_error("no pipe");
  }
  ~Pipe() {
    for (const int fd : ends)
      if (fd >= 0) ::close(fd);
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  void fill() const { EXPECT_EQ(::write(ends[1], "x", 1), 1); }
  void drain() const {
    char c = 0;
    EXPECT_EQ(::read(ends[0], &c, 1), 1);
  }
  void hang_up() { ::close(std::exchange(ends[1], -1)); }
  int fd() const { return ends[0]; }
  int ends[2] = {-1, -1};
};

int64_t soon() { return monotonic_now_ns() + kSecond_ns / 50; }
int64_t late() { return monotonic_now_ns() + 20 * kSecond_ns; }

TEST(PollLoop, ServesWhatIsReadableAndNothingElse) {
  const Pipe a, b;
  int of_a = 0, of_b = 0;
  const auto watches = [&] {
    return Watches{{a.fd(), [&] { ++of_a, a.drain(); }}, {-1, [] { FAIL(); }}, {b.fd(), [&] { ++of_b, b.drain(); }}};
  };
  b.fill();
  wait_and_serve(watches, late());
  EXPECT_EQ(of_a, 0);
  EXPECT_EQ(of_b, 1);
  a.fill(), b.fill();
  wait_and_serve(watches, late());
  EXPECT_EQ(of_a, 1);
  EXPECT_EQ(of_b, 2);
}

TEST(PollLoop, SleepsUntilItsDeadlineAndNoLonger) {
  const Pipe quiet;
  const auto watches = [&] { return Watches{{quiet.fd(), [] { FAIL() << "nothing was there to serve"; }}}; };
  const int64_t deadline_ns = soon();
  wait_and_serve(watches, deadline_ns);
  EXPECT_GE(monotonic_now_ns(), deadline_ns);
  EXPECT_LT(monotonic_now_ns(), deadline_ns + 10 * kSecond_ns);
  wait_and_serve(watches, 0);  // long over
}

TEST(PollLoop, AnEndThatHangsUpIsServed) {
  Pipe pipe;
  pipe.hang_up();
  int served = 0;
  wait_and_serve([&] { return Watches{{pipe.fd(), [&] { ++served; }}}; }, late());
  EXPECT_EQ(served, 1);
}

TEST(PollLoop, WhatServingOneClosedIsNotServed) {
  const Pipe a, b;
  a.fill(), b.fill();
  bool b_is_there = true;
  int of_b = 0;
  const auto watches = [&] {
    Watches all{{a.fd(), [&] { a.drain(), b_is_there = false; }}};
    if (b_is_there) all.push_back({b.fd(), [&] { ++of_b; }});
    return all;
  };
  wait_and_serve(watches, late());
  EXPECT_EQ(of_b, 0) << "it was closed, or is another one by now";
}

TEST(PollLoop, OneOpenedInPlaceOfAnotherWaitsForTheNextTurn) {
  const Pipe a, b, c;
  a.fill(), b.fill(), c.fill();
  bool swapped = false;
  std::vector<char> served;
  const auto watches = [&] {
    return Watches{{a.fd(), [&] { served.push_back('a'), swapped = true, a.drain(); }},
                   {swapped ? c.fd() : b.fd(), [&] { served.push_back(swapped ? 'c' : 'b'), c.drain(); }}};
  };
  wait_and_serve(watches, late());
  EXPECT_THAT(served, ElementsAre('a'));
  wait_and_serve(watches, late());
  EXPECT_THAT(served, ElementsAre('a', 'c'));
}

// --- being asked to end ----------------------------------------------------------------------------------------------

bool readable(int fd, int milliseconds = 0) {
  pollfd entry{fd, POLLIN, 0};
  return ::poll(&entry, 1, milliseconds) == 1;
}

TEST(EndRequest, IsTakenOnceFromAStopToken) {
  std::stop_source source;
  EndRequest request(source.get_token());
  EXPECT_FALSE(readable(request.fd()));
  EXPECT_FALSE(request.take());
  source.request_stop();
  EXPECT_TRUE(readable(request.fd()));
  EXPECT_TRUE(request.waits());
  EXPECT_TRUE(request.take());
  EXPECT_FALSE(request.waits());
  EXPECT_FALSE(request.take());
  EXPECT_FALSE(readable(request.fd()));
}

TEST(EndRequest, IsTakenOnceFromEachOfTheEndingSignals) {
  sigset_t before;
  ::pthread_sigmask(SIG_SETMASK, nullptr, &before);
  EndRequest request{std::stop_token()};
  EXPECT_FALSE(request.take());
  for (const int signal : {SIGTERM, SIGINT, SIGHUP}) {
    ::kill(::getpid(), signal);
    EXPECT_TRUE(readable(request.fd(), 10'000)) << signal;
    EXPECT_TRUE(request.take()) << signal;
    EXPECT_FALSE(request.take()) << signal;
  }
  ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

// --- the button ------------------------------------------------------------------------------------------------------

TEST_F(Room, AMissingButtonIsTriedAgainFromTimeToTimeOnly) {
  ButtonPort port("script:" + (room_ / "script").string());
  EXPECT_THROW(port.open(), std::runtime_error);
  EXPECT_EQ(port.fd(), -1);
  EXPECT_FALSE(port.try_again(1));
  std::ofstream(room_ / "script") << "press\n";
  EXPECT_FALSE(port.try_again(kButtonRetry_s * kSecond_ns)) << "before its time";
  EXPECT_TRUE(port.try_again(1 + kButtonRetry_s * kSecond_ns));
  EXPECT_TRUE(port.is_open());
  EXPECT_GE(port.fd(), 0);
  EXPECT_FALSE(port.try_again(100 * kSecond_ns)) << "it is there";
  ASSERT_TRUE(readable(port.fd(), 10'000));
  EXPECT_TRUE(port.read()->pressed);
  port.close();
  EXPECT_FALSE(port.is_open());
}

TEST(ButtonPort, APressThatLastsIsALongOneOnce) {
  ButtonPort port("keyboard:");
  const int64_t long_ns = kLongPress_s * kSecond_ns;
  EXPECT_EQ(port.next_hold_at_ns(), std::nullopt);
  EXPECT_EQ(port.take_hold(100 * long_ns), std::nullopt);
  port.note({true, 1000});
  EXPECT_EQ(port.next_hold_at_ns(), 1000 + long_ns);
  EXPECT_EQ(port.take_hold(999 + long_ns), std::nullopt);
  EXPECT_EQ(port.take_hold(1000 + long_ns), Hold::cancels);
  EXPECT_EQ(port.take_hold(2000 + long_ns), std::nullopt) << "told twice";
  port.note({true, 5000});
  port.note({false, 6000});
  EXPECT_EQ(port.take_hold(100 * long_ns), std::nullopt) << "it was let go";
  port.note({true, 7000});
  port.close();
  EXPECT_EQ(port.next_hold_at_ns(), std::nullopt);
}

TEST(ButtonPort, AStillLongerPressSwitchesOffWhereThatIsAskedFor) {
  ButtonPort port("keyboard:", 2.0 * kLongPress_s);
  const int64_t long_ns = kLongPress_s * kSecond_ns;
  port.note({true, 1000});
  EXPECT_EQ(port.take_hold(1000 + long_ns), Hold::cancels);
  EXPECT_EQ(port.next_hold_at_ns(), 1000 + 2 * long_ns);
  EXPECT_EQ(port.take_hold(999 + 2 * long_ns), std::nullopt);
  EXPECT_EQ(port.take_hold(1000 + 2 * long_ns), Hold::switches_off);
  EXPECT_EQ(port.take_hold(9 * long_ns), std::nullopt);
  port.note({true, 5000});
  EXPECT_EQ(port.next_hold_at_ns(), 5000 + long_ns) << "another press begins anew";
}

// --- notices to systemd ----------------------------------------------------------------------------------------------

class Notices : public Room {
 protected:
  void SetUp() override {
    Room::SetUp();
    socket_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    const std::string path = (room_ / "notify").string();
    path.copy(address.sun_path, sizeof address.sun_path - 1);
    ASSERT_EQ(::bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    ::setenv("NOTIFY_SOCKET", path.c_str(), 1);
  }
  void TearDown() override {
    for (const char* const name : {"NOTIFY_SOCKET", "WATCHDOG_USEC", "WATCHDOG_PID"}) ::unsetenv(name);
    ::close(socket_);
    Room::TearDown();
  }
  std::vector<std::string> heard() const {
    std::vector<std::string> all;
    char text[256];
    for (ssize_t got = 0; (got = ::recv(socket_, text, sizeof text, 0)) > 0;) all.emplace_back(text, got);
    return all;
  }

  int socket_ = -1;
};

TEST_F(Notices, AreTheWordsThatSystemdKnows) {
  ServiceNotice notice;
  notice.ready();
  notice.status("idle: ready");
  notice.still_stopping(10);
  notice.stopping();
  EXPECT_THAT(heard(), ElementsAre("READY=1", "STATUS=idle: ready", "EXTEND_TIMEOUT_USEC=10000000", "STOPPING=1"));
  notice.feed_watchdog(1);
  EXPECT_EQ(notice.watchdog_deadline_ns(), std::nullopt);
  EXPECT_THAT(heard(), ElementsAre()) << "nobody asked for a watchdog";
}

TEST_F(Notices, TheWatchdogIsFedThreeTimesInItsTime) {
  ::setenv("WATCHDOG_USEC", "3000000", 1);
  ServiceNotice notice;
  notice.feed_watchdog(0);
  EXPECT_EQ(notice.watchdog_deadline_ns(), kSecond_ns);
  notice.feed_watchdog(kSecond_ns - 1);
  EXPECT_THAT(heard(), ElementsAre("WATCHDOG=1"));
  notice.feed_watchdog(kSecond_ns);
  EXPECT_THAT(heard(), ElementsAre("WATCHDOG=1"));
  EXPECT_EQ(notice.watchdog_deadline_ns(), 2 * kSecond_ns);
}

TEST_F(Notices, AWatchdogOfAnotherProcessIsLeftToIt) {
  ::setenv("WATCHDOG_USEC", "3000000", 1);
  ::setenv("WATCHDOG_PID", "1", 1);
  EXPECT_EQ(ServiceNotice().watchdog_deadline_ns(), std::nullopt);
  ::setenv("WATCHDOG_PID", std::to_string(::getpid()).c_str(), 1);
  EXPECT_NE(ServiceNotice().watchdog_deadline_ns(), std::nullopt);
}

TEST_F(Notices, NobodyWhoListensIsNoFault) {
  for (const std::string& socket : {std::string(), std::string(300, 'a'), (room_ / "nowhere").string()}) {
    ::setenv("NOTIFY_SOCKET", socket.c_str(), 1);
    ServiceNotice().ready();
  }
  EXPECT_THAT(heard(), ElementsAre());
}

// --- folders of sweeps and their builds ------------------------------------------------------------------------------

TEST_F(Room, ACancelledSweepGoesWhenNothingIsWrittenIntoItAnyMore) {
  const CaptureStore store(room_);
  store.prepare();
  const Config config;
  SweepFolders folders(config, store, false);
  const std::string name = folders.create();
  const fs::path folder = folders.of(name);
  EXPECT_TRUE(fs::is_directory(folder));
  FrameWriter writer;
  ASSERT_EQ(::mkfifo((folder / "frame_000.jpg").c_str(), 0600), 0);  // a disk that does not answer until it is read
  writer.put({folder, "frame_000.jpg", {1, 2, 3}, ""});
  folders.cancel(name, writer);
  std::ifstream disk;
  if (writer.pending() > 0) {  // the write had begun
    EXPECT_TRUE(fs::exists(folder)) << "it went while it was written into";
    disk.open(folder / "frame_000.jpg");
  }
  while (writer.pending() > 0) {
    readable(writer.fd(), 1000);
    writer.take();
    folders.discard_cancelled(writer);
  }
  EXPECT_FALSE(fs::exists(folder));
  EXPECT_NE(folders.create(), name);
}

TEST_F(Room, TheFolderOfASingleCaptureIsTheOutputItselfAndNeverRemoved) {
  Config config;
  config.output = (room_ / "mine").string();
  fs::create_directory(config.output);
  const CaptureStore store(config.output);
  const SweepFolders folders(config, store, true);
  EXPECT_EQ(folders.create(), "mine");
  EXPECT_EQ(folders.of("mine"), config.output);
  folders.discard("mine");
  EXPECT_TRUE(fs::exists(config.output));
  SweepFolders(config, store, false).discard("");
  EXPECT_TRUE(fs::exists(config.output)) << "a sweep without a name is the output folder";
}

TEST_F(Room, WhatWasPutFirstIsBuiltFirst) {
  const CaptureStore store(room_);
  store.prepare();
  const Config config;
  for (int i = 0; i < 4; ++i) {
    const fs::path folder = store.folder_of(store.create_capture());
    const int frames = i < 3 ? config.min_frames : config.min_frames - 1;
    for (int k = 0; k < frames; ++k) std::ofstream(folder / ("frame_00" + std::to_string(k) + ".jpg")) << "x";
  }
  std::ofstream(store.panorama_of("sweep_000002")) << "built";
  store.write_build_record("sweep_000003", {0, false, true, "too few frames"});
  BuildQueue queue(config, store);
  EXPECT_FALSE(queue.waits());
  queue.add_unfinished();
  ASSERT_TRUE(queue.waits());
  queue.put_first("sweep_000009");
  EXPECT_EQ(queue.take_next(), "sweep_000009");
  EXPECT_EQ(queue.take_next(), "sweep_000001");
  EXPECT_FALSE(queue.waits()) << "built and failed ones are left alone";
  queue.add_failed();
  ASSERT_TRUE(queue.waits());
  EXPECT_EQ(queue.take_next(), "sweep_000001");
  EXPECT_EQ(queue.take_next(), "sweep_000003");
  EXPECT_FALSE(queue.waits());
  EXPECT_FALSE(store.read_build_record("sweep_000003").failed) << "the verdict is forgotten";
}

TEST_F(Room, TheLastFramesAreWaitedForAndLeftWhenAskedTwice) {
  std::stop_source source;
  EndRequest request(source.get_token());
  ServiceNotice notice;
  FrameWriter writer;
  for (int i = 0; i < 20; ++i) writer.put({room_, "frame_" + std::to_string(i) + ".jpg", {1, 2}, ""});
  int taken = 0;
  wait_for_last_frames({writer, request, notice, false, [&] {
                          while (writer.take()) ++taken;
                        }});
  EXPECT_EQ(taken, 20);
  EXPECT_EQ(writer.pending(), 0U);
  source.request_stop();
  writer.put({room_ / "nowhere", "frame.jpg", {1}, ""});
  wait_for_last_frames({writer, request, notice, true, [] {}});  // nobody takes what is done: asked again, it leaves
  EXPECT_EQ(writer.pending(), 1U);
}

// --- the LED ---------------------------------------------------------------------------------------------------------

struct Look {
  int lit = 0, changes = 0;  // steps, and times that it goes on or off, of a round
  friend bool operator==(const Look&, const Look&) = default;
};

Look look_of(LedSign sign) {
  Look look;
  const uint16_t pattern = led_pattern(sign);
  for (int i = 0; i < kLedSteps; ++i) {
    look.lit += is_lit(pattern, i) ? 1 : 0;
    look.changes += is_lit(pattern, i) != is_lit(pattern, i + 1) ? 1 : 0;
  }
  return look;
}

TEST(LedPattern, LooksAsTheTableSays) {
  EXPECT_EQ(look_of(LedSign::ready), (Look{1, 2}));
  EXPECT_EQ(look_of(LedSign::sweep), (Look{16, 0}));
  EXPECT_EQ(look_of(LedSign::too_fast), (Look{8, 8}));
  EXPECT_EQ(look_of(LedSign::building), (Look{8, 4}));
  EXPECT_EQ(look_of(LedSign::good), (Look{8, 2}));
  EXPECT_EQ(look_of(LedSign::sweep_again), (Look{2, 4}));
  EXPECT_EQ(look_of(LedSign::full), (Look{3, 6}));
  EXPECT_EQ(look_of(LedSign::failed), (Look{8, 16}));
}

TEST(LedPattern, NoTwoSignsLookTheSameAndNoneIsDark) {
  std::set<std::pair<int, int>> looks;
  for (const LedSign sign : kLedSigns) {
    const Look look = look_of(sign);
    EXPECT_GT(look.lit, 0);
    EXPECT_TRUE(looks.emplace(look.lit, look.changes).second);
  }
}

// Walked from change to change, a pattern looks as it does step by step, for some rounds.
TEST(LedPattern, IsWokenWhenItChangesAndNotBetween) {
  for (const LedSign sign : kLedSigns) {
    const uint16_t pattern = led_pattern(sign);
    int64_t changes_at = 0;
    int wakes = 0;
    for (int64_t step = 1; step <= 3 * kLedSteps; ++step) {
      if (is_lit(pattern, step) == is_lit(pattern, step - 1)) continue;
      ASSERT_TRUE(steps_to_change(pattern, changes_at).has_value());
      EXPECT_EQ(changes_at + *steps_to_change(pattern, changes_at), step);
      changes_at = step;
      ++wakes;
    }
    EXPECT_EQ(wakes, 3 * look_of(sign).changes);
  }
  EXPECT_EQ(steps_to_change(led_pattern(LedSign::sweep), 5), std::nullopt);
  EXPECT_EQ(steps_to_change(led_pattern(LedSign::ready), 7), 9);  // between two changes, too
}

TEST(LedLight, WakesTheCameraWhenItChangesAndNotBetween) {
  std::vector<bool> set;
  LedLight light([&set](bool lit) { set.push_back(lit); });
  const int64_t end_ns = monotonic_now_ns() + 6 * kLedStep_ns;
  light.show(led_pattern(LedSign::ready));
  int wakes = 0;
  for (bool over = false; !over;) {
    const int64_t left_ns = end_ns - monotonic_now_ns();
    over = left_ns <= 0;
    pollfd entry{light.fd(), POLLIN, 0};
    if (::poll(&entry, 1, over ? 0 : static_cast<int>(left_ns / 1'000'000) + 1) != 1) continue;
    light.wake();
    ++wakes;
  }
  EXPECT_EQ(wakes, 1);
  EXPECT_EQ(set, (std::vector{true, false}));
}

TEST(LedSign, TellsWhatWasSaidLast) {
  EXPECT_EQ(led_sign({}), LedSign::ready);
  EXPECT_EQ(led_sign({.has_room = false}), LedSign::full);
  EXPECT_EQ(led_sign({.phase = Phase::capturing}), LedSign::sweep);
  EXPECT_EQ(led_sign({.phase = Phase::capturing, .advice = Advice::slower}), LedSign::too_fast);
  EXPECT_EQ(led_sign({.phase = Phase::capturing, .advice = Advice::faster}), LedSign::sweep);
  EXPECT_EQ(led_sign({.phase = Phase::building, .has_room = false, .advice = Advice::slower}), LedSign::building);
  for (const Judgement judgement : {Judgement::none, Judgement::good, Judgement::fair})
    EXPECT_EQ(led_sign({.phase = Phase::done, .has_room = false, .judgement = judgement}), LedSign::good);
  EXPECT_EQ(led_sign({.phase = Phase::done, .judgement = Judgement::sweep_again}), LedSign::sweep_again);
  EXPECT_EQ(led_sign({.phase = Phase::failed}), LedSign::failed);
  EXPECT_EQ(led_sign({.phase = Phase::failed, .has_room = false}), LedSign::full);
  EXPECT_EQ(led_sign({.phase = Phase::idle, .judgement = Judgement::sweep_again}), LedSign::ready);
}

}  // namespace
}  // namespace ldp
