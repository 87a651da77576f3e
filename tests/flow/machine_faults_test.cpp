// The program `ldp` on a machine that lacks something: room, memory, threads, descriptors.

#include <chrono>
#include <thread>

#include "core/base/files.h"
#include "core/panorama/file/ldp_file.h"
#include "core/photos/images.h"
#include "tests/flow/outputs.h"
#include "tests/sanitizers.h"

namespace ldp {
namespace {

std::vector<std::string> with_faults(const std::string& rules) {
  return {"env", "LD_PRELOAD=" LDP_FAULTS, "LDP_FAULTS=" + rules, "LDP_FAULTS_IN=ldp"};
}

TEST_F(Outputs, AFullDiskIsToldByTheUsersOwnNames) {
  const std::string file = small_panorama();
  // Files may have 1 KiB, as if the disk were full.
  const std::vector<std::string> full{"bash", "-c", "ulimit -f 1; trap '' XFSZ; exec \"$0\" \"$@\""};
  expect_refusal(render_path(file, path("views"), 2), 1, "cannot write " + path("views/frame_000.png"), full);
  expect_refusal({"scene", "room", "-o", path("room"), "--frames", "2", "--size", "64x48"}, 1,
                 "cannot write " + path("room/frames/000.png"), full);
  expect_refusal({"export", file, "-o", path("a.png")}, 1, "cannot write " + path("a.png"), full);
  expect_refusal(render_path(file, path("film.mp4"), 2), 1,
                 path("film.mp4") + ": ffmpeg failed: " + path("film.mp4") + ": is no name",
                 with_ffmpeg("echo \"$film: is no name\" >&2; echo and more >&2; exit 1"));
}

TEST_F(Outputs, AFileBeyondALimitIsToldAndLeavesNothing) {
  const std::string file = small_panorama();
  const std::vector<std::string> limited{"bash", "-c", "ulimit -f 1; exec \"$0\" \"$@\""};
  expect_refusal(render_path(file, path("views"), 2), 1, "cannot write " + path("views/frame_000.png"), limited);
  expect_refusal({"build", path("capture"), "-o", path("b.ldp"), "--cameras", path("capture/transforms.json"),
                  "--layers", "1", "--labels", "2"},
                 1, "cannot write " + path("b.ldp") + ": File too large: choose another folder to write to\n", limited);
  expect_refusal(
      {"poses", path("capture"), "--cameras", path("capture/transforms.json"), "--colmap", path("sparse")}, 1,
      "cannot write " + path("sparse/cameras.txt") + ": Permission denied: choose another folder to write to\n",
      with_faults("write cameras.txt * EACCES"));
}

// Left to itself it writes what there is room for and ends with status 0.
TEST_F(Outputs, AFilmThatADiskHasNoRoomForReplacesNone) {
  const std::string file = small_panorama();
  for (const char* name : {"film.mp4", "film.webm", "film.gif"}) {
    for (const char* end : {"0", "1"})
      expect_refusal(render_path(file, path(name), 2), 75,
                     "cannot write " + path(name) + ": No space left on device: free some space, or write elsewhere\n",
                     with_ffmpeg("cat > /dev/null; echo half > \"$film\"; echo \"Error writing trailer of $film: No "
                                 "space left on device\" >&2; exit " +
                                 std::string(end)));
    std::ofstream(path(name)) << "of before ldp render";
    if (std::string(name) == "film.gif") fs::remove(path(name));  // which cannot tell that it is ours
    const std::string before = text_of(path(name));
    expect_refusal(render_path(file, path(name), 2), 75, "cannot write " + path(name),
                   with_ffmpeg("cat > /dev/null; echo half > \"$film\"; [[ \" $* \" == *' -xerror '* ]] || exit 0; "
                               "echo \"$film: No space left on device\" >&2; exit 1"));
    EXPECT_EQ(text_of(path(name)), before);
  }
}

TEST_F(Outputs, AnInterruptedExportLeavesNoTemporaryFileHoweverSlowTheDisk) {
  const std::string file = small_panorama();
  const auto before = contents();
  const Running exporting({"export", file, "-o", path("a.html")}, room_,
                          with_faults("fsync .html * wait " + path("never")));
  for (int i = 0; i < 2000 && contents() == before; ++i) ::usleep(5000);
  EXPECT_NE(contents(), before);
  ::usleep(100'000);
  exporting.interrupt();
  const Outcome outcome = exporting.wait();
  EXPECT_EQ(outcome.status, 130);
  EXPECT_EQ(outcome.err, "ldp export: interrupted: nothing was written\n");
  EXPECT_EQ(contents(), before);
}

TEST_F(Outputs, AnInterruptionAfterTheFirstResultDoesNotTellThatThereIsNone) {
  const std::string from = capture();
  const Running building({"build", from, "-o", path("a.ldp"), "--cameras", from + "/transforms.json", "--layers", "1",
                          "--labels", "2", "--report", path("report.json")},
                         room_, with_faults("fsync report * wait " + path("never")));
  for (int i = 0; i < 6000 && !fs::exists(path("a.ldp")); ++i) ::usleep(5000);
  ::usleep(100'000);
  building.interrupt();
  const Outcome outcome = building.wait();
  EXPECT_EQ(outcome.status, 130);
  EXPECT_EQ(outcome.err, "ldp build: interrupted: what was written before is whole\n");
  EXPECT_EQ(ldp({"verify", path("a.ldp")}).status, 0);
  EXPECT_FALSE(fs::exists(path("report.json")));
}

TEST_F(Outputs, AnInterruptionInTheLastMomentIsToldToo) {
  const std::string cameras = path("cameras.json");
  for (int i = 0; i < 10; ++i) {
    fs::remove(cameras);
    const Running exporting({"export", LDP_SOURCE "/tests/golden/tiny.ldp", "-o", cameras}, room_);
    const auto late = std::chrono::steady_clock::now() + std::chrono::seconds(30);
    while (!fs::exists(cameras) && std::chrono::steady_clock::now() < late) std::this_thread::yield();
    exporting.interrupt();
    const Outcome outcome = exporting.wait();
    if (outcome.status == 130)  // or it had ended
      EXPECT_EQ(outcome.err, "ldp export: interrupted: what was written before is whole\n");
    else
      EXPECT_EQ(outcome.status, 0) << outcome.err;
  }
}

TEST_F(Outputs, ABuildGoesOnWithTheThreadsItHas) {
  NOT_UNDER_THREAD_SANITIZER("its own thread counts among those that can be started");
  const std::vector<uint8_t> wanted = read_file(small_panorama());
  const std::vector<std::string> words{
      "build", path("capture"), "-o", path("b.ldp"), "--cameras", path("capture/transforms.json"), "--layers",
      "1",     "--labels",      "2",  "--threads",   "8"};
  for (const char* const allowed : {"2", "3", "20"}) {
    const Outcome built = Running(words, room_, with_faults(std::string("thread - ") + allowed + "+ EAGAIN")).wait();
    EXPECT_EQ(built.status, 0) << built.err;
    EXPECT_TRUE(read_file(path("b.ldp")) == wanted);
  }
}

TEST_F(Outputs, MemoryThatEndsInALibrarysThreadIsToldInALineAndOtherEndsAreNotHidden) {
  const auto while_a_thread_throws = [&](const std::string& what) {
    return std::vector<std::string>{"bash", "-c",
                                    "ulimit -c 0; LDP_FOLDER=" + path("") + " LDP_THROWS=" + what +
                                        " LD_PRELOAD=" LDP_THREAD_THROWS " exec \"$0\" \"$@\""};
  };
  const std::vector<std::string> scene{"scene", "room", "-o", path("room"), "--frames", "30", "--size", "800x600"};
  expect_refusal(scene, 75, "ldp scene: not enough memory: make smaller pictures (--size)\n",
                 while_a_thread_throws("bad_alloc"));
  expect_refusal(scene, 75, "ldp scene: not enough memory: make smaller pictures (--size)\n",
                 while_a_thread_throws("in_a_destructor"));
  const Outcome other = Running(scene, room_, while_a_thread_throws("cause")).wait();
  EXPECT_EQ(other.status, -1);  // by a signal
  EXPECT_THAT(other.err, testing::AllOf(HasSubstr("runtime_error"), HasSubstr("what():  cause")));
}

TEST_F(Outputs, MemoryThatEndsIsToldWithWhatTheCommandCanBeTold) {
  const auto with = [](const std::string& kib) {
    return std::vector<std::string>{"bash", "-c", "ulimit -d " + kib + "; exec \"$0\" \"$@\""};
  };
  NOT_UNDER_SANITIZERS("their shadow takes more memory than a limit can tell");
  for (int i = 0; i < 4; ++i) photo("big/" + std::to_string(i) + ".jpg", 3000, 2000);
  expect_refusal({"poses", path("big"), "--megapixels", "6"}, 75,
                 "ldp poses: not enough memory: use fewer photos, or smaller ones (--megapixels)\n", with("20000"));
  expect_refusal({"build", path("big"), "-o", path("a.ldp"), "--megapixels", "6"}, 75,
                 "smaller ones (--megapixels), or a coarser panorama (--memory)\n", with("20000"));
  expect_refusal({"scene", "room", "--size", "4096x4096", "--no-novel", "-o", path("room")}, 75,
                 "ldp scene: not enough memory: make smaller pictures (--size)", with("60000"));
}

// A kilobyte or so that declares eight layers without a pixel present.
std::string large_and_empty(const std::string& file) {
  LayeredPanorama panorama = decode_ldp(read_file(LDP_SOURCE "/tests/golden/tiny.ldp"));
  panorama.grid.width = panorama.grid.height = 1024;
  Layer layer;
  layer.depth.codes = {1024, 1024};
  layer.depth.ranges = {1, 1, BlockRange{0, 255}};
  layer.coverage = {1024, 1024};
  layer.colour = {1024, 1024};
  panorama.layers.assign(8, layer);
  write_file(file, encode_ldp(panorama, {}));
  return file;
}

TEST_F(Outputs, AFileThatDeclaresMoreThanMayBeUsedIsRefusedBeforeItIsDecoded) {
  const std::string file = large_and_empty(path("large.ldp"));
  EXPECT_LT(fs::file_size(file), 10'000U);
  const std::vector<std::vector<std::string>> commands = {{"verify", file},
                                                          {"info", file},
                                                          {"export", file, "-o", path("a.glb")},
                                                          {"render", file, "--path", "sway", "-o", path("v")}};
  for (std::vector<std::string> words : commands) {
    words.insert(words.end(), {"--memory", "2M"});
    expect_refusal(words, 1, file + ": 1024x1024 pixels in 8 layers may need ");
    expect_refusal(words, 1, " MB, allowed are 2 MB: allow more (--memory), or use a machine that has more\n");
  }
  expect_refusal({"render", file, "--path", "sway", "-o", path("v"), "--size", "8192x8192", "--memory", "256M"}, 1,
                 " of 8192x8192 may need 3221 MB, allowed are 268 MB: allow more (--memory)");
}

// What is allowed is enough: as a limit of the process it is kept, with a margin for the program itself.
TEST_F(Outputs, WhatAFileMayNeedIsNeverLessThanWhatItTakes) {
  NOT_UNDER_SANITIZERS("their shadow takes more memory than a limit can tell");
  const std::string file = large_and_empty(path("large.ldp"));
  const auto within = [](const std::string& mib) {
    return std::vector<std::string>{"bash", "-c", "ulimit -d $((" + mib + " * 1024 + 24000)); exec \"$0\" \"$@\""};
  };
  const auto run = [&](std::vector<std::string> words, const std::string& mib) {
    words.insert(words.end(), {"--threads", "1", "--memory", mib + "M"});
    const Outcome outcome = Running(words, room_, within(mib)).wait();
    EXPECT_EQ(outcome.status, 0) << words[0] << ": " << outcome.err;
  };
  run({"verify", file}, "16");
  run({"info", file}, "16");
  run({"export", file, "-o", path("a.glb")}, "112");
  run({"export", file, "-o", path("a.png")}, "112");
  run({"render", file, "--path", "sway", "--frames", "1", "--size", "64x64", "-o", path("v")}, "192");
}

// By the status: what follows a build (the service, a scheduler) tells a verdict on the photos from a bad moment.
TEST_F(Outputs, AFullDiskAsksForAnotherTimeAndPhotosThatCannotBePosedDoNot) {
  small_panorama();
  expect_refusal({"build", path("capture"), "-o", path("b.ldp"), "--cameras", path("capture/transforms.json")}, 75,
                 "No space left", with_faults("write .b.ldp * ENOSPC"));
  fs::create_directories(path("flat"));
  for (int i = 0; i < 4; ++i) write_file(path("flat/" + std::to_string(i) + ".jpg"), encode_jpeg(RgbImage(64, 48), 90));
  expect_refusal({"build", path("flat"), "-o", path("b.ldp")}, 1, "", with_faults("write nothing * ENOSPC"));
}

TEST_F(Outputs, WhatTheMachineLacksIsNotBlamedOnAName) {
  std::string deep = "deep";
  for (int i = 0; i < 30; ++i) deep += "/a";
  fs::create_directories(path(deep));
  expect_refusal({"summary", path("deep")}, 75, "Too many open files\n",
                 {"bash", "-c", "ulimit -n 20; exec \"$0\" \"$@\""});
}

TEST_F(Outputs, WhatCannotBePrintedIsNoSuccess) {
  const std::string file = small_panorama();
  const std::vector<std::string> full = {"bash", "-c", "exec \"$0\" \"$@\" > /dev/full"};
  const std::vector<std::vector<std::string>> commands = {
      {"info", file, "--json"}, {"verify", file}, {"summary", path("")}, {"build", "--help"},
      {"watch", "--help"},      {"--help"},       {"--version"}};
  for (const std::vector<std::string>& words : commands)
    expect_refusal(words, 75, "cannot write to standard output: No space left on device", full);
  expect_refusal({"info", file}, 1, "cannot write to standard output: Broken pipe",
                 {"bash", "-c", "trap '' PIPE; exec \"$0\" \"$@\" > >(exec >&- <&-; sleep 0.2)"});
}

}  // namespace
}  // namespace ldp
