// Files, and the one way in which they are replaced: a reader, or a power cut, finds the old one or the new one, whole.
//
// A file is written under a temporary name beside its own, flushed, renamed, and its folder flushed. Where a file
// system cannot flush folders (some of FUSE, some network shares) a rename is as safe as it can be there, and nothing
// is refused. Interrupted system calls are begun again. Everything throws std::system_error naming the path.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

namespace ldp {

std::vector<uint8_t> read_file(const std::filesystem::path& file);  // pipes and files of /proc too, to their end

// Replaces the file, which keeps who may do what with it, or makes it; leaves nothing behind when it throws. Devices
// and pipes are written to directly.
void write_file(const std::filesystem::path& file, std::span<const uint8_t> bytes);
void write_file(const std::filesystem::path& file, std::string_view text);

// The same of a file that only its owner may read, nor anybody else at any moment before.
void write_secret_file(const std::filesystem::path& file, std::string_view text);

// A file that another program has written takes its final name for good; both in one file system. What is at `to` is
// replaced, and keeps who may do what with it.
void move_file(const std::filesystem::path& from, const std::filesystem::path& to);

// Makes names in a folder last through a power cut. False where the file system knows no such thing.
bool flush_folder(const std::filesystem::path& folder);

// Where a result takes shape: a hidden name beside its own, that no other program has, nor one that was killed (in
// containers all have the same process number): ".NAME" + mark + a number + `ending`.
std::filesystem::path name_beside(const std::filesystem::path& target, std::string_view mark,
                                  std::string_view ending = {});

// What write_file does, step by step: a file under a temporary name beside its own, gone again unless it is finished.
class PartialFile {
 public:
  explicit PartialFile(const std::filesystem::path& target);  // makes nothing yet; a link stays a link
  ~PartialFile();
  PartialFile(const PartialFile&) = delete;
  PartialFile& operator=(const PartialFile&) = delete;
  const std::filesystem::path& path() const { return path_; }  // the temporary one
  // All of it, once, and flushes it. `secret`: for its owner alone.
  void write(std::span<const uint8_t> bytes, bool secret = false);
  void finish();  // gives it its name for good

 private:
  std::filesystem::path target_, path_;
  bool begun_ = false;
};

// A file's bytes without reading it as a whole. The file must not be cut short while it is mapped.
class MappedFile {
 public:
  explicit MappedFile(const std::filesystem::path& file);
  ~MappedFile();
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;
  std::span<const uint8_t> bytes() const { return {data_, size_}; }

 private:
  const uint8_t* data_ = nullptr;
  size_t size_ = 0;
};

}  // namespace ldp
