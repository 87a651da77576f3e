// Service and builds killed at any moment, and a disk that fills up: what was stored stays, and is built later.
// toolchain/kills runs the long form.
#include "tests/flow/ldpd.h"

#include <random>

namespace ldp {
namespace {

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
  const Finished mounted =
      Process({"unshare", "-rm", "mount", "-t", "tmpfs", "-o", "size=32m", "none", out}, room_ / "mounted").wait();
  if (mounted.status != 0) GTEST_SKIP() << "no small disk can be mounted here: " << mounted.said;
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
      ASSERT_NE(first.status, 99) << first.said;
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
    if (HasFailure() || without_room >= 3) break;
  }
  EXPECT_GE(without_room, 3);
  EXPECT_GE(built_later, 1);
}

}  // namespace
}  // namespace ldp
