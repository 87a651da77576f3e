// Where the program `ldp` writes to: names that cannot be meant, what is left of earlier runs, and what it says of
// views that show nothing.

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "core/base/files.h"
#include "core/captures/transforms.h"
#include "core/panorama/file/ldp_file.h"
#include "core/photos/images.h"
#include "tests/flow/flow.h"
#include "tests/sanitizers.h"

namespace ldp {
namespace {

class Outputs : public Flow {
 protected:
  // Four tiny photos and their panorama.
  std::string small_panorama() const {
    const Outcome made =
        ldp({"scene", "room", "-o", path("capture"), "--size", "96x72", "--frames", "4", "--arc", "30", "--no-novel"});
    EXPECT_EQ(made.status, 0) << made.err;
    const Outcome built = ldp({"build", path("capture"), "-o", path("a.ldp"), "--cameras",
                               path("capture/transforms.json"), "--layers", "1", "--labels", "2"});
    EXPECT_EQ(built.status, 0) << built.err;
    return path("a.ldp");
  }
  // A program called ffmpeg that does `what` with the film's name in $film, before all others on the path.
  std::vector<std::string> with_ffmpeg(const std::string& what) const {
    const fs::path folder = room_ / "bin";
    fs::create_directories(folder);
    std::ofstream(folder / "ffmpeg") << "#!/bin/bash\nfilm=\"${@: -1}\"\n" << what << "\n";
    fs::permissions(folder / "ffmpeg", fs::perms::owner_all);
    return {"env", "PATH=" + folder.string() + ":/usr/bin:/bin"};
  }
  std::vector<std::string> render_path(const std::string& file, const std::string& to, int frames) const {
    return {"render", file, "--path", "sway", "--frames", std::to_string(frames), "--size", "64x48", "-o", to};
  }
};

TEST_F(Outputs, ASweepOfLightAndShadeIsShownAtLocalOrEvenExposure) {
  const auto built = [&](const std::string& name, const std::string& exposure) {
    const Outcome made = ldp({"scene", "room", "-o", path(name), "--size", "120x90", "--frames", "10", "--arc", "150",
                              "--no-novel", "--exposure", exposure, "--shade", exposure == "auto" ? "0.15" : "1"});
    EXPECT_EQ(made.status, 0) << made.err;
    const Outcome done = ldp({"build", path(name), "-o", path(name + ".ldp"), "--cameras",
                              path(name + "/transforms.json"), "--layers", "1"});
    EXPECT_EQ(done.status, 0) << done.err;
    return nlohmann::json::parse(ldp({"info", path(name + ".ldp"), "--json"}).out);
  };
  EXPECT_FALSE(built("fixed", "fixed").contains("exposure"));
  const nlohmann::json info = built("auto", "auto");
  ASSERT_TRUE(info.contains("exposure"));
  EXPECT_GT(info["exposure"]["most"], 2 * info["exposure"]["least"].get<double>());
  const auto spread = [&](const std::string& exposure) {  // of what the first and the last camera see
    EXPECT_EQ(ldp({"render", path("auto.ldp"), "--cameras", path("auto/transforms.json"), "--exposure", exposure, "-o",
                   path(exposure)})
                  .status,
              0);
    std::array<double, 2> means{};
    for (const size_t end : {size_t{0}, size_t{1}}) {
      const RgbImage view = read_image(path(exposure + (end == 0 ? "/000.png" : "/009.png")));
      for (const Rgb& c : view.samples) means[end] += c.g;
    }
    return std::max(means[0], means[1]) / std::min(means[0], means[1]);
  };
  EXPECT_LT(spread("local"), 1.35) << "as bright as the photos";
  EXPECT_GT(spread("even"), 1.6) << "one side lies in shade";
  expect_refusal({"render", path("auto.ldp"), "--path", "sway", "-o", path("x"), "--exposure", "bright"}, 2,
                 "--exposure");
}

TEST_F(Outputs, NamesThatAreNoUtf8AreReportedAndStored) {
  const std::string odd = path("caf\xe9"), report = path("report.json"), cameras = path("cameras.json");
  fs::rename(capture(), odd);
  fs::rename(odd + "/frames/001.png", odd + "/frames/001\xe9.png");
  std::string told = text_of(odd + "/transforms.json");
  const std::string name = "001.png", as_text = "001\uFFFD.png";
  told.replace(told.find(name), name.size(), as_text);
  write_file(odd + "/transforms.json", told);
  const std::vector<std::string> given = {odd, "--cameras", odd + "/transforms.json", "--json"};
  const auto json_of = [&](std::vector<std::string> words) {
    words.insert(words.begin() + 1, given.begin(), given.end());
    const Outcome done = ldp(words);
    EXPECT_EQ(done.status, 0) << done.err;
    const auto json = nlohmann::json::parse(done.out, nullptr, false);
    EXPECT_FALSE(json.is_discarded()) << done.out;
    return json;
  };
  const auto built = json_of({"build", "-o", path("a.ldp"), "--report", report, "--layers", "1", "--iterations", "1"});
  EXPECT_EQ(built["options"]["capture"], path("caf\uFFFD"));
  EXPECT_FALSE(nlohmann::json::parse(text_of(report)).contains("failure"));
  EXPECT_EQ(decode_ldp(read_file(path("a.ldp"))).cameras.at(1).name, as_text);
  json_of({"poses", "-o", cameras});
  EXPECT_EQ(read_transforms(cameras).at(1).name, as_text);
  EXPECT_EQ(json_of({"evaluate", "--layers", "1", "--iterations", "1", "--every", "4"})["views"].size(), 2U);
}

TEST_F(Outputs, AFilmIsKnownByItsEndingInAnyCase) {
  const std::string file = small_panorama();
  const auto ffmpeg = with_ffmpeg("cat > \"$film\"");
  for (const char* name : {"film.mp4", "film.MP4", "film.WebM", "film.gif"}) {
    ASSERT_EQ(Running(render_path(file, path(name), 2), room_, ffmpeg).wait().status, 0) << name;
    EXPECT_EQ(fs::file_size(path(name)), 2U * 64 * 48 * 3) << name;
  }
}

TEST_F(Outputs, AFilmReplacesOnlyFilmsOfItsOwn) {
  const std::string file = small_panorama();
  const auto ffmpeg = with_ffmpeg("cat > /dev/null; printf '%100000s' \"$*\" > \"$film\"");
  for (const char* time : {"once", "and over itself"})
    EXPECT_EQ(Running(render_path(file, path("film.mp4"), 2), room_, ffmpeg).wait().status, 0) << time;
  EXPECT_THAT(text_of(path("film.mp4")), HasSubstr("-metadata comment=ldp render"));
  std::ofstream(path("holiday.mp4")) << "ftyp of somebody's holidays";
  expect_refusal(render_path(file, path("holiday.mp4"), 2), 2, "holiday.mp4: exists and is no film that tells", ffmpeg);
  EXPECT_EQ(text_of(path("holiday.mp4")), "ftyp of somebody's holidays");
}

TEST_F(Outputs, AFolderNamedLikeAFileIsRefusedUnlessASlashFollows) {
  const std::string file = small_panorama();
  for (const char* name : {"film.webp", "film.AVI", "film.mov", "views.ldp"})
    expect_refusal(render_path(file, path(name), 2), 2, std::string(name) + "/ if a folder is meant");
  expect_refusal({"scene", "room", "-o", path("room.jpg")}, 2, "room.jpg/ if a folder is meant");
  expect_refusal({"build", path("capture"), "-o", path("b.ldp"), "--debug", path("steps.png")}, 2, "steps.png/");
  expect_refusal({"build", path("capture"), "-o", path("b.jpg")}, 2, "is no name of a .ldp file");
  for (const char* name : {"film.webp/", "views.v1.5", "room.views"}) {
    EXPECT_EQ(ldp(render_path(file, path(name), 1)).status, 0) << name;
    EXPECT_TRUE(fs::exists(fs::path(path(name)) / "frame_000.png")) << name;
  }
  EXPECT_EQ(ldp(render_path(file, path("film.webp"), 1)).status, 0) << "it is a folder by now";
}

TEST_F(Outputs, AShorterPathDoesNotMixWithTheViewsOfALongerOne) {
  const std::string file = small_panorama();
  ASSERT_EQ(ldp(render_path(file, path("views"), 3)).status, 0);
  EXPECT_EQ(ldp(render_path(file, path("views"), 3)).status, 0) << "the same views again";
  expect_refusal(render_path(file, path("views"), 2), 2, "frame_002.png: is left from a longer path");
  EXPECT_EQ(ldp(render_path(file, path("views"), 4)).status, 0) << "all are replaced";
}

TEST_F(Outputs, ViewsDoNotMixWithTheDepthsOfEarlierOnes) {
  const std::string file = small_panorama();
  std::vector<std::string> words = render_path(file, path("views"), 2);
  words.emplace_back("--depth");
  ASSERT_EQ(ldp(words).status, 0);
  expect_refusal(render_path(file, path("views"), 2), 2,
                 "frame_000.pfm: is left from earlier views and would not fit the new ones: render with --depth again");
  EXPECT_EQ(ldp(words).status, 0) << "all are replaced";
  for (const char* name : {"frame_000.pfm", "frame_001.pfm"}) fs::remove(path("views/" + std::string(name)));
  EXPECT_EQ(ldp(render_path(file, path("views"), 2)).status, 0);
  std::ofstream(path("views/frame_001.exr")) << "of a compositor";
  expect_refusal(render_path(file, path("views"), 2), 2, "frame_001.exr: is left from earlier views");
}

TEST_F(Outputs, ViewsNeverReplacePhotos) {
  const std::string file = small_panorama(), photo = path("capture/frames/000.png"), before = text_of(photo);
  const std::vector<std::string> over{"render", file, "--cameras", path("capture/transforms.json"), "-o"};
  const auto to = [&](const std::string& folder) {
    std::vector<std::string> words = over;
    words.push_back(folder);
    return words;
  };
  expect_refusal(to(path("capture/frames")), 2, "000.png: is there already and is no view");
  EXPECT_TRUE(text_of(photo) == before);
  EXPECT_EQ(ldp(to(path("views"))).status, 0);
  EXPECT_EQ(ldp(to(path("views"))).status, 0) << "views replace views";
  std::vector<std::string> with_depth = to(path("views"));
  with_depth.emplace_back("--depth");
  EXPECT_EQ(ldp(with_depth).status, 0);
  EXPECT_EQ(ldp(with_depth).status, 0) << "and depths the depths beside them";
  fs::remove(path("views/001.png"));
  expect_refusal(with_depth, 2, "001.pfm: is there already and is no view");
  const RgbImage own(64, 48);
  write_file(path("views/001.png"), encode_png(own, Plane<uint8_t>(64, 48, 255)));
  expect_refusal(to(path("views")), 2, "001.png: is there already and is no view");
  std::ofstream(path("views/001.png")) << "a text of 25 characters..\6";
  expect_refusal(to(path("views")), 2, "001.png: is there already and is no view");
}

TEST_F(Outputs, AFileThatIsThereIsReplacedOnlyByOneOfItsKind) {
  const std::string file = small_panorama();
  photo("sweep/0.jpg");
  fs::copy_file(path("capture/frames/000.png"), path("sweep/1.png"));
  std::ofstream(path("sweep/capture.json")) << R"({"version": 1, "frames": [{"name": "0.jpg"}]})";
  std::ofstream(path("sweep/package.json")) << R"({"name": "theirs"})";
  std::ofstream(path("sweep/theirs.json"))
      << R"({"software": "theirs", "frames": [{"file_path": "a", "transform_matrix": []}]})";
  std::ofstream(path("sweep/theirs.glb")) << "glTF of another program";
  std::ofstream(path("sweep/theirs.html")) << "<title>Theirs</title>";
  std::ofstream(path("sweep/theirs.ldp")) << "a list of district plans";
  std::ofstream(path("sweep/empty.jpg"));
  const auto before = [&](const std::string& name) { return text_of(path("sweep/" + name)); };
  std::map<std::string, std::string> kept;
  for (const char* name :
       {"0.jpg", "1.png", "capture.json", "package.json", "theirs.json", "theirs.glb", "theirs.html"}) {
    kept[name] = before(name);
    expect_refusal({"export", file, "-o", path("sweep/" + std::string(name))}, 2, "exists and is no ");
  }
  kept["theirs.ldp"] = before("theirs.ldp");
  expect_refusal({"build", path("capture"), "-o", path("sweep/theirs.ldp")}, 2, "exists and is no .ldp file");
  for (const char* name : {"capture.json", "package.json", "theirs.json"}) {
    expect_refusal({"poses", path("capture"), "-o", path("sweep/" + std::string(name))}, 2, "exists and is no ");
    expect_refusal({"build", path("capture"), "-o", path("b.ldp"), "--report", path("sweep/" + std::string(name))}, 2,
                   "exists and is no report");
  }
  const std::string cameras = path("capture/transforms.json");
  expect_refusal({"poses", path("capture"), "--cameras", cameras, "-o", cameras}, 2, "is also read");
  for (const auto& [name, bytes] : kept) EXPECT_TRUE(before(name) == bytes) << name;
  for (const char* name : {"a.jpg", "a.png", "a.json", "a.glb", "a.html", "sweep/empty.jpg"})
    for (const char* time : {"once", "and over itself"}) {
      const Outcome exported = ldp({"export", file, "-o", path(name)});
      EXPECT_EQ(exported.status, 0) << name << " " << time << ": " << exported.err;
    }
  for (const char* time : {"once", "and over itself"}) {
    const Outcome built = ldp({"build", path("capture"), "-o", file, "--cameras", cameras, "--layers", "1", "--labels",
                               "2", "--report", path("report.json")});
    EXPECT_EQ(built.status, 0) << time << ": " << built.err;
  }
}

TEST_F(Outputs, AnEmptyNameIsRefusedInOneLine) {
  expect_refusal({"build", path("x"), "-o", ""}, 2, "-o FILE.ldp is missing or empty");
  expect_refusal({"scene", "room", "-o", ""}, 2, "no output folder is named");
  const std::string file = small_panorama();
  expect_refusal(render_path(file, "", 2), 2, "the name of an output is empty");
}

TEST_F(Outputs, WhatOnlyAPathHasIsRefusedWithCameras) {
  const std::vector<std::string> words{"render", path("a.ldp"), "--cameras", path("views.json"), "-o", path("views")};
  for (const auto& [option, value] : std::map<std::string, std::string>{
           {"--frames", "3"}, {"--size", "64x48"}, {"--fov", "50"}, {"--path", "sway"}}) {
    std::vector<std::string> all = words;
    all.insert(all.end(), {option, value});
    expect_refusal(all, 2, "--cameras");
  }
}

TEST_F(Outputs, CamerasOfAnotherWorldAreToldOf) {
  const std::string file = small_panorama();
  std::vector<Camera> cameras = read_transforms(path("capture/transforms.json"));
  cameras.resize(2);
  const auto rendered = [&] {
    write_file(path("views.json"),
               [text = transforms_json(cameras)] { return std::vector<uint8_t>(text.begin(), text.end()); }());
    return ldp({"render", file, "--cameras", path("views.json"), "-o", path("views"), "--fill", "background"});
  };
  EXPECT_EQ(rendered().err, "");
  Eigen::Matrix3d& turn = cameras[1].pose.world_from_camera;
  turn.col(0) *= -1, turn.col(2) *= -1;  // it looks the other way
  const Outcome blind = rendered();
  EXPECT_EQ(blind.status, 0);
  EXPECT_THAT(blind.err, HasSubstr("1 of 2 cameras see nothing of the panorama"));
  EXPECT_EQ(std::count(blind.err.begin(), blind.err.end(), '\n'), 1) << blind.err;
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
                 path("film.mp4") + ": ffmpeg failed: " + path("film.mp4") + ": No space left on device",
                 with_ffmpeg("echo \"$film: No space left on device\" >&2; echo and more >&2; exit 1"));
}

std::vector<std::string> with_faults(const std::string& rules) {
  return {"env", "LD_PRELOAD=" LDP_FAULTS, "LDP_FAULTS=" + rules, "LDP_FAULTS_IN=ldp"};
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
  EXPECT_EQ(exporting.wait().status, 130);
  EXPECT_EQ(contents(), before);
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

TEST_F(Outputs, SmallFilesAreCountedInKilobytes) {
  const std::string file = small_panorama();
  const Outcome exported = ldp({"export", file, "-o", path("a.json")});
  EXPECT_THAT(exported.out, HasSubstr(" kB\n"));
  EXPECT_THAT(exported.out, testing::Not(HasSubstr(" 0.0 ")));
}

TEST_F(Outputs, HelpAndRefusalsHoldPrintableTextOnly) {
  const auto printable = [](const std::string& text) {
    return std::all_of(text.begin(), text.end(), [](unsigned char c) { return c == '\n' || (c >= 0x20 && c != 0x7F); });
  };
  for (const char* command : {"build", "render", "info", "verify", "export", "evaluate", "poses", "scene"})
    EXPECT_TRUE(printable(ldp({command, "--help"}).out)) << command;
  expect_refusal({"build", path("x"), "-o", path("a.ldp"), "--rays", "round"}, 2, "round not in {pushbroom,central}");
  expect_refusal({"render", path("a.ldp"), "-o", path("views"), "--fill", "green"}, 2,
                 "green not in {none,background}");
  for (const auto& words : {std::vector<std::string>{"build", "x", "-o", "a.ldp", "--rays", "round"},
                            std::vector<std::string>{"render", "a.ldp", "-o", "views", "--fill", "green"}})
    EXPECT_TRUE(printable(ldp(words).err)) << words[0];
}

TEST_F(Outputs, MemoryIsASizeAndNothingElse) {
  for (const char* size : {"-5", "-1M", "abc", "5X", "1e3", "1.5M", "+5M", "99999999999999999999T", "", "M", "5 M",
                           "5M ", " 5M", "-0", "0x10", "5M3"})
    expect_refusal({"build", path("x"), "-o", path("a.ldp"), "--memory", size}, 2,
                   "--memory: '" + std::string(size) + "' is not a size such as 128M");
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

TEST_F(Outputs, AParentThatIgnoresTheEndOfChildrenHidesNoFailureOfAFilm) {
  const std::string file = small_panorama();
  std::vector<std::string> through = with_ffmpeg("cat > /dev/null; echo half > \"$film\"; exit 1");
  through.insert(through.begin() + 1, "--ignore-signal=CHLD");
  expect_refusal(render_path(file, path("film.mp4"), 2), 1, "film.mp4: ffmpeg failed", through);
}

// In containers programs have the same process number again and again.
TEST_F(Outputs, WhatAKilledProgramOfTheSameNumberLeftDoesNotGetIntoTheResults) {
  const std::string left = path(".room.partial-");
  const Outcome made =
      Running({"scene", "room", "-o", path("room"), "--size", "64x48", "--frames", "2", "--no-novel"}, room_,
              {"bash", "-c", "mkdir '" + left + "'$$; echo x > '" + left + "'$$/stale.png; exec \"$0\" \"$@\""})
          .wait();
  EXPECT_EQ(made.status, 0) << made.err;
  EXPECT_TRUE(fs::exists(path("room/transforms.json")));
  EXPECT_FALSE(fs::exists(path("room/stale.png")));
}

// By the record of faults.c: names and their folder are flushed before the folder takes its own name, and that after.
TEST_F(Outputs, AFolderOfResultsOutlivesAPowerCut) {
  const std::string file = small_panorama();
  fs::create_directories(path("record"));
  const Outcome made = Running(render_path(file, path("views"), 2), room_,
                               {"bash", "-c", "exec \"$0\" \"$@\" 2>> '" + path("said") + "'", "env",
                                "LD_PRELOAD=" LDP_FAULTS, "LDP_FAULTS_IN=ldp", "LDP_FAULTS_RECORD=" + path("record")})
                           .wait();
  EXPECT_EQ(made.status, 0) << made.err;
  // Between the last picture and the folder's own name the folder is flushed, and afterwards the one that it stands in.
  const std::string record = text_of(path("said")), parent = fs::path(path("views")).parent_path().string();
  const size_t picture = record.rfind("frame_001.png\n"), named = record.find("\t" + path("views") + "\n");
  ASSERT_NE(named, std::string::npos) << record;
  ASSERT_LT(picture, named) << record;
  EXPECT_NE(record.substr(picture, named - picture).find("@sync\t"), std::string::npos) << record;
  EXPECT_NE(record.find("@sync\t" + parent + "\t-\n", named), std::string::npos) << record;
}

}  // namespace
}  // namespace ldp
