// What the program `ldp` refuses to write to, and options that cannot be meant: in one line of printable text.

#include <algorithm>
#include <map>
#include <utility>

#include "core/base/files.h"
#include "core/panorama/file/ldp_file.h"
#include "core/photos/images.h"
#include "tests/flow/outputs.h"

namespace ldp {
namespace {

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

TEST_F(Outputs, ProgressIsToldToAnOpenDescriptorAlone) {
  for (const std::string descriptor : {"none", "-1", "77"})
    expect_refusal({"build", path("capture"), "-o", path("b.ldp"), "--progress-fd", descriptor}, 2,
                   "--progress-fd: Value " + descriptor + " is no open file descriptor");
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

// A next build of the capture would take them for photos.
TEST_F(Outputs, NoPicturesAreWrittenAmongThePhotosOfACapture) {
  const std::string file = small_panorama();
  fs::create_directories(path("loose"));
  for (const char* const name : {"0", "1", "2", "3"})
    fs::copy_file(path("capture/frames/00") + name + ".png", path("loose/") + name + "0.png");
  const std::vector<std::pair<std::string, std::string>> places = {{path("capture"), path("capture")},
                                                                   {path("capture"), path("capture/frames")},
                                                                   {path("capture/frames"), path("capture")},
                                                                   {path("loose"), path("loose/")}};
  for (const auto& [capture, to] : places) {
    expect_refusal({"build", capture, "-o", path("b.ldp"), "--debug", to}, 2,
                   "--debug " + to + ": is the folder of the photos", {"timeout", "60"});
    expect_refusal({"evaluate", capture, "--keep", to}, 2, "--keep " + to + ": is the folder of the photos",
                   {"timeout", "60"});
  }
  for (const std::string to : {"capture", "capture/frames", "loose"})
    expect_refusal(render_path(file, path(to), 2), 2, to + ": holds photos, among them ");
  EXPECT_EQ(ldp(render_path(file, path("taken/frames"), 2)).status, 2) << "its folder is not there";
  fs::create_directories(path("taken"));
  for (const char* const to : {"taken/frames", "taken"})
    EXPECT_EQ(ldp(render_path(file, path(to), 4)).status, 0) << "views are no photos";
  fs::create_directories(path("views"));
  fs::copy_file(path("loose/00.png"), path("views/poster.png"));
  EXPECT_EQ(ldp(render_path(file, path("views"), 2)).status, 0) << "a picture is no capture";
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
  expect_refusal({"export", file, "-o", ""}, 2, "the name of an output is empty");
}

TEST_F(Outputs, WhatOnlyAPathHasIsRefusedWithCameras) {
  const std::vector<std::string> words{"render", small_panorama(), "--cameras", path("views.json"),
                                       "-o",     path("views")};
  for (const auto& [option, value] : std::map<std::string, std::string>{
           {"--frames", "3"}, {"--size", "64x48"}, {"--fov", "50"}, {"--path", "sway"}}) {
    std::vector<std::string> all = words;
    all.insert(all.end(), {option, value});
    expect_refusal(all, 2, "--cameras");
  }
}

TEST_F(Outputs, OptionsWithoutEffectAreRefused) {
  const std::string file = small_panorama();
  const auto exported = [&](const std::string& to, std::vector<std::string> words) {
    words.insert(words.begin(), {"export", file, "-o", path(to)});
    return words;
  };
  expect_refusal(exported("b.jpg", {"--eyes", "0.06"}), 2, "--eyes: only --kind stereo has two");
  expect_refusal(exported("b.jpg", {"--kind", "depth", "--eyes", "0.06"}), 2, "--eyes: only --kind stereo has two");
  expect_refusal(exported("b.jpg", {"--plain"}), 2, "--plain: " + path("b.jpg") + " is no .glb");
  for (const char* const name : {"b.png", "b.ply", "b.html", "b.json", "layers/"})
    expect_refusal(exported(name, {"--quality", "50"}), 2, "--quality: " + path(name) + " is no .jpg or .glb");
  expect_refusal({"scene", "room", "-o", path("room"), "--heading", "20"}, 2, "--heading: only --around shows it");
  expect_refusal({"scene", "room", "-o", path("room"), "--eyes", "0.1"}, 2, "--eyes: only --around shows it");
  EXPECT_EQ(ldp(exported("b.glb", {"--plain", "--quality", "50"})).status, 0);
  EXPECT_EQ(ldp(exported("b.JPEG", {"--quality", "50"})).status, 0);
  EXPECT_EQ(ldp(exported("c.jpg", {"--kind", "stereo", "--eyes", "0.06"})).err, "");
  EXPECT_EQ(ldp(exported("c.jpg", {"--at", "0.1,0.2,0"})).err, "");
  const Outcome far = ldp(exported("d.jpg", {"--at", "500,0,0"}));
  EXPECT_EQ(far.status, 0);
  EXPECT_THAT(far.err, HasSubstr("ldp export: --at is far from where views hold, "));
  EXPECT_THAT(ldp(exported("d.jpg", {"--at", "0,0,1"})).err, HasSubstr("--at is far from where views hold, "));
  EXPECT_THAT(ldp(exported("d.jpg", {"--kind", "stereo", "--eyes", "30"})).err,
              HasSubstr("--eyes are far from where views hold, "));
}

TEST_F(Outputs, ThreePhotosAreTooFewToLeaveOneOut) {
  ASSERT_EQ(
      ldp({"scene", "room", "--frames", "3", "--arc", "30", "--size", "160x120", "--no-novel", "-o", path("three")})
          .status,
      0);
  expect_refusal({"evaluate", path("three/frames"), "--cameras", path("three/transforms.json")}, 1,
                 "only 2 photos are left to build from when each 5th is left out; at least 3 are needed: take more");
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
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"scene", "room", "-o", path("room")}, {"poses", path("x")}}) {
    std::vector<std::string> with_seed = words;
    with_seed.insert(with_seed.end(), {"--seed", "-1"});
    expect_refusal(with_seed, 2, "--seed: Value -1 is not a whole number from 0 to 4294967295");
  }
  for (const std::string quality : {"95.5", "x", "102", "0", ""})
    expect_refusal({"build", path("x"), "-o", path("a.ldp"), "--quality", quality}, 2,
                   "--quality: Value " + quality + " is not a whole number from 1 to 101");
  for (const auto& words : {std::vector<std::string>{"build", "x", "-o", "a.ldp", "--rays", "round"},
                            std::vector<std::string>{"render", "a.ldp", "-o", "views", "--fill", "green"}})
    EXPECT_TRUE(printable(ldp(words).err)) << words[0];
}

