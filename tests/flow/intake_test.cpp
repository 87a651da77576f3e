// What photos may come in besides a folder: lists, archives, films, HEIC and raw photos; and what is refused of them.

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <thread>

#include "core/captures/transforms.h"
#include "tests/flow/flow.h"

namespace ldp {
namespace {

class Intakes : public Flow {
 protected:
  void SetUp() override {
    Flow::SetUp();
    folder_ = capture();
  }
  // Points of known cameras: quick, and different for different photos.
  std::vector<std::string> poses(const std::vector<std::string>& captures) const {
    std::vector<std::string> words = {"poses", "--json", "--cameras", folder_ + "/transforms.json"};
    words.insert(words.end(), captures.begin(), captures.end());
    return words;
  }
  std::string told(const std::vector<std::string>& captures, const std::vector<std::string>& through = {}) const {
    const auto before = contents();
    const Outcome outcome = Running(poses(captures), room_, through).wait();
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(contents(), before) << "something was left";
    return outcome.out;
  }
  std::vector<std::string> photos() const { return photos_in(folder_ + "/frames"); }
  static std::vector<std::string> photos_in(const std::string& folder) {
    std::vector<std::string> all;
    for (const auto& entry : fs::directory_iterator(folder)) all.push_back(entry.path());
    std::sort(all.begin(), all.end());
    return all;
  }
  // A program of that name before all others on the path.
  std::vector<std::string> with_program(const std::string& name, const std::string& script) const {
    fs::create_directories(room_ / "bin");
    std::ofstream(room_ / "bin" / name) << "#!/bin/bash\n" << script << "\n";
    fs::permissions(room_ / "bin" / name, fs::perms::owner_all);
    return in_room("PATH=" + (room_ / "bin").string() + ":/usr/bin:/bin");
  }
  std::vector<std::string> without_programs() const { return in_room("PATH=/nowhere"); }
  // Temporary files lie where `contents` sees them.
  std::vector<std::string> in_room(const std::string& path) const {
    return {"/usr/bin/env", path, "TMPDIR=" + (room_ / "work").string()};
  }
  static bool has(const std::string& program) {
    return std::system(("command -v " + program + " > /dev/null 2>&1").c_str()) == 0;
  }

