// The whole flow through the program `ldp`: a synthetic sweep to a file to views, and every way it can be refused.

#include <chrono>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <thread>

#include "core/base/files.h"
#include "tests/flow/flow.h"
#include "tests/sanitizers.h"

namespace ldp {
namespace {

// Of small pictures, where a pixel is three times as wide as in a real sweep.
constexpr double kLeastViewPsnr_db = 20;
constexpr double kMostHoles_percent = 6;

double psnr_of(const RgbImage& a, const RgbImage& b) {
  double sum = 0;
  for (size_t i = 0; i < a.samples.size(); ++i) {
    const Rgb &p = a.samples[i], &q = b.samples[i];
    for (const int d : {p.r - q.r, p.g - q.g, p.b - q.b}) sum += d * d;
  }
  return 10 * std::log10(255.0 * 255.0 * 3.0 * static_cast<double>(a.samples.size()) / sum);
}

TEST_F(Flow, ASweepBecomesAFileWhoseViewsLookLikeTheScene) {
  const std::string from = capture();
  const Outcome built = ldp({"build", from, "-o", path("a.ldp"), "--cameras", from + "/transforms.json", "--report",
                             path("report.json"), "--json"});
  ASSERT_EQ(built.status, 0) << built.err;
  EXPECT_EQ(built.err, "");
  const auto report = nlohmann::json::parse(text_of(path("report.json")));
  EXPECT_EQ(report, nlohmann::json::parse(built.out));
  EXPECT_EQ(report["poses"]["posed"], 8);
  EXPECT_EQ(report["options"]["layers"], 3);
  EXPECT_EQ(report["bytes"]["file"], fs::file_size(path("a.ldp")));
  EXPECT_GT(report["peak_memory_bytes"], 1 << 20);
  for (const auto& solve : report["solves"]) {
    EXPECT_LE(solve["data_energy"].get<double>() + solve["smoothness_energy"].get<double>(),
              solve["initial_energy"].get<double>() + 1e-6)
        << solve["name"];
  }

  EXPECT_EQ(ldp({"verify", path("a.ldp")}).status, 0);
  const Outcome info = ldp({"info", path("a.ldp"), "--json"});
  EXPECT_EQ(nlohmann::json::parse(info.out)["cameras"].size(), 8U);

  const Outcome rendered = ldp({"render", path("a.ldp"), "--cameras", from + "/novel.json", "-o", path("views"),
                                "--depth", "--fill", "background", "--json"});
  ASSERT_EQ(rendered.status, 0) << rendered.err;
  for (const char* view : {"001", "002"}) {  // on the arc, between photos
    const RgbImage mine = read_image(path("views/" + std::string(view) + ".png")),
                   truth = read_image(from + "/novel/" + view + ".png");
    EXPECT_GT(psnr_of(mine, truth), kLeastViewPsnr_db) << view;
    EXPECT_TRUE(fs::exists(path("views/" + std::string(view) + ".pfm")));
  }
  const Outcome holes =
      ldp({"render", path("a.ldp"), "--cameras", from + "/transforms.json", "-o", path("seen"), "--json"});
  EXPECT_LT(nlohmann::json::parse(holes.out)["holes_percent"], kMostHoles_percent);
}

// Photos of real sweeps, where they are: what no synthetic scene has, as steps so wide that hardly a third photo sees
// anything, bricks, and a lens of a telephone.
struct Photos {
  std::string name;
  double focal_px;  // by the lens' name; 0 where that is not known
  std::string megapixels = "2.1";
  double reprojection_px = 1;
};
void PrintTo(const Photos& photos, std::ostream* out) { *out << photos.name << ' ' << photos.megapixels; }
class RealSweep : public Flow, public testing::WithParamInterface<Photos> {};

TEST_P(RealSweep, IsPosedWholeAndItsMatchesAgree) {
  const fs::path photos = fs::path(LDP_SHARED_DATA) / "photos" / GetParam().name;
  if (!fs::exists(photos)) GTEST_SKIP() << photos << " is absent";
  const Outcome posed =
      ldp({"poses", photos.string(), "-o", path("poses.json"), "--json", "--megapixels", GetParam().megapixels});
  ASSERT_EQ(posed.status, 0) << posed.err;
  const auto told = nlohmann::json::parse(posed.out);
  EXPECT_EQ(told.at("doubt"), "");
  EXPECT_LT(told.at("reprojection_px").get<double>(), GetParam().reprojection_px);
  for (const auto& frame : told.at("frames")) EXPECT_TRUE(frame.at("posed").get<bool>()) << frame;
  const double focal_px = nlohmann::json::parse(text_of(path("poses.json"))).at("fl_x");
  if (GetParam().focal_px > 0) {
    EXPECT_NEAR(focal_px, GetParam().focal_px, 0.01 * GetParam().focal_px);
  }
}

INSTANTIATE_TEST_SUITE_P(Photos, RealSweep,
                         testing::Values(Photos{"atrium_360", 24 * 1300 / 36.},
                                         Photos{"atrium_360", 24 * 1300 / 36., "0.7", 0.5}, Photos{"desk_sweep", 0}));

TEST_F(Flow, TheSameSweepAndBuildGiveTheSameBytesAtAnyThreadCount) {
  const std::string from = capture();
  for (const char* threads : {"1", "3"}) {
    const Outcome built = ldp({"build", from, "-o", path(std::string(threads) + ".ldp"), "--cameras",
                               from + "/transforms.json", "--iterations", "1", "--layers", "2", "--threads", threads});
    ASSERT_EQ(built.status, 0) << built.err;
  }
  EXPECT_EQ(text_of(path("1.ldp")), text_of(path("3.ldp")));
}

// A room is explained so well that coding would be much of what its views lack.
TEST_F(Flow, ColoursAreCodedAsExactlyAsThePhotographsBearItOut) {
  const std::string from = path("room");
  ASSERT_EQ(ldp({"scene", "room", "-o", from, "--size", "320x240", "--frames", "8", "--arc", "60"}).status, 0);
  const auto built = [&](const std::string& file, std::vector<std::string> more) {
    std::vector<std::string> words{"build",  from,       "-o",  path(file), "--cameras", from + "/transforms.json",
                                   "--json", "--effort", "fast"};
    words.insert(words.end(), more.begin(), more.end());
    const Outcome done = ldp(words);
    EXPECT_EQ(done.status, 0) << done.err;
    return nlohmann::json::parse(done.out);
  };
  const auto told = built("told.ldp", {"--quality", "90"}), chosen = built("chosen.ldp", {});
  EXPECT_EQ(told["options"]["colour_quality"], 90);
  EXPECT_GT(chosen["quality"]["photos_back_psnr_db"], 29);
  EXPECT_GT(chosen["options"]["colour_quality"], 91);
  EXPECT_GT(fs::file_size(path("chosen.ldp")), fs::file_size(path("told.ldp")));
}

TEST_F(Flow, EveryEffortGivesItsOwnBytesAtAnyThreadCount) {
  const std::string from = capture();
  const auto built = [&](const std::string& effort, const std::string& threads) {
    const std::string file = path(effort + threads + ".ldp");
    const Outcome done = ldp({"build", from, "-o", file, "--cameras", from + "/transforms.json", "--effort", effort,
                              "--layers", "1", "--threads", threads, "--report", path("report.json")});
    EXPECT_EQ(done.status, 0) << done.err;
    EXPECT_EQ(nlohmann::json::parse(text_of(path("report.json"))).at("options").at("effort"), effort);
    return text_of(file);
  };
  const std::string fast = built("fast", "1"), standard = built("standard", "3"), best = built("best", "1");
  EXPECT_TRUE(fast == built("fast", "3"));
  EXPECT_TRUE(best == built("best", "3"));
  EXPECT_FALSE(fast == standard || standard == best || best == fast);
  const Outcome refused = ldp({"build", from, "-o", path("x.ldp"), "--effort", "medium"});
  EXPECT_EQ(refused.status, 2);
  EXPECT_NE(refused.err.find("--effort"), std::string::npos) << refused.err;
}

TEST_F(Flow, ABuildThatFollowsTheSweepGivesTheSameBytes) {
  const std::string from = capture();
  const std::vector<std::string> options{"--arm-length", "0.7", "--layers", "2"};
  const auto build_to = [&](const std::string& file, const std::vector<std::string>& more) {
    std::vector<std::string> words{"build", from, "-o", path(file)};
    words.insert(words.end(), options.begin(), options.end());
    words.insert(words.end(), more.begin(), more.end());
    return words;
  };
  ASSERT_EQ(ldp(build_to("plain.ldp", {})).status, 0);
  fs::rename(from + "/frames", path("all"));
  fs::create_directory(from + "/frames");
  // Photos come one by one; the last are not spoken of, as if they had come while "end" was said. One is still being
  // written all the time.
  const std::string arm = "touch " + from + "/frames/007.png; for photo in $(ls " + path("all") + "); do cp " +
                          path("all") + "/$photo " + from +
                          "/frames/; [ $photo \\> 006 ] || echo $photo; sleep 0.02; done; echo end";
  const Outcome followed = Running(build_to("followed.ldp", {"--follow"}), room_, fed_by(arm)).wait();
  ASSERT_EQ(followed.status, 0) << followed.err;
  EXPECT_TRUE(text_of(path("plain.ldp")) == text_of(path("followed.ldp")));
  // Arm length and field of view that become known at the end only.
  fs::remove(path("followed.ldp"));
  const std::string late =
      "ls " + from + "/frames; sleep 0.3; echo '{\"fov_degrees\": 50}' > " + from + "/capture.json; echo end";
  ASSERT_EQ(Running(build_to("followed.ldp", {"--follow"}), room_, fed_by(late)).wait().status, 0);
  ASSERT_EQ(ldp(build_to("plain.ldp", {})).status, 0);
  EXPECT_TRUE(text_of(path("plain.ldp")) == text_of(path("followed.ldp")));
}

TEST_F(Flow, ABuildThatFollowsSaysThatTheSweepBrokeOff) {
  const std::string from = capture();
  expect_refusal({"build", from, "-o", path("a.ldp"), "--follow"}, 1, "standard input ended before the line 'end'",
                 fed_by("ls " + from + "/frames; printf en"));
}

TEST_F(Flow, ABuildThatFollowsRefusesAPhotoThatIsNotThereAndKnownCameras) {
  const std::string from = capture();
  const std::vector<std::string> words{"build", from, "-o", path("a.ldp"), "--follow"};
  expect_refusal(words, 2, "there is no photo 'frame_77.jpg'", fed_by("echo frame_77.jpg; sleep 5; echo end"));
  expect_refusal(words, 2, "there is no photo ''", fed_by("echo; echo end"));
  std::vector<std::string> with_cameras = words;
  with_cameras.insert(with_cameras.end(), {"--cameras", from + "/transforms.json"});
  expect_refusal(with_cameras, 2, "--cameras");
}

TEST_F(Flow, RefusesAnEmptyFolderOnePhotoAndNoFolder) {
  fs::create_directory(path("empty"));
  photo("one/a.jpg");
  expect_refusal({"build", path("empty"), "-o", path("a.ldp")}, 2, "no .jpg or .png photos");
  expect_refusal({"build", path("one"), "-o", path("a.ldp")}, 1, "one photo only");
  expect_refusal({"build", path("none"), "-o", path("a.ldp")}, 2, "there is no such folder");
}

TEST_F(Flow, NamesWhatAFolderHoldsInsteadOfPhotosAndHowToConvertIt) {
  const auto with = [&](const std::string& file) {
    fs::create_directories(fs::path(path(file)).parent_path());
    std::ofstream(path(file)) << "x";
    return std::vector<std::string>{"build", fs::path(path(file)).parent_path().string(), "-o", path("a.ldp")};
  };
  with("mixed/b.TIF");
  with("mixed/c.TIF");
  expect_refusal(with("mixed/a.webp"), 2, "in it but 2 .TIF, 1 .webp: convert them in there with: mogrify -format jpg");
  for (const char* ending : {".webp", ".tiff", ".gif"})
    expect_refusal(with(std::string("other") + ending + "/a" + ending), 2,
                   "but 1 " + std::string(ending) + ": convert");
  expect_refusal(with("film/a.mov"), 2, "but a.mov: give that itself, " + path("film/a.mov"));
  expect_refusal(with("texts/a.txt"), 2, "no .jpg or .png photos in it: give a folder of photos");
}

TEST_F(Flow, RefusesAFolderAPhotoAndCamerasThatCannotBeRead) {
  for (const char* name : {"a.jpg", "b.jpg", "c.jpg"}) photo("photos/" + std::string(name));
  std::vector<std::string> through;
  if (::geteuid() == 0) through = {"setpriv", "--bounding-set=-dac_override,-dac_read_search"};
  const std::vector<std::string> words{"build", path("photos"), "-o", path("a.ldp")};
  fs::permissions(path("photos/b.jpg"), fs::perms::none);
  expect_refusal(words, 2, "b.jpg: cannot be read (Permission denied)", through);
  fs::permissions(path("photos/b.jpg"), fs::perms::owner_all);
  const std::string from = capture();
  std::ofstream(path("cameras.json")) << "{\n\"frames\": [\n";
  const Outcome cut = ldp({"build", from, "-o", path("a.ldp"), "--cameras", path("cameras.json")});
  EXPECT_EQ(cut.status, 2);
  EXPECT_THAT(cut.err, HasSubstr("cameras.json: not valid JSON in line 3"));
  EXPECT_THAT(cut.err, testing::Not(HasSubstr("exception")));
  const Outcome little =
      ldp({"build", from, "-o", path("a.ldp"), "--cameras", from + "/transforms.json", "--memory", "64"});
  EXPECT_THAT(little.err, HasSubstr(" 64 bytes are allowed"));
  // A folder is named and closed at last: contents() could not look into it.
  fs::permissions(path("photos"), fs::perms::none);
  const Outcome closed = Running(words, room_, through).wait();
  fs::permissions(path("photos"), fs::perms::owner_all);
  EXPECT_EQ(closed.status, 2) << closed.err;
  EXPECT_THAT(closed.err, HasSubstr("photos: cannot be read (Permission denied)"));
}

TEST_F(Flow, RefusesMixedSizesAndATruncatedPhotoByName) {
  for (const char* name : {"mixed/a.jpg", "mixed/c.jpg", "cut/a.jpg", "cut/b.jpg", "cut/c.jpg"}) photo(name);
  photo("mixed/b.jpg", 80, 48);
  expect_refusal({"build", path("mixed"), "-o", path("a.ldp")}, 1, "b.jpg: its size is not that of most photos");
  photo("mixed/d.jpg", 80, 48);
  expect_refusal({"build", path("mixed"), "-o", path("a.ldp")}, 2, "b.jpg 80x48");
  fs::resize_file(path("cut/b.jpg"), fs::file_size(path("cut/b.jpg")) / 2);
  expect_refusal({"build", path("cut"), "-o", path("a.ldp")}, 2, "b.jpg");
}

TEST_F(Flow, RefusesAnOutputThatCannotBeWrittenBeforeTheWorkBegins) {
  photo("photos/a.jpg");
  expect_refusal({"build", path("photos"), "-o", path("missing/a.ldp")}, 2, "its folder does not exist");
  expect_refusal({"build", path("photos"), "-o", path("photos")}, 2, "is a folder");
  fs::create_directory(path("locked"));
  fs::permissions(path("locked"), fs::perms::owner_read | fs::perms::owner_exec);
  std::vector<std::string> through;  // read-only folders do not stop the administrator, unless this right is given up
  if (::geteuid() == 0) through = {"setpriv", "--bounding-set=-dac_override,-dac_read_search"};
  expect_refusal({"build", path("photos"), "-o", path("locked/a.ldp")}, 2, "cannot be written", through);
}

TEST_F(Flow, ABuildWithoutAnOutputSaysWhichOptionIsMissing) {
  photo("photos/a.jpg");
  expect_refusal({"build", path("photos")}, 2,
                 "-o FILE.ldp is missing or empty: name the panorama to write, such as: ldp build " + path("photos") +
                     " -o room.ldp");
}

TEST_F(Flow, AnEstimateTakesNoOptionThatItWouldNotHeed) {
  photo("photos/a.jpg");
  const std::vector<std::string> estimate = {"build", path("photos"), "--estimate"};
  for (const auto& [option, says] :
       {std::pair("--report", "--json > " + path("a.json")), {"--debug", "--debug could draw"}}) {
    std::vector<std::string> words = estimate;
    words.insert(words.end(), {option, path("a.json")});
    expect_refusal(words, 2, says);
  }
}

TEST_F(Flow, NeverWritesOverAFileOfAnotherKind) {
  photo("kept/a.jpg");
  const std::string taken = path("kept/a.jpg"), before = text_of(taken);
  expect_refusal({"build", path("kept"), "-o", taken}, 2, "exists and is no .ldp file");
  expect_refusal({"build", path("kept"), "-o", path("a.ldp"), "--report", taken}, 2, "exists and is no .json file");
  expect_refusal({"poses", path("kept"), "-o", taken}, 2, "exists and is no .json file");
  expect_refusal({"build", path("kept"), "-o", path("a.ldp"), "--report", path("a.ldp")}, 2, "choose two names");
  EXPECT_EQ(text_of(taken), before);
}

TEST_F(Flow, LittleMemoryMakesACoarserPanoramaAndTooLittleIsRefused) {
  const std::string from = capture();
  expect_refusal({"build", from, "-o", path("a.ldp"), "--cameras", from + "/transforms.json", "--memory", "1M"}, 1,
                 "needs at least");
  const auto built = [&](const std::string& memory) {
    const Outcome outcome =
        ldp({"build", from, "-o", path("a.ldp"), "--cameras", from + "/transforms.json", "--memory", memory, "--json"});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    const Outcome info = ldp({"info", path("a.ldp"), "--json"});
    return std::pair(nlohmann::json::parse(info.out)["grid"]["width"].get<int>(),
                     nlohmann::json::parse(outcome.out)["notes"]);
  };
  const auto [width, notes] = built("0");
  const auto [coarser, reasons] = built("42M");
  EXPECT_LT(coarser, width);
  EXPECT_GT(coarser, 0.4 * width);
  EXPECT_EQ(notes.size(), 0U);
  ASSERT_EQ(reasons.size(), 1U);
  EXPECT_THAT(reasons[0].get<std::string>(), HasSubstr("to fit the memory allowed"));
}

TEST_F(Flow, WhatIsWrongWithASweepIsToldBeforeThePanoramaIsMade) {
  const auto told = [&](const std::string& name, const std::string& blur) {
    const Outcome made = ldp({"scene", "courtyard", "-o", path(name), "--frames", "8", "--arc", "70", "--size",
                              "240x180", "--blur", blur, "--no-novel"});
    EXPECT_EQ(made.status, 0) << made.err;
    const Outcome built = ldp({"build", path(name), "-o", path(name + ".ldp"), "--cameras",
                               path(name + "/transforms.json"), "--effort", "fast", "--progress-fd", "2"});
    EXPECT_EQ(built.status, 0) << built.err;
    return built.err;
  };
  const std::string blurred = told("blurred", "25");
  const size_t remark = blurred.find("1.0000 so far: sweep again: the photos between 0 and 69 degrees are blurred");
  ASSERT_NE(remark, std::string::npos) << blurred;
  EXPECT_LT(remark, blurred.find("layer 1 iteration 1"));
  EXPECT_GT(remark, blurred.find("rectify"));
  EXPECT_THAT(told("sharp", "0"), testing::Not(HasSubstr("so far")));
}

TEST_F(Flow, BeyondItsMemoryABuildWorksInFilesWithoutNamesAndWritesTheSameBytes) {
  ASSERT_EQ(
      ldp({"scene", "room", "-o", path("room"), "--frames", "10", "--arc", "120", "--size", "640x480", "--no-novel"})
          .status,
      0);
  const auto built = [&](const std::string& memory) {
    const std::string file = path("out/" + memory + ".ldp");
    const Outcome outcome = ldp({"build", path("room"), "-o", file, "--cameras", path("room/transforms.json"),
                                 "--layers", "1", "--labels", "4", "--memory", memory, "--json"});
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    const auto report = nlohmann::json::parse(outcome.out);
    EXPECT_EQ(report["scratch_files"], memory != "0");
    EXPECT_EQ(report["notes"].size(), 0U) << outcome.out;
    return read_file(file);
  };
  fs::create_directory(path("out"));
  const std::vector<uint8_t> easy = built("0"), tight = built("60M");
  EXPECT_TRUE(easy == tight);
  EXPECT_EQ(std::distance(fs::directory_iterator(path("out")), fs::directory_iterator()), 2)
      << "more than the panoramas";
}

TEST_F(Flow, RefusesAPanoramaThatWasCutShortOrChanged) {
  const std::string file = panorama(capture());
  fs::copy_file(file, path("cut.ldp"));
  fs::resize_file(path("cut.ldp"), fs::file_size(file) / 2);
  expect_refusal({"verify", path("cut.ldp")}, 1, "cut.ldp");
  expect_refusal({"info", path("cut.ldp")}, 2, "cut.ldp");
  expect_refusal({"export", path("cut.ldp"), "-o", path("a.json")}, 2, "cut.ldp");
  expect_refusal({"render", path("cut.ldp"), "--cameras", path("capture/novel.json"), "-o", path("views")}, 2,
                 "cut.ldp");
  std::vector<uint8_t> bytes = read_file(file);
  bytes[bytes.size() / 2] ^= 0x10;
  write_file(path("changed.ldp"), bytes);
  expect_refusal({"verify", path("changed.ldp")}, 1, "changed.ldp");
  expect_refusal({"info", path("changed.ldp")}, 2, "changed.ldp");
  expect_refusal({"export", path("changed.ldp"), "-o", path("a.json")}, 2, "changed.ldp");
  expect_refusal({"render", path("changed.ldp"), "--path", "sway", "-o", path("views")}, 2, "changed.ldp");
}

TEST_F(Flow, WhatToDoAboutAFileDependsOnWhetherItIsDamagedEmptyOrOfAnotherKind) {
  const std::vector<uint8_t> whole = read_file(LDP_SOURCE "/tests/golden/tiny.ldp");
  write_file(path("cut.ldp"), std::span(whole).first(whole.size() / 2));
  std::ofstream(path("empty.ldp"));
  photo("photo.jpg");
  write_file(path("picture.png"), encode_png(RgbImage(64, 48)));
  for (const auto& [name, says] : std::map<std::string, std::string>{
           {"cut.ldp", "bytes, found " + std::to_string(whole.size() / 2) +
                           ": copy the file again, or build the panorama again\n"},
           {"empty.ldp", ": the file is empty: build the panorama again, or give another file\n"},
           {"photo.jpg", ": is no .ldp file: give one that ldp build made\n"},
           {"picture.png", ": is no .ldp file: give one that ldp build made\n"}}) {
    expect_refusal({"verify", path(name)}, 1, says);
    expect_refusal({"info", path(name)}, 2, says);
    expect_refusal({"export", path(name), "-o", path("a.json")}, 2, says);
  }
}

TEST_F(Flow, APhotoThatIsDamagedOrLeftOutIsNamedWithTheReason) {
  ASSERT_EQ(ldp({"scene", "room", "-o", path("room"), "--size", "96x72", "--frames", "4", "--arc", "30", "--no-novel"})
                .status,
            0);
  const std::vector<std::string> words{
      "build", path("room"), "-o", path("a.ldp"), "--cameras", path("room/transforms.json"), "--layers",
      "1",     "--labels",   "2"};
  fs::copy_file(path("room/frames/000.png"), path("room/frames/extra.png"));
  const Outcome built = ldp(words);
  EXPECT_EQ(built.status, 0) << built.err;
  EXPECT_THAT(built.out, HasSubstr("4 of 5 photos"));
  EXPECT_THAT(built.out, HasSubstr("extra.png: left out: no camera of its name and size was given\n"));

  auto cameras = nlohmann::json::parse(text_of(path("room/transforms.json")));
  auto camera = cameras["frames"][1];
  camera["file_path"] = "frames/extra.png";
  for (size_t row = 0; row < 3; ++row)
    for (size_t column = 0; column < 3; ++column) camera["transform_matrix"][row][column] = row == column ? 1 : 0;
  cameras["frames"].push_back(camera);
  camera["file_path"] = "frames/narrow.png";
  cameras["frames"].push_back(camera);
  std::ofstream(path("down.json")) << cameras;
  write_file(path("room/frames/narrow.png"), encode_png(RgbImage(72, 96)));
  const Outcome level = ldp(
      {"build", path("room"), "-o", path("a.ldp"), "--cameras", path("down.json"), "--layers", "1", "--labels", "2"});
  EXPECT_EQ(level.status, 0) << level.err;
  EXPECT_THAT(level.out, HasSubstr("4 of 6 photos"));
  EXPECT_THAT(level.out, HasSubstr("extra.png: left out: it looks straight up or down\n"));
  EXPECT_THAT(level.out, HasSubstr("narrow.png: left out: no camera of its name and size was given\n"));
  const Outcome judged = ldp({"evaluate", path("room"), "--cameras", path("down.json"), "--every", "4", "--layers", "1",
                              "--labels", "2", "--json"});
  EXPECT_EQ(judged.status, 0) << judged.err;
  const auto parsed = nlohmann::json::parse(judged.out);
  EXPECT_EQ(parsed["views"].size(), 1U);
  ASSERT_EQ(parsed["left_out"].size(), 2U);
  EXPECT_EQ(parsed["left_out"][0]["name"], "narrow.png");
  EXPECT_EQ(parsed["left_out"][1]["reason"], "it looks straight up or down");
  const Outcome told =
      ldp({"evaluate", path("room"), "--cameras", path("down.json"), "--every", "4", "--layers", "1", "--labels", "2"});
  EXPECT_THAT(told.out, testing::StartsWith("built from 3 photos, compared with 1 that it was built without\n"
                                            "narrow.png: left out: no camera of its name and size was given\n"
                                            "extra.png: left out: it looks straight up or down\n"));
  fs::remove(path("room/frames/narrow.png"));

  fs::resize_file(path("room/frames/002.png"), 2000);
  expect_refusal(words, 2,
                 "ldp build: " + path("room/frames/002.png") +
                     ": damaged PNG (the file ends too early): copy it again, or leave it out\n");
  fs::resize_file(path("room/frames/001.png"), 2000);
  expect_refusal(words, 2,
                 "ldp build: " + path("room") +
                     ": 2 of 5 photos are damaged (001.png and 002.png): copy them again, or leave them out\n");
}

TEST_F(Flow, AnOutputThatTheSystemRefusesIsToldWithWhatToDo) {
  expect_refusal(
      {"export", LDP_SOURCE "/tests/golden/tiny.ldp", "-o", "/proc/x.png"}, 1,
      "ldp export: cannot write /proc/x.png: No such file or directory: choose another folder to write to\n");
  expect_refusal({"build", path("none"), "-o", "/proc/x.ldp"}, 1, "ldp build: cannot write /proc/x.ldp");
  expect_refusal({"build", path("none"), "-o", path("room.ldp/")}, 2, "room.ldp/: is the name of a folder");
}

TEST_F(Flow, RefusesUnknownWordsAndBadValuesInOneLine) {
  expect_refusal({}, 2, "ldp --help");
  expect_refusal({"bild"}, 2, "there is no command 'bild'");
  expect_refusal({"build", path("x"), "-o", path("a.ldp"), "--labels", "17"}, 2, "--labels");
  expect_refusal({"build", path("x"), "-o", path("a.ldp"), "--wide"}, 2, "--wide");
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"scene", "moon", "-o", path("moon")}, {"scene", "moon"}})
    expect_refusal(words, 2, "no scene is called 'moon'; there are courtyard, ");
  expect_refusal({"scene", "room", "-o", path("room"), "--size", "9x9"}, 2, "--size");
  expect_refusal({"render", path("none.ldp"), "--path", "sway", "-o", path("views")}, 2, "none.ldp");
  expect_refusal({"render", path("none.ldp"), "-o", path("views")}, 2, "none.ldp: there is no such file");
  expect_refusal({"build", "--hel"}, 2, "not expected: --hel: see ldp build --help");
  expect_refusal({"--hel"}, 2, "ldp: The following argument was not expected: --hel: see ldp --help");
  for (const std::vector<std::string>& words : {std::vector<std::string>{"build"}, {"build", "--"}})
    expect_refusal(words, 2, "CAPTURE is required");
  const std::vector<std::string> device{"bash", "-c", "exec \"${0%/*}/ldp-device\" \"$@\""};
  expect_refusal({"watch", "--loud"}, 2, "ldp watch: ");
  expect_refusal({"watch", "--loud"}, 2, "not expected: --loud: see ldp-device watch --help", device);
  expect_refusal({"build"}, 2, "ldp-device: there is no command 'build': see ldp-device --help", device);
}