TEST_F(Outputs, NamesWriteNoControlSequencesOntoTheTerminal) {
  const std::string odd = path("a\x1b]0;x\a\x7f\xc2\x9b\xc3\xa9\xff.ldp"),
                    says = "a\\x1b]0;x\\x07\\x7f\\xc2\\x9b\xc3\xa9\\xff.ldp";
  expect_refusal({"info", odd}, 2, says + ": there is no such file");
  fs::copy_file(LDP_SOURCE "/tests/golden/tiny.ldp", odd);
  EXPECT_THAT(ldp({"verify", odd}).out, HasSubstr(says + ": sound\n"));
  EXPECT_THAT(ldp({"info", odd}).out, HasSubstr(says + ": layered depth panorama"));
  LayeredPanorama panorama = decode_ldp(read_file(LDP_SOURCE "/tests/golden/tiny.ldp"));
  panorama.metadata["\x1b[2J"] = "\x1b[31m", panorama.quality["\x1b[1m"] = 1;
  write_file(path("b.ldp"), encode_ldp(panorama, {}));
  const std::string told = ldp({"info", path("b.ldp")}).out;
  EXPECT_THAT(told, testing::AllOf(HasSubstr("metadata  \\x1b[2J: \\x1b[31m\n"), HasSubstr("quality   \\x1b[1m 1\n")));
  EXPECT_EQ(told.find('\x1b'), std::string::npos);
  std::ofstream(odd, std::ios::app) << "damage";
  const Outcome damaged = ldp({"verify", odd});
  EXPECT_THAT(damaged.err, HasSubstr(says));
  EXPECT_EQ(damaged.err.find('\x1b'), std::string::npos);
}

TEST_F(Outputs, MemoryIsASizeAndNothingElse) {
  for (const char* size : {"-5", "-1M", "abc", "5X", "1e3", "1.5M", "+5M", "99999999999999999999T", "", "M", "5 M",
                           "5M ", " 5M", "-0", "0x10", "5M3"})
    expect_refusal({"build", path("x"), "-o", path("a.ldp"), "--memory", size}, 2,
                   "--memory: '" + std::string(size) +
                       "' is not a size such as 128M or 1G, a whole number of bytes, K, M, G or T");
}

}  // namespace
}  // namespace ldp
