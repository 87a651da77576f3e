// What the program `ldp` writes, and what it says of it: films, views, exports, folders of results.

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "core/base/files.h"
#include "core/captures/transforms.h"
#include "core/panorama/file/ldp_file.h"
#include "core/photos/images.h"
#include "tests/flow/outputs.h"

namespace ldp {
namespace {

TEST_F(Outputs, WhatIsToBeLookedAtIsFilledUnlessToldOtherwise) {
  const std::string file = panorama(capture());
  const auto shares = [&](std::vector<std::string> words, const std::vector<std::string>& more) {
    words.insert(words.end(), more.begin(), more.end());
    words.emplace_back("--json");
    const Outcome outcome = ldp(words);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    const nlohmann::json told = nlohmann::json::parse(outcome.out);
    return std::pair(told["holes_percent"].get<double>(), told["invented_percent"].get<double>());
  };
  const std::vector<std::string> front = render_path(file, path("path"), 4), nothing{};
  const auto [holes, filled] = shares(front, {"--layers", "1"});
  EXPECT_EQ(holes, 0);
  EXPECT_GT(filled, 0);  // behind silhouettes
  const auto [left, invented] = shares(front, {"--layers", "1", "--fill", "none"});
  EXPECT_EQ(left, filled);
  EXPECT_EQ(invented, 0);
  const std::vector<std::string> of_cameras{"render",   file, "--cameras", path("capture/transforms.json"),
                                            "--layers", "1",  "-o",        path("cameras")};
  EXPECT_EQ(shares(of_cameras, nothing), shares(of_cameras, {"--fill", "none"}));
  EXPECT_EQ(shares(of_cameras, {"--fill", "background"}).first, 0);
}

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

TEST_F(Outputs, InfoTellsHowColoursAreCoded) {
  const auto told = [&](const std::string& file, const std::string& coding, const std::string& text) {
    const std::string golden = LDP_SOURCE "/tests/golden/" + file;
    const auto layers = nlohmann::json::parse(ldp({"info", golden, "--json"}).out).at("layers");
    EXPECT_EQ(layers.at(0).at("colour"), nlohmann::json::array({coding})) << file;
    EXPECT_THAT(ldp({"info", golden}).out, HasSubstr(text)) << file;
  };
  told("uniform_lossless.ldp", "webp_lossless", " covered, colours in lossless WebP\n");
  told("jpeg_one_layer.ldp", "jpeg", ", colours in JPEG\n");
  told("blocks_alpha_wraps.ldp", "webp", ", soft edges, colours in WebP\n");
}

TEST_F(Outputs, InfoTellsARadiusThatIsAssumed) {
  LayeredPanorama panorama = decode_ldp(read_file(LDP_SOURCE "/tests/golden/tiny.ldp"));
  for (const bool parallax : {true, false}) {
    if (!parallax) panorama.grid.w_near = panorama.grid.w_far = 0;
    write_file(path("a.ldp"), encode_ldp(panorama, {}));
    EXPECT_EQ(nlohmann::json::parse(ldp({"info", path("a.ldp"), "--json"}).out)["arc"]["radius_assumed"], !parallax);
    EXPECT_THAT(ldp({"info", path("a.ldp")}).out,
                HasSubstr(parallax ? "radius 0.65, "
                                   : "radius 0.65 (assumed, or given with the cameras: the photos "
                                     "show no parallax), "));
  }
}

TEST_F(Outputs, ExportsOfDepthsTellWhereNoneWasSeen) {
  LayeredPanorama panorama = decode_ldp(read_file(LDP_SOURCE "/tests/golden/tiny.ldp"));
  const auto said = [&](std::vector<std::string> words) {
    fs::remove(words.front());
    words.insert(words.begin(), {"export", path("a.ldp"), "-o"});
    const Outcome done = ldp(words);
    EXPECT_EQ(done.status, 0) << done.err;
    return done.err;
  };
  for (const bool parallax : {true, false}) {
    if (!parallax) panorama.grid.w_near = panorama.grid.w_far = 0;
    write_file(path("a.ldp"), encode_ldp(panorama, {}));
    EXPECT_EQ(
        said({path("a.ply")}),
        (parallax ? "" : "ldp export: the photos show no parallax, all of it is at infinity: there are no points\n"));
    EXPECT_EQ(
        said({path("a.jpg"), "--kind", "depth"}),
        (parallax ? ""
                  : "ldp export: the photos show no parallax, all of it is at infinity: the depths tell nothing\n"));
    EXPECT_EQ(said({path("b.jpg")}), "");
  }
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

TEST_F(Outputs, TheViewsOfAFilmAreOfOneSize) {
  const std::string file = small_panorama();
  std::vector<Camera> cameras = read_transforms(path("capture/transforms.json"));
  cameras.resize(3);
  cameras[2].intrinsics.width += 2;
  const std::string text = transforms_json(cameras);
  write_file(path("mixed.json"), std::vector<uint8_t>(text.begin(), text.end()));
  expect_refusal({"render", file, "--cameras", path("mixed.json"), "-o", path("film.mp4")}, 2,
                 "mixed.json: the views of a film are all of one size, here are 000.png of ",
                 with_ffmpeg("cat > \"$film\""));
  EXPECT_FALSE(fs::exists(path("film.mp4")));
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

TEST_F(Outputs, ViewsThatAreReplacedStayForThoseThatTheyWereFor) {
  const std::string file = small_panorama(), view = path("views/frame_000.png");
  ASSERT_EQ(ldp(render_path(file, path("views"), 2)).status, 0);
  fs::permissions(view, fs::perms(0600));
  ASSERT_EQ(ldp(render_path(file, path("views"), 2)).status, 0);
  EXPECT_EQ(fs::status(view).permissions(), fs::perms(0600));
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
  turn.col(0) *= -1, turn.col(2) *= -1;
  cameras[1].pose.centre += Eigen::Vector3d(5, 0, 0);  // metres, from an arm's length
  EXPECT_THAT(rendered().err, HasSubstr("1 of 2 cameras stand far from where views hold"));
  cameras[0].pose.centre += Eigen::Vector3d(5, 0, 0);
  turn.col(0) *= -1, turn.col(2) *= -1;
  EXPECT_THAT(rendered().err, HasSubstr("2 of 2 cameras stand far")) << "though one of them sees nothing besides";
}

TEST_F(Outputs, WhatExportsAndScenesCameToIsToldInJsonToo) {
  const auto json_of = [&](std::vector<std::string> words) {
    words.emplace_back("--json");
    const Outcome done = ldp(words);
    EXPECT_EQ(done.status, 0) << done.err;
    return nlohmann::json::parse(done.out, nullptr, false);
  };
  const std::string file = small_panorama();
  const nlohmann::json exported = json_of({"export", file, "-o", path("a.jpg")});
  EXPECT_EQ(exported, (nlohmann::json{{"file", path("a.jpg")}, {"bytes", fs::file_size(path("a.jpg"))}}));
  const auto scene = [&](const std::string& to, std::vector<std::string> more) {
    more.insert(more.begin(), {"scene", "room", "-o", to, "--size", "64x48", "--frames", "2"});
    nlohmann::json told = json_of(more);
    for (const char* const key : {"cameras", "depths", "novel_views", "around"})
      if (!told.at(key).is_null()) {
        EXPECT_TRUE(fs::exists(told[key].get<std::string>())) << told[key];
      }
    return told;
  };
  const nlohmann::json told{{"capture", path("room")},
                            {"scene", "room"},
                            {"frames", 2},
                            {"cameras", path("room/transforms.json")},
                            {"depths", path("room/frames_depth")},
                            {"novel_views", nullptr},
                            {"around", nullptr}};
  EXPECT_EQ(scene(path("room"), {"--no-novel"}), told);
  EXPECT_EQ(scene(path("round"), {"--no-novel", "--around", "64"}).at("around"), path("round/around"));
  EXPECT_EQ(scene(path("more"), {}).at("novel_views"), path("more/novel.json"));
  const Outcome on_a_terminal =
      Running({"scene", "room", "-o", path("again"), "--size", "64x48", "--frames", "2", "--no-novel", "--json"}, room_,
              {"bash", "-c", "script -qec \"$(printf '%q ' \"$0\" \"$@\")\" /dev/null < /dev/null"})
          .wait();
  EXPECT_THAT(on_a_terminal.out, testing::AllOf(HasSubstr("[###"), HasSubstr("\r\x1b[K{\"capture\"")))
      << "what is printed stands in a line of its own";
  EXPECT_THAT(json_of({"scene", "--list"})["scenes"].get<std::vector<std::string>>(), testing::Contains("garden"));
}

TEST_F(Outputs, SmallFilesAreCountedInKilobytes) {
  const std::string file = small_panorama();
  const Outcome exported = ldp({"export", file, "-o", path("a.json")});
  EXPECT_THAT(exported.out, HasSubstr(" kB\n"));
  EXPECT_THAT(exported.out, testing::Not(HasSubstr(" 0.0 ")));
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
  const std::string views = path("views"), renamed = "\t" + views + "\n";
  const size_t picture = record.rfind("frame_001.png\n"), named = record.find(renamed);
  ASSERT_NE(named, std::string::npos) << record;
  ASSERT_LT(picture, named) << record;
  EXPECT_NE(record.substr(picture, named - picture).find("@sync\t"), std::string::npos) << record;
  EXPECT_NE(record.find("@sync\t" + parent + "\t-\n", named), std::string::npos) << record;
}

}  // namespace
}  // namespace ldp