TEST_F(Flow, ANameWithSpacesThatLacksItsQuotesIsTold) {
  fs::create_directories(path("my photos"));
  expect_refusal({"build", path("my"), "photos", "-o", path("a.ldp")}, 2, "is one name, with spaces: write '");
  expect_refusal({"build", path("their"), "photos", "-o", path("a.ldp")}, 2, "there is no such");
  expect_refusal({"build", path("my"), "photos"}, 2, "is one name, with spaces: write '");
  expect_refusal({"build", path("0.jpg"), std::string(300, '1'), "-o", path("a.ldp")}, 2, "0.jpg: there is no such");
  expect_refusal({"build", "", "-o", path("a.ldp")}, 2, "the name of a capture is empty");
  expect_refusal({"info", ""}, 2, "ldp info: the name of a file is empty");
  expect_refusal({"summary", ""}, 2, "ldp summary: the name of a folder is empty");
}

TEST_F(Flow, ASummaryOfNothingSaysSo) {
  fs::create_directories(path("builds"));
  const Outcome summary = ldp({"summary", path("builds")});
  EXPECT_EQ(summary.status, 0);
  EXPECT_EQ(summary.err, "ldp summary: " + path("builds") + ": holds neither panoramas (.ldp) nor reports of builds\n");
}

TEST_F(Flow, NanIsNoNumberToAnyOption) {
  for (const char* command : {"build", "poses", "evaluate"})
    for (const char* option : {"--fov", "--arm-length", "--megapixels"})
      expect_refusal({command, path("x"), option, "nan"}, 2, std::string(option) + ": Value nan");
  for (const char* option : {"--near", "--far"})
    expect_refusal({"build", path("x"), "-o", path("a.ldp"), option, "NaN"}, 2, std::string(option) + ": Value NaN");
  expect_refusal({"render", path("a.ldp"), "--path", "sway", "-o", path("views"), "--fov", "nan"}, 2,
                 "--fov: Value nan");
  for (const char* option : {"--arc", "--radius", "--fov", "--k1", "--jitter-position", "--jitter-angle",
                             "--exposure-drift", "--noise", "--blur", "--moving", "--crowd"})
    expect_refusal({"scene", "room", "-o", path("room"), option, "nan"}, 2, std::string(option) + ": Value nan");
  expect_refusal({"scene", "room", "-o", path("room"), "--arc", "361"}, 2, "not in range");
  expect_refusal({"scene", "room", "-o", path("room"), "--arc", "0,3"}, 2, "--arc: Value 0,3 is not a number");
  expect_refusal({"capture", "-o", path("sweep"), "--fov", "0,3"}, 2, "--fov: Value 0,3 is not a number");
}

