// What the command-line tool does to files: what it refuses to write over, folders that appear whole, progress.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <fstream>

#include "core/base/files.h"
#include "core/base/job.h"
#include "device/tool/memory_size.h"
#include "device/tool/number_within.h"
#include "device/tool/output.h"
#include "device/tool/own_output.h"
#include "device/tool/process/progress_bar.h"
#include "device/tool/session.h"

namespace ldp {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

class ToolParts : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = testing::TempDir() + "ldp_tool_XXXXXX";
    room_ = mkdtemp(name.data());
  }
  void TearDown() override { fs::remove_all(room_); }

  fs::path put(const std::string& name, const std::string& content) const {
    std::ofstream(room_ / name) << content;
    return room_ / name;
  }
  static std::string refusal(const std::function<void()>& work) {
    try {
      work();
    } catch (const BadInput& error) {
      return error.what();
    }
    return "";
  }
  std::vector<std::string> contents() const {
    std::vector<std::string> all;
    for (const auto& entry : fs::recursive_directory_iterator(room_))
      all.push_back(fs::relative(entry.path(), room_).string());
    std::sort(all.begin(), all.end());
    return all;
  }

  fs::path room_;
};

TEST_F(ToolParts, AFileIsReplacedOnlyByOneOfItsKind) {
  const std::string ours = R"({"software": "ldp", "frames": [{"transform_matrix": []}]})";
  const std::pair<std::string, OutputKind> own[] = {
      {put("a.ldp", "\xABLDP rest").string(), OutputKind::panorama},
      {put("report.json", R"({"options": {}, "seconds": {}, "panorama": {}})").string(), OutputKind::report},
      {put("transforms.json", ours).string(), OutputKind::cameras},
      {put("a.jpg", "GPano:ProjectionType=\"equirectangular\" GPano:StitchingSoftware=\"ldp 1\"").string(),
       OutputKind::picture},
      {put("a.glb", "glTF layered-depth-panorama").string(), OutputKind::mesh},
      {put("a.html", "<title>Layered depth panorama</title>").string(), OutputKind::viewer},
      {put("a.mp4", std::string(100'000, 'x') + kRendered).string(), OutputKind::film}};
  const auto refused = [](const std::string& file, OutputKind kind) {
    return refusal([&] { check_output_file(file, kind); });
  };
  for (const auto& [file, kind] : own) {
    EXPECT_EQ(refused(file, kind), "") << file;
    for (const auto& [other, other_kind] : own) {
      if (other_kind == kind) continue;
      EXPECT_NE(refused(other, kind), "") << other << " by " << file;
    }
  }
}

TEST_F(ToolParts, WhatOnlyLooksLikeItsKindIsKept) {
  const auto kept = [&](const fs::path& file, OutputKind kind) {
    return refusal([&] { check_output_file(file, kind); });
  };
  EXPECT_THAT(kept(put("a.ldp", "a text"), OutputKind::panorama), HasSubstr("exists and is no .ldp file"));
  EXPECT_THAT(kept(put("b.json", R"({"frames": [{"transform_matrix": []}]})"), OutputKind::cameras),
              HasSubstr("exists and is no transforms.json of this program: choose another name, or remove it first"));
  EXPECT_NE(kept(put("c.json", R"({"software": "ldp", "frames": [{"file": 1}]})"), OutputKind::cameras), "");
  EXPECT_NE(kept(put("d.json", R"({"software": "ldp", "frames": [7]})"), OutputKind::cameras), "");
  EXPECT_NE(kept(put("e.json", "{"), OutputKind::cameras), "");
  EXPECT_NE(kept(put("capture.json", R"({"software": "ldp", "frames": []})"), OutputKind::cameras), "")
      << "a capture's record";
  EXPECT_NE(kept(put("f.jpg", "GPano:ProjectionType=\"equirectangular\""), OutputKind::picture), "")
      << "someone else's";
  EXPECT_EQ(kept(put("g.ldp", ""), OutputKind::panorama), "") << "an empty one holds nothing";
  EXPECT_EQ(kept(room_ / "new.ldp", OutputKind::panorama), "");
  EXPECT_THAT(kept(room_ / "new.jpg", OutputKind::panorama), HasSubstr("is no name of a .ldp file"));
  EXPECT_EQ(kept(room_ / "version.5", OutputKind::panorama), "") << ".5 is no ending";
}

TEST_F(ToolParts, ExportsAreKnownByTheirEndings) {
  EXPECT_EQ(exported_kind("a.JSON"), OutputKind::cameras);
  EXPECT_EQ(exported_kind("a.glb"), OutputKind::mesh);
  EXPECT_EQ(exported_kind("a.htm"), OutputKind::viewer);
  EXPECT_EQ(exported_kind("a.HTML"), OutputKind::viewer);
  EXPECT_EQ(exported_kind("a.png"), OutputKind::picture);
  EXPECT_EQ(extension_of("Film.MP4"), ".mp4");
  EXPECT_EQ(extension_of("film"), "");
}

TEST_F(ToolParts, NamesThatCannotBeWrittenAreRefusedBeforeTheWork) {
  EXPECT_THAT(refusal([] { check_output_file(fs::path()); }), HasSubstr("the name of an output is empty"));
  EXPECT_THAT(refusal([&] { check_output_file(room_); }), HasSubstr("is a folder"));
  EXPECT_THAT(refusal([&] { check_output_file(room_ / "no" / "a.ldp"); }),
              AllOf(HasSubstr("its folder does not exist: create "), HasSubstr("no first")));
  EXPECT_THAT(refusal([&] { check_output_file(fs::path(put("file", "x")) / "a.ldp"); }), HasSubstr("file is a file)"));
  EXPECT_EQ(refusal([] { check_output_file(fs::path("/dev/null")); }), "");
  EXPECT_THAT(refusal([&] { check_input_file(room_ / "nothing"); }), HasSubstr("there is no such file"));
  EXPECT_THAT(refusal([&] { check_input_file(room_); }), HasSubstr("is a folder: give the name of a file"));
  EXPECT_EQ(refusal([&] { check_input_file(put("here", "x")); }), "");
}

TEST_F(ToolParts, AMachineThatLetsTheJobDownIsToldFromAWrongName) {
  for (const int fault : {ENOSPC, EDQUOT, EIO, EROFS, ENOMEM, EAGAIN, EMFILE, ENFILE, ESTALE})
    EXPECT_TRUE(is_machine_fault({fault, std::generic_category()})) << fault;
  for (const int asked : {ENOENT, EACCES, EPERM, EISDIR, ENOTDIR, ENAMETOOLONG, EINVAL, 0})
    EXPECT_FALSE(is_machine_fault({asked, std::system_category()})) << asked;
  EXPECT_FALSE(is_machine_fault({ENOSPC, std::iostream_category()})) << "another category's numbers";
}

TEST_F(ToolParts, AFolderThatCannotBeFilledTellsWhoIsAtFault) {
  const OutputFolder folder(room_ / "views", OutputFolder::Existing::refuse);
  const auto fail_by = [&](int error) {
    folder.fill([&] {
      throw std::system_error(error, std::generic_category(), "cannot write " + (folder.path() / "a.png").string());
    });
  };
  EXPECT_THROW(fail_by(ENOSPC), MachineFault);
  EXPECT_THROW(fail_by(EACCES), Impossible);
}

TEST_F(ToolParts, AFileThatCannotBeWrittenIsToldWithWhatToDo) {
  try {
    write_text("/proc/views.json", "{}");
    FAIL();
  } catch (const Impossible& refused) {
    EXPECT_STREQ(refused.what(),
                 "cannot write /proc/views.json: No such file or directory: choose another folder to write to");
  }
}

TEST_F(ToolParts, AFolderAppearsWholeOrNotAtAll) {
  {
    const OutputFolder folder(room_ / "views", OutputFolder::Existing::refuse);
    folder.fill([&] { std::ofstream(folder.path() / "a.jpg") << "x"; });
    EXPECT_FALSE(fs::exists(room_ / "views"));
  }
  EXPECT_THAT(contents(), testing::IsEmpty()) << "it was not kept";
  OutputFolder folder(room_ / "views", OutputFolder::Existing::refuse);
  folder.fill([&] { std::ofstream(folder.path() / "a.jpg") << "x"; });
  folder.keep();
  EXPECT_THAT(contents(), testing::ElementsAre("views", "views/a.jpg"));
  EXPECT_THAT(refusal([&] { OutputFolder(room_ / "views", OutputFolder::Existing::refuse); }),
              HasSubstr("is there already and not empty"));
}

TEST_F(ToolParts, AFolderThatIsThereIsFilledFileByFile) {
  fs::create_directories(room_ / "views" / "depth");
  put("views/old.jpg", "old");
  put("views/both.jpg", "old");
  {
    OutputFolder folder(room_ / "views" / "", OutputFolder::Existing::merge);
    fs::create_directory(folder.path() / "depth");
    for (const char* const name : {"both.jpg", "new.jpg", "depth/a.png"}) std::ofstream(folder.path() / name) << "new";
    folder.keep();
  }
  EXPECT_THAT(contents(), testing::ElementsAre("views", "views/both.jpg", "views/depth", "views/depth/a.png",
                                               "views/new.jpg", "views/old.jpg"));
  EXPECT_EQ(read_file(room_ / "views" / "both.jpg").size(), 3U);
  EXPECT_EQ(read_file(room_ / "views" / "both.jpg")[0], 'n');
  EXPECT_EQ(read_file(room_ / "views" / "old.jpg")[0], 'o');
}

TEST_F(ToolParts, AFileThatCannotBeWrittenIsToldByTheNameItWouldHaveHad) {
  const OutputFolder folder(room_ / "views", OutputFolder::Existing::refuse);
  try {
    folder.fill([&] { write_file(folder.path() / "deep" / "a.jpg", std::string_view("x")); });
    ADD_FAILURE() << "it was written";
  } catch (const Impossible& error) {
    EXPECT_THAT(error.what(),
                AllOf(HasSubstr((room_ / "views" / "deep" / "a.jpg").string()), testing::Not(HasSubstr(".partial-"))));
  }
  EXPECT_THROW(folder.fill([] { throw std::system_error(std::make_error_code(std::errc::io_error), "elsewhere"); }),
               std::system_error);
}

TEST_F(ToolParts, AFolderNamedLikeAFileIsRefused) {
  const auto refused = [&](const std::string& name) {
    return refusal([&] { OutputFolder(room_.string() + "/" + name, OutputFolder::Existing::refuse); });
  };
  EXPECT_THAT(refused("a.webp"), HasSubstr("is no kind of file that this can be written to"));
  EXPECT_EQ(refused("a.webp/"), "");
  EXPECT_EQ(refused("a.5"), "");
  EXPECT_EQ(refused("of.the.garden"), "");
  EXPECT_THAT(refused("no/views"), HasSubstr("its folder does not exist"));
  put("file", "x");
  EXPECT_THAT(refused("file"), HasSubstr("is a file"));
}

TEST_F(ToolParts, ProgressIsALineAStageAndTheLastOneAlways) {
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  {
    ProgressBar bar(ends[1]);
    bar.show("poses", 0.1);
    for (int i = 0; i < 50; ++i) bar.show("poses", 0.2);  // too soon
    bar.show("solve", -1);
    bar.show("solve", 7);
  }
  ProgressBar(-1).show("nobody", 0.5);
  char text[4096];
  const ssize_t got = ::read(ends[0], text, sizeof text);
  EXPECT_EQ(std::string(text, static_cast<size_t>(got)), "0.1000 poses\n0.0000 solve\n1.0000 solve\n");
  ::close(ends[0]);
  ::close(ends[1]);
}

TEST(Sizes, AreNumbersWithAUnitAndNothingElse) {
  const auto read = [](std::string text) { return memory_size("all")(text); };
  for (const char* const good : {"0", "1000", "128M", "128MB", "1G", "2gb", "7k"}) EXPECT_EQ(read(good), "") << good;
  for (const char* const bad : {"", "M", "1.5G", "-1", "+1", "1 M", "1e9", "nan", "0x10", "1M1", "5Q"})
    EXPECT_EQ(read(bad),
              "'" + std::string(bad) +
                  "' is not a size such as 128M or 1G, a whole number of bytes, K, M, G or T, nor 0 for all");
}

TEST(Numbers, LieWithinTheirBoundsAndNanDoesNot) {
  const auto read = [](std::string text) { return number_within(0.3, 0.95)(text); };
  for (const char* const good : {"0.3", "0.95", "0.5"}) EXPECT_EQ(read(good), "") << good;
  for (const char* const bad : {"0.29", "0.96", "-1", "nan", "inf", "half", ""}) EXPECT_NE(read(bad), "") << bad;
}

TEST(Numbers, ThatAreWholeAreAskedForAsSuch) {
  const auto read = [](std::string text) { return whole_within(1, 101)(text); };
  for (const char* const good : {"1", "95", "101"}) EXPECT_EQ(read(good), "") << good;
  for (const char* const bad : {"0", "102", "-1", "95.5", "1e1", "99999999999", "x", "", "5 "})
    EXPECT_EQ(read(bad), "Value " + std::string(bad) + " is not a whole number from 1 to 101");
  std::string negative = "-1";
  EXPECT_NE(whole_within(0U, 7U)(negative), "");
  EXPECT_EQ(whole_within(1, 101).get_description(), "INT in [1 - 101]");
}

}  // namespace
}  // namespace ldp
