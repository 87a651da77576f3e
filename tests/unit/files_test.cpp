// Whole files: replaced or left alone, never half.
#include "core/base/files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <fstream>
#include <functional>
#include <string>
#include <system_error>
#include <tuple>

namespace {

mode_t widest_mode = 0;  // of files when their mode is set

}  // namespace

// Instead of the C library's: notes what the mode was until then.
extern "C" int fchmod(int fd, mode_t mode) {
  struct stat status {};
  if (::fstat(fd, &status) == 0) widest_mode |= status.st_mode & 0777U;
  return static_cast<int>(::syscall(SYS_fchmod, fd, mode));
}

namespace ldp {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class Files : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = testing::TempDir() + "ldp_files_XXXXXX";
    folder_ = ::mkdtemp(name.data());
  }
  void TearDown() override { fs::remove_all(folder_); }

  size_t files() const {
    return static_cast<size_t>(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }

  fs::path folder_;
};

std::string message_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const std::system_error& error) {
    return error.what();
  }
  return "nothing was thrown";
}

TEST_F(Files, AreWrittenWholeOrNotAtAll) {
  const std::vector<uint8_t> first = {1, 2, 3};
  const std::vector<uint8_t> second = {4, 5};
  write_file(folder_ / "a", first);
  write_file(folder_ / "a", second);
  EXPECT_EQ(read_file(folder_ / "a"), second);
  EXPECT_EQ(files(), 1u);
  EXPECT_THAT(message_of([&] { write_file(folder_ / "missing/a", first); }), HasSubstr("missing/a"));
  fs::create_directory(folder_ / "taken");
  EXPECT_THROW(write_file(folder_ / "taken", first), std::system_error);
  EXPECT_EQ(files(), 2u);
  EXPECT_EQ(MappedFile(folder_ / "a").bytes().size(), 2u);
}

TEST_F(Files, ALinkStaysALink) {
  write_file(folder_ / "a", std::vector<uint8_t>{1});
  fs::create_symlink("a", folder_ / "link");
  write_file(folder_ / "link", std::vector<uint8_t>{2});
  EXPECT_TRUE(fs::is_symlink(folder_ / "link"));
  EXPECT_EQ(read_file(folder_ / "a"), std::vector<uint8_t>{2});
}

TEST_F(Files, MissingOnesAreNamed) {
  EXPECT_THAT(message_of([&] { read_file("/nowhere/a.jpg"); }), HasSubstr("/nowhere/a.jpg"));
  EXPECT_THAT(message_of([&] { read_file("/"); }), HasSubstr("Is a directory"));
}

TEST_F(Files, TextIsWrittenAsItIs) {
  write_file(folder_ / "a", "two\nlines");
  EXPECT_EQ(read_file(folder_ / "a"), (std::vector<uint8_t>{'t', 'w', 'o', '\n', 'l', 'i', 'n', 'e', 's'}));
}

TEST_F(Files, ASecretOneIsForItsOwnerAloneWhateverWasThere) {
  const fs::path file = folder_ / "secret";
  const mode_t before = ::umask(0);
  write_file(file, "open to all");
  write_secret_file(file, "a password");
  ::umask(before);
  EXPECT_EQ(fs::status(file).permissions(), fs::perms::owner_read | fs::perms::owner_write);
  const auto bytes = read_file(file);
  EXPECT_EQ(std::string(bytes.begin(), bytes.end()), "a password");
  EXPECT_EQ(files(), 1U);
  fs::create_directory(folder_ / "taken");
  EXPECT_THAT(message_of([&] { write_secret_file(folder_ / "taken", "a password"); }), HasSubstr("cannot write"));
  EXPECT_EQ(files(), 2U);
}