  std::string folder_;
};

TEST_F(Intakes, PhotosMayBeNamedOneByOneOrInAList) {
  const std::string of_folder = told({folder_});
  std::vector<std::string> names = photos();
  std::reverse(names.begin(), names.end());
  EXPECT_EQ(told(names), of_folder) << "by name, whatever the order on the command line";
  std::ofstream list(path("list.txt"));
  for (const std::string& name : photos()) list << fs::relative(name, path("")).string() << "\r\n\n";
  list.close();
  EXPECT_EQ(told({"@" + path("list.txt")}), of_folder);
  std::ofstream turned(path("turned.txt"));
  for (const std::string& name : names) turned << name << "\n";
  turned.close();
  EXPECT_NE(told({"@" + path("turned.txt")}), of_folder) << "a list has an order of its own";
}

TEST_F(Intakes, PipesAndDevicesAreRefusedAndNotWaitedFor) {
  const std::string pipe = path("pipe");
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const std::vector<std::string> soon{"timeout", "20"};
  const std::string says = "pipe: is a pipe or a device: give the name of a regular file", first = photos().front();
  const std::vector<std::vector<std::string>> commands = {
      {"build", pipe, "-o", path("b.ldp")},
      {"build", "@" + pipe, "-o", path("b.ldp")},
      {"build", first, pipe, "-o", path("b.ldp")},
      {"poses", folder_, "--cameras", pipe},
      {"info", pipe},
      {"verify", pipe},
      {"export", pipe, "-o", path("b.jpg")},
      {"render", pipe, "--path", "sway", "-o", path("views")},
      {"render", photos().back(), "--cameras", pipe, "-o", path("views")}};
  for (const auto& words : commands) expect_refusal(words, 2, says, soon);
  for (const char* const name : {"cameras.bin", "images.bin"}) {
    fs::create_directories(path("sparse"));
    ASSERT_EQ(::mkfifo(path("sparse/" + std::string(name)).c_str(), 0600), 0);
  }
  expect_refusal({"poses", folder_, "--cameras", path("sparse")}, 2, "cameras.bin: is a pipe or a device", soon);
  fs::remove(folder_ + "/capture.json");
  ASSERT_EQ(::mkfifo((folder_ + "/capture.json").c_str(), 0600), 0);
  expect_refusal({"poses", folder_}, 2, "capture.json: is no regular file", soon);
  expect_refusal({"build", "@/dev/null", "-o", path("b.ldp")}, 2, "/dev/null: is a pipe or a device");
}

TEST_F(Intakes, WhatMayNotBeLookedAtIsNotTakenForMissing) {
  std::vector<std::string> stranger;  // root may look at everything
  if (::geteuid() == 0) stranger = {"setpriv", "--reuid", "65534", "--clear-groups"};
  fs::create_directories(path("closed/photos"));
  fs::permissions(path("closed"), fs::perms::none);
  expect_refusal({"summary", path("closed")}, 2, "closed: Permission denied: check the name and its permissions",
                 stranger);
  for (const std::string name : {"photos", "a.zip"})
    expect_refusal({"poses", path("closed/" + name)}, 2, name + ": cannot be looked at (Permission denied)", stranger);
  expect_refusal({"info", path("closed/a.ldp")}, 2, "a.ldp: cannot be looked at (Permission denied)", stranger);
  expect_refusal({"build", folder_, "-o", path("closed/photos/b.ldp")}, 2,
                 "b.ldp: cannot be written (Permission denied)", stranger);
  fs::permissions(path("closed"), fs::perms::owner_all);
}

TEST_F(Intakes, ListsThatCannotBeMeantAreRefused) {
  std::ofstream(path("empty.txt")) << "\n";
  std::ofstream(path("missing.txt")) << "none.jpg\n";
  std::ofstream(path("a.txt")) << "no photo\n";
  photo("other/000.png");
  const std::string first = photos().front();
  expect_refusal({"poses", "@" + path("empty.txt")}, 2, "empty.txt: names no photo");
  expect_refusal({"poses", "@" + path("missing.txt")}, 2, "none.jpg: there is no such file");
  expect_refusal({"poses", first, path("a.txt")}, 2, "a.txt: is no photo: of several names each must be");
  expect_refusal({"poses", first, folder_}, 2, folder_ + ": is a folder");
  expect_refusal({"poses", first, path("other/000.png")}, 2, "two photos are named 000.png");
  expect_refusal({"poses", first}, 1, "one photo only");
}

TEST_F(Intakes, AFinishedPanoramaIsNotTakenForPhotosOfOne) {
  const std::string file = LDP_SOURCE "/tests/golden/tiny.ldp";
  const std::string says = file +
                           ": is a finished panorama already, not photos of one: render views of it with ldp "
                           "render, or see what is in it with ldp info\n";
  expect_refusal({"build", file, "-o", path("b.ldp")}, 2, says);
  expect_refusal({"poses", file}, 2, says);
  expect_refusal({"poses", photos().front(), file}, 2, says);
}

class Archives : public Intakes {
 protected:
  void SetUp() override {
    Intakes::SetUp();
    std::string command = "python3 " LDP_SOURCE "/tests/flow/archives.py " + path("");
    for (const std::string& photo : photos()) command += " " + photo;
    ASSERT_EQ(std::system(command.c_str()), 0);
    if (ldp({"poses", path("none.zip")}).err.find("built without libarchive") != std::string::npos)
      GTEST_SKIP() << "no libarchive";
  }
};

TEST_F(Archives, GiveWhatTheirFolderGives) {
  EXPECT_EQ(told({path("sound.zip")}, in_room("LC_ALL=C")), told({folder_}));
  const Outcome umlauts = ldp({"poses", path("umlauts.zip")});
  EXPECT_THAT(umlauts.out, HasSubstr("\u00e4_000.png: ")) << umlauts.err;
}

TEST_F(Archives, BringTheNotesOfTheCapture) {
  const Outcome built = ldp({"build", path("sound.zip"), "--cameras", folder_ + "/transforms.json", "-o", path("a.ldp"),
                             "--iterations", "1", "--layers", "1", "--labels", "2", "--json"});
  EXPECT_THAT(built.out, HasSubstr("\"fov_degrees\": 50")) << built.err;
}

TEST_F(Archives, ThatAreNotToBeTrustedAreRefused) {
  const std::pair<const char*, const char*> refusals[] = {
      {"outside.zip", "names a file outside of itself, ../a.png"},
      {"absolute.zip", "names a file outside of itself, /tmp/a.png"},
      {"two.zip", "photos in two folders of it, a and b"},
      {"twice.zip", "two photos named a/a.png"},
      {"none.zip", "no photos in it"},
      {"bomb.zip", "holds more than 20 times its size"},
      {"many.zip", "holds more than 20000 files"},
      {"encrypted.zip", "is encrypted"},
      {"short.zip", "cannot be unpacked"}};
  for (const auto& [archive, says] : refusals)
    expect_refusal({"poses", path(archive)}, 2, std::string(archive) + ": " + says, in_room("LC_ALL=C"));
}

TEST_F(Archives, NameADamagedPhotoAsTheyHoldIt) {
  expect_refusal({"build", path("cut.zip"), "-o", path("a.ldp")}, 2, "ldp build: " + path("cut.zip") + ": 003.png: ");
  expect_refusal({"poses", path("notes.zip")}, 2, "ldp poses: " + path("notes.zip") + ": capture.json: is not a JSON");
}

// Read-only folders do not stop the administrator, unless this right is given up.
TEST_F(Archives, AreUnpackedElsewhereWhereTheOutputsFolderCannotBeWritten) {
  fs::create_directory(path("locked"));
  fs::permissions(path("locked"), fs::perms::owner_read | fs::perms::owner_exec);
  std::vector<std::string> estimate = {
      "build", path("sound.zip"), "--estimate", "-o", path("locked/a.ldp"), "--cameras", folder_ + "/transforms.json"};
  const auto in_locked = [&](const std::string& temporary) {
    std::vector<std::string> through = {"env", "-C", path("locked"), "TMPDIR=" + temporary};
    if (::geteuid() == 0) through.insert(through.end(), {"setpriv", "--bounding-set=-dac_override,-dac_read_search"});
    return through;
  };
  const auto before = contents();
  for (const char* const where : {"-o is there", "the current folder is"}) {
    const Outcome told = Running(estimate, room_, in_locked(path(""))).wait();
    EXPECT_EQ(told.status, 0) << where << ": " << told.err;
    EXPECT_THAT(told.out, HasSubstr("s of processor time"));
    EXPECT_EQ(contents(), before) << "something was left";
    estimate.erase(estimate.begin() + 3, estimate.begin() + 5);
    estimate.insert(estimate.begin() + 3, {"--labels", "2"});
  }
  expect_refusal(estimate, 2,
                 path("sound.zip") + ": cannot be unpacked, no folder can be made in " + path("locked") +
                     " (Permission denied) nor in " + path("locked") + " (Permission denied): set TMPDIR",
                 in_locked(path("locked")));
}

// Its pictures are the photos' own, as often as told; ffmpeg is a script that prints them.
class Films : public Intakes {
 protected:
  void SetUp() override {
    Intakes::SetUp();
    std::ofstream(path("film.mp4")) << "not read by the script";
  }
  void pictures(const std::string& to, int times) const { pictures(to, times, photos()); }
  void pictures(const std::string& to, int times, const std::vector<std::string>& photos) const {
    std::ofstream out(room_ / to, std::ios::binary);
    for (const std::string& photo : photos) {
      const RgbImage image = read_image(photo);
      for (int i = 0; i < times; ++i) {
        out << "P6\n" << image.width << " " << image.height << "\n255\n";
        out.write(reinterpret_cast<const char*>(image.samples.data()),
                  static_cast<std::streamsize>(3 * image.samples.size()));
      }
    }
  }
  std::vector<std::string> printing(const std::string& file) const {
    return with_program("ffmpeg", "cat " + (room_ / file).string());
  }
};

TEST_F(Films, GiveFramesByOverlap) {
  pictures("once", 1);
  pictures("often", 4);
  const auto posed = [&](const std::string& file) {
    const auto before = contents();
    const Outcome outcome = Running({"poses", path("film.mp4")}, room_, printing(file)).wait();
    EXPECT_EQ(contents(), before) << "something was left";
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return std::count(outcome.out.begin(), outcome.out.end(), '\n');
  };
  EXPECT_GE(posed("once"), 6);
  EXPECT_EQ(posed("once"), posed("often")) << "what shows nothing new is passed over";
}

// At four fifths of overlap it would give four.
TEST_F(Films, ThatTurnLittleGiveMoreFrames) {
  ASSERT_EQ(ldp({"scene", "room", "-o", path("little"), "--size", "200x150", "--frames", "40", "--arc", "30",
                 "--radius", "0.3", "--jitter-position", "0.002", "--jitter-angle", "0.1"})
                .status,
            0);
  pictures("film", 1, photos_in(path("little/frames")));
  const Outcome outcome = Running({"poses", path("film.mp4"), "--json"}, room_, printing("film")).wait();
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const auto frames = nlohmann::json::parse(outcome.out).at("frames").size();
  EXPECT_GE(frames, 14U);
  EXPECT_LE(frames, 22U);
}

TEST_F(Films, ThatCannotBeReadAreRefused) {
  const std::vector<std::string> words = {"poses", path("film.mp4")};
  expect_refusal(words, 2, "film.mp4: films need ffmpeg, which could not be started", without_programs());
  expect_refusal(words, 2, "nor a film that ffmpeg reads (no such codec)",
                 with_program("ffmpeg", "echo no such codec >&2; exit 1"));
  expect_refusal(words, 2, "film.mp4: neither", with_program("ffmpeg", "true"));
  expect_refusal(words, 2, "film.mp4: neither", with_program("ffmpeg", "printf 'P6\\n64 48\\n255\\nshort'"));
  expect_refusal(words, 2, "film.mp4: neither", with_program("ffmpeg", "printf 'P6\\n99999 99999\\n255\\n'"));
  expect_refusal(words, 2, "film.mp4: neither", with_program("ffmpeg", "printf 'P6\\n%100s' x; exec sleep 1000"));
  expect_refusal(words, 2, "its pictures change their size",
                 with_program("ffmpeg", "printf 'P6\\n2 1\\n255\\nabcdefP6\\n1 2\\n255\\nabcdef'"));
  pictures("film", 1);
  expect_refusal(words, 2, "film.mp4: neither",
                 with_program("ffmpeg", "cat " + (room_ / "film").string() + "; exit 1"));
}

TEST_F(Films, ThatShowOnePlaceAreTooLittle) {
  expect_refusal(
      {"poses", path("film.mp4")}, 1, "one photo only",
      with_program("ffmpeg", "for i in {1..9}; do printf 'P6\\n64 1\\n255\\n'; head -c 192 /dev/zero; done"));
}

TEST_F(Films, StopAtOnceAndLeaveNothing) {
  const auto before = contents();
  pictures("film", 1);
  const std::string mark = (room_ / "ffmpeg_runs").string();
  const Running running(
      {"build", path("film.mp4"), "-o", path("a.ldp")}, room_,
      with_program("ffmpeg", "echo $$ > " + mark + "; cat " + (room_ / "film").string() + "; exec sleep 1000"));
  while (!fs::exists(mark) || text_of(mark).empty()) std::this_thread::yield();
  running.interrupt();
  EXPECT_EQ(running.wait().status, 130);
  EXPECT_EQ(contents(), before);
  EXPECT_FALSE(fs::exists("/proc/" + std::to_string(std::stoi(text_of(mark))))) << "ffmpeg runs on";
}

// The second film is begun while the first one's program runs; then that is killed.
TEST_F(Films, TakeAwayWhatAKilledProgramLeftAndNothingElse) {
  pictures("film", 1);
  const std::string mark = (room_ / "ffmpeg_runs").string();
  const std::string print = "cat " + (room_ / "film").string();
  const auto unpacked = [&] {
    int count = 0;
    for (const auto& entry : fs::directory_iterator(path("")))
      count += entry.path().filename().string().starts_with(".ldp-unpacked-") ? 1 : 0;
    return count;
  };
  const std::vector<std::string> build = {"build", path("film.mp4"), "-o", path("a.ldp"), "--labels", "2"};
  const Running first(build, room_, with_program("ffmpeg", "echo $$ > " + mark + "; " + print + "; exec sleep 1000"));
  while (!fs::exists(mark) || text_of(mark).empty()) std::this_thread::yield();
  fs::create_directory(path(".ldp-unpacked-theirs"));
  std::ofstream(path(".ldp-unpacked-theirs/kept.jpg")) << "of somebody";
  const std::vector<std::string> refused = {"build", path("film.mp4"), "-o", path("b.ldp")};
  Running(refused, room_, with_program("ffmpeg", "exit 1")).wait();
  EXPECT_EQ(unpacked(), 2) << "the program that it belongs to runs";
  first.kill();
  EXPECT_EQ(unpacked(), 2);
  ::kill(std::stoi(text_of(mark)), SIGKILL);
  EXPECT_EQ(ldp({"build", folder_ + "/none", "-o", path("b.ldp")}).status, 2);
  EXPECT_EQ(unpacked(), 1) << "its program is gone";
  EXPECT_TRUE(fs::exists(path(".ldp-unpacked-theirs/kept.jpg")));
}

// Pictures lie on their side in it, and stand upright by what it says.
TEST_F(Films, AreTurnedAsTheySay) {
  if (!has("ffmpeg")) GTEST_SKIP() << "no ffmpeg";
  const std::string lying = path("lying.mp4"), turned = path("turned.mp4");
  const std::string make = "ffmpeg -v error -framerate 10 -i " + folder_ +
                           "/frames/%03d.png -vf transpose=2 -c:v mpeg4 -q:v 2 " + lying + " && ffmpeg -v error -i " +
                           lying + " -c copy -metadata:s:v:0 rotate=90 " + turned;
  ASSERT_EQ(std::system(make.c_str()), 0);
  const Outcome outcome = ldp({"poses", turned, "-o", path("t.json")});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const std::vector<Camera> cameras = read_transforms(path("t.json"));
  EXPECT_GE(cameras.size(), 6U);
  EXPECT_EQ(std::pair(cameras[0].intrinsics.width, cameras[0].intrinsics.height), std::pair(240, 180));
}

// The programs are scripts that take the photo of the same name.
TEST_F(Intakes, PhotosOfOtherKindsAreConverted) {
  fs::create_directories(path("kinds"));
  for (const std::string& photo : photos())
    fs::copy_file(photo, path("kinds/" + fs::path(photo).stem().string() + ".HEIC"));
  const std::string heif = "[ $# = 4 ] && cp \"$3\" \"${4%.jpg}-1.jpg\"";
  const auto posed = [&](const std::vector<std::string>& through) {
    const auto before = contents();
    const Outcome outcome = Running({"poses", path("kinds")}, room_, through).wait();
    EXPECT_EQ(contents(), before) << "something was left";
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return outcome.out;
  };
  EXPECT_THAT(posed(with_program("heif-convert", heif)), HasSubstr("000.jpg: "));
  for (const auto& entry : fs::directory_iterator(path("kinds")))
    fs::rename(entry.path(), fs::path(entry.path()).replace_extension(".dng"));
  EXPECT_THAT(posed(with_program("simple_dcraw", "cp \"$2\" \"$2.thumb.jpg\"")), HasSubstr("000.jpg: "));
}

TEST_F(Intakes, PhotosOfOtherKindsThatCannotBeReadAreRefused) {
  std::ofstream(path("a.heic")) << "x";
  std::ofstream(path("b.NEF")) << "x";
  const std::vector<std::string> heif = {"poses", path("a.heic"), photos().front()};
  const std::vector<std::string> raw = {"poses", path("b.NEF"), photos().front()};
  expect_refusal(heif, 2, "a.heic: HEIC photos need heif-convert, which could not be started: install it",
                 without_programs());
  expect_refusal(raw, 2, "b.NEF: raw photos need simple_dcraw, which could not be started: install it",
                 without_programs());
  expect_refusal(heif, 2, "a.heic: cannot be read by heif-convert (no brand)",
                 with_program("heif-convert", "echo no brand >&2; exit 1"));
  expect_refusal(raw, 2, "b.NEF: no JPEG picture in it", with_program("simple_dcraw", "true"));
  expect_refusal(heif, 75, "heif-convert", {"bash", "-c", "ulimit -n 5; exec \"$0\" \"$@\""});
}

}  // namespace
}  // namespace ldp
