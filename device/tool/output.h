// Where results go and inputs come from: checked before the work begins; results complete or absent afterwards.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>

namespace ldp {

class Temporary;

// In lower case, with its dot: ".mp4" of "Film.MP4"; empty when there is none.
std::string extension_of(const std::filesystem::path& file);

// Throws BadInput when there is no such file, or it cannot be read.
void check_input(const std::filesystem::path& file);

// And when it is a pipe, which would be waited for, or a device.
void check_input_file(const std::filesystem::path& file);

// Throws BadInput when `file` could not be written: its folder is missing or read-only, or it is a folder itself;
// Impossible or MachineFault where the system makes no file there.
void check_output_file(const std::filesystem::path& file);

// And when it is named like a file of another kind than ".ldp", say: it may be a photo that a slip of the hand would
// replace.
void check_output_file(const std::filesystem::path& file, const std::string& extension);

// Whole files, atomic, not cut off by Ctrl-C. Throw Impossible, or MachineFault, when one cannot be written.
void write_output(const std::filesystem::path& file, std::span<const uint8_t> bytes);
void write_text(const std::filesystem::path& file, const std::string& text);

// A folder of results, filled under a temporary name next to its own. `keep` makes it appear: a new folder by one
// rename; into a folder that exists, file by file. Without `keep` nothing is left. A new folder whose name ends like a
// file's, in .webp say, is refused unless a slash follows.
class OutputFolder {
 public:
  enum class Existing { refuse, merge };  // refuse: an existing folder must be empty

  OutputFolder(const std::filesystem::path& folder, Existing existing);  // throws BadInput
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  const std::filesystem::path& path() const { return partial_; }
  // Runs what writes files below `path`. Throws Impossible, or MachineFault, when one cannot be written, by the name it
  // would have had.
  void fill(const std::function<void()>& write) const;
  void keep();  // throws as `fill` does

 private:
  std::filesystem::path shown_, final_, partial_;  // shown_: in the user's words
  std::unique_ptr<Temporary> temporary_;
};

}  // namespace ldp