TEST_F(Files, WhoMayReadAFileMayReadTheOneThatReplacesItAndNobodyElse) {
  const auto mode = [&](const char* name) { return fs::status(folder_ / name).permissions(); };
  for (const fs::perms wanted : {fs::perms(0400), fs::perms(0600), fs::perms(0664)}) {
    for (const char* const name : {"written", "moved"}) {
      write_file(folder_ / name, "old");
      fs::permissions(folder_ / name, wanted);
    }
    write_file(folder_ / "written", "new");
    EXPECT_EQ(mode("written"), wanted);
    write_file(folder_ / "made", "new");
    move_file(folder_ / "made", folder_ / "moved");
    EXPECT_EQ(mode("moved"), wanted);
  }
}

TEST_F(Files, AFileOfAnotherStaysTheirs) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root gives files away";
  constexpr uid_t kNobody = 65534;
  for (const char* const name : {"written", "moved"}) {
    write_file(folder_ / name, "old");
    ASSERT_EQ(::chmod((folder_ / name).c_str(), 0640), 0);
    ASSERT_EQ(::chown((folder_ / name).c_str(), kNobody, kNobody), 0);
  }
  write_file(folder_ / "written", "new");
  write_file(folder_ / "made", "new");
  move_file(folder_ / "made", folder_ / "moved");
  for (const char* const name : {"written", "moved"}) {
    struct stat status {};
    ASSERT_EQ(::stat((folder_ / name).c_str(), &status), 0);
    EXPECT_EQ(std::tuple(status.st_uid, status.st_gid, status.st_mode & 0777U), std::tuple(kNobody, kNobody, 0640U));
  }
}

TEST_F(Files, WhatReplacesAFileIsAtNoMomentForMoreThanThat) {
  const mode_t before = ::umask(0);
  write_file(folder_ / "a", "old");
  fs::permissions(folder_ / "a", fs::perms(0640));
  widest_mode = 0;
  write_file(folder_ / "a", "new");
  ::umask(before);
  EXPECT_EQ(widest_mode & ~0640U, 0U) << std::oct << widest_mode;
}

TEST_F(Files, NamesBesideAreHiddenAndNeverTheSame) {
  const std::string first = name_beside(folder_ / "film.mp4", ".partial-", ".mp4").string();
  EXPECT_EQ(first.rfind((folder_ / ".film.mp4.partial-").string(), 0), 0U) << first;
  EXPECT_TRUE(first.ends_with(".mp4"));
  EXPECT_NE(name_beside(folder_ / "film.mp4", ".partial-", ".mp4"), first);
}

TEST_F(Files, AMovedFileTakesThePlaceOfAnother) {
  write_file(folder_ / "old", "old");
  write_file(folder_ / "new", "new");
  move_file(folder_ / "new", folder_ / "old");
  EXPECT_EQ(read_file(folder_ / "old"), (std::vector<uint8_t>{'n', 'e', 'w'}));
  EXPECT_EQ(files(), 1u);
}

TEST_F(Files, WhatCannotBeMovedIsNamedAndStays) {
  write_file(folder_ / "a", "a");
  EXPECT_THAT(message_of([&] { move_file(folder_ / "missing", folder_ / "a"); }), HasSubstr("missing"));
  EXPECT_THAT(message_of([&] { move_file(folder_ / "a", folder_ / "nowhere/b"); }), HasSubstr("nowhere/b"));
  EXPECT_EQ(read_file(folder_ / "a").size(), 1u);
}

TEST_F(Files, APartialFileThatIsNotFinishedIsGone) {
  {
    PartialFile partial(folder_ / "a");
    partial.write(std::vector<uint8_t>{1});
    EXPECT_TRUE(fs::exists(partial.path()));
  }
  EXPECT_EQ(files(), 0u);
}

TEST_F(Files, AFolderIsFlushedAndAMissingOneNamed) {
  flush_folder(folder_);
  EXPECT_THAT(message_of([&] { flush_folder(folder_ / "missing"); }), HasSubstr("missing"));
}

}  // namespace
}  // namespace ldp