TEST_F(Flow, ADepthOnTheWrongSideOfThoseOfThePhotosIsRefusedByItsOption) {
  ASSERT_EQ(
      ldp({"scene", "room", "-o", path("room"), "--frames", "6", "--arc", "60", "--size", "240x180", "--no-novel"})
          .status,
      0);
  const std::vector<std::string> words{"build",       path("room"), "-o",
                                       path("a.ldp"), "--cameras",  path("room/transforms.json")};
  const auto with = [&](const std::string& option, const std::string& depth) {
    std::vector<std::string> all = words;
    all.insert(all.end(), {option, depth});
    return all;
  };
  expect_refusal(with("--far", "1e-9"), 2, "--far 1e-09: is nearer than what is nearest in the photos, at ");
  expect_refusal(with("--near", "1e9"), 2, "--near 1e+09: is farther than what is farthest in the photos, at ");
}

TEST_F(Flow, EveryCommandHasHelp) {
  for (const char* command : {"build", "render", "info", "verify", "evaluate", "poses", "scene"}) {
    const Outcome help = ldp({command, "--help"});
    EXPECT_EQ(help.status, 0);
    EXPECT_THAT(help.out, HasSubstr("Usage:")) << command;
    EXPECT_THAT(help.out, testing::Not(HasSubstr("Exit status:"))) << command;
  }
  EXPECT_THAT(ldp({"--help"}).out, HasSubstr("Exit status:"));
}

TEST_F(Flow, CtrlCStopsAtOnceAndLeavesNothing) {
  const auto before = contents();
  const Running scene({"scene", "garden", "-o", path("garden"), "--frames", "200"}, room_);
  // Work has begun when its temporary folder is there.
  while (contents() == before) std::this_thread::yield();
  const auto pressed = std::chrono::steady_clock::now();
  scene.interrupt();
  const Outcome outcome = scene.wait();
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - pressed;
  EXPECT_EQ(outcome.status, 130);
  EXPECT_EQ(outcome.err, "ldp scene: interrupted: nothing was written\n");
  EXPECT_LT(took.count(), kSanitized ? 5 : 0.5);  // 0.2 s on an idle machine
  EXPECT_EQ(contents(), before);
}

}  // namespace
}  // namespace ldp
