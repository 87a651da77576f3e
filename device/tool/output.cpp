#include "device/tool/output.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <span>
#include <system_error>

#include "core/base/files.h"
#include "core/base/job.h"
#include "device/tool/process/interrupt.h"
#include "device/tool/session.h"

namespace ldp {
namespace {

namespace fs = std::filesystem;

fs::path without_trailing_slash(const fs::path& path) {
  if (path.empty()) throw BadInput("the name of an output is empty: give the name of a folder");
  const fs::path whole = fs::absolute(path).lexically_normal();
  return whole.has_filename() ? whole : whole.parent_path();
}

// `shown` is the path in the user's words.
void check_folder_takes_files(const fs::path& folder, const fs::path& shown) {
  std::error_code error;
  if (const fs::file_status status = fs::status(folder, error); !fs::status_known(status))
    throw BadInput(shown.string() + ": cannot be written (" + error.message() + "): choose a folder you may write to");
  if (fs::exists(folder, error) && !fs::is_directory(folder, error))
    throw BadInput(shown.string() + ": cannot be written (" + folder.string() +
                   " is a file): choose a name in a folder");
  if (!fs::is_directory(folder, error))
    throw BadInput(shown.string() + ": its folder does not exist: create " + folder.string() + " first");
  if (::access(folder.c_str(), W_OK | X_OK) != 0) {
    throw BadInput(shown.string() + ": cannot be written (" + std::strerror(errno) +
                   "): choose a folder you may write to");
  }
}

// What the system said of an output: whether the machine is at fault, or the place that was named.
[[noreturn]] void refuse_place(const std::error_code& code, const std::string& said) {
  if (is_machine_fault(code)) throw MachineFault(said);
  throw Impossible(said + ": choose another folder to write to");
}

// Root may write everywhere, but in some folders no files can be made (/proc). One without a name is tried first.
void check_file_can_be_made(const fs::path& file) {
  std::error_code unknown;
  const fs::path target = fs::exists(file, unknown) ? fs::canonical(file) : file;  // of a link
  const fs::path folder = without_trailing_slash(target).parent_path(), named = name_beside(target, ".", ".tmp");
  int descriptor = ::open(folder.c_str(), O_WRONLY | O_TMPFILE | O_CLOEXEC, 0600);
  if (descriptor < 0) {
    descriptor = ::open(named.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
    if (descriptor < 0)
      refuse_place({errno, std::generic_category()}, "cannot write " + file.string() + ": " + std::strerror(errno));
    ::unlink(named.c_str());
  }
  ::close(descriptor);
}

// Two to four letters or digits after the dot, a letter among them: .ldp, .gz and .webp are; .5 and .views are not.
bool ends_like_a_file(const fs::path& path) {
  const std::string extension = extension_of(path);
  return extension.size() >= 3 && extension.size() <= 5 &&
         std::all_of(extension.begin() + 1, extension.end(), [](unsigned char c) { return std::isalnum(c) != 0; }) &&
         std::any_of(extension.begin(), extension.end(), [](unsigned char c) { return std::isalpha(c) != 0; });
}

// Of files the names in them, too, outlive a power cut, once they have been flushed.
void flush_tree(const fs::path& folder) {
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.is_directory() && !entry.is_symlink()) flush_tree(entry.path());
  flush_folder(folder);
}

void move_tree(const fs::path& from, const fs::path& to) {
  for (const auto& entry : fs::directory_iterator(from)) {
    const fs::path target = to / entry.path().filename();
    if (entry.is_directory() && fs::is_directory(target))
      move_tree(entry.path(), target);
    else if (entry.is_regular_file())
      move_file(entry.path(), target);
    else
      fs::rename(entry.path(), target);
  }
  flush_folder(to);
}

}  // namespace

std::string extension_of(const fs::path& file) {
  std::string extension = file.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

void check_input(const fs::path& file) {
  if (file.empty()) throw BadInput("the name of a file is empty: give the name of a file");
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (status.type() == fs::file_type::not_found)
    throw BadInput(file.string() + ": there is no such file: check the name");
  if (!fs::status_known(status))
    throw BadInput(file.string() + ": cannot be looked at (" + error.message() + "): check its name and permissions");
  if (fs::is_directory(status)) throw BadInput(file.string() + ": is a folder: give the name of a file");
  if (::access(file.c_str(), R_OK) != 0)
    throw BadInput(file.string() + ": cannot be read (" + std::strerror(errno) + "): check its permissions");
}

void check_input_file(const fs::path& file) {
  check_input(file);
  if (!fs::is_regular_file(file))
    throw BadInput(file.string() + ": is a pipe or a device: give the name of a regular file");
}

void check_output_file(const fs::path& file) {
  std::error_code error;
  if (file.empty()) throw BadInput("the name of an output is empty: give the name of a file");
  if (fs::is_directory(file, error)) throw BadInput(file.string() + ": is a folder: give the name of a file");
  if (!file.has_filename())
    throw BadInput(file.string() + ": is the name of a folder, by the slash at its end: give the name of a file");
  if (fs::exists(file, error) && !fs::is_regular_file(file, error)) return;  // a pipe or device
  check_folder_takes_files(without_trailing_slash(file).parent_path(), file);
  check_file_can_be_made(file);
}

void check_output_file(const fs::path& file, const std::string& extension) {
  check_output_file(file);
  std::error_code error;
  if (!fs::exists(file, error) && ends_like_a_file(file) && extension_of(file) != extension)
    throw BadInput(file.string() + ": is no name of a " + extension + " file, which this writes: end it so");
  if (fs::is_regular_file(file, error) && extension_of(file) != extension)
    throw BadInput(file.string() + ": exists and is no " + extension +
                   " file: choose another name, or remove it first");
}

void write_output(const fs::path& file, std::span<const uint8_t> bytes) {
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (fs::exists(status) && !fs::is_regular_file(status)) {  // a pipe or device
    note_written();
    return write_file(file, bytes);
  }
  try {
    PartialFile partial(file);
    const Temporary temporary(partial.path());
    partial.write(bytes);
    const Finishing finishing;
    partial.finish();
  } catch (const std::system_error& refused) {
    refuse_place(refused.code(), words_of(refused));
  }
}

void write_text(const fs::path& file, const std::string& text) {
  write_output(file, {reinterpret_cast<const uint8_t*>(text.data()), text.size()});
}

OutputFolder::OutputFolder(const fs::path& folder, Existing existing)
    : shown_(folder.has_filename() ? folder : folder.parent_path()), final_(without_trailing_slash(folder)) {
  std::error_code error;
  if (fs::exists(final_, error)) {
    if (!fs::is_directory(final_, error)) throw BadInput(folder.string() + ": is a file: give the name of a folder");
    if (::access(final_.c_str(), W_OK | X_OK) != 0) {
      throw BadInput(folder.string() + ": cannot be written (" + std::strerror(errno) +
                     "): choose a folder you may write to");
    }
    if (existing == Existing::refuse && !fs::is_empty(final_, error)) {
      throw BadInput(folder.string() + ": is there already and not empty: choose another name or remove it");
    }
  }
  if (!fs::exists(final_, error) && ends_like_a_file(folder)) {
    throw BadInput(folder.string() + ": is no kind of file that this can be written to: see --help, or name it " +
                   folder.string() + "/ if a folder is meant");
  }
  check_folder_takes_files(final_.parent_path(), folder);
  partial_ = name_beside(final_, ".partial-");
  temporary_ = std::make_unique<Temporary>(partial_);
  if (!fs::create_directory(partial_, error)) {
    if (!error) error = std::make_error_code(std::errc::file_exists);
    if (is_machine_fault(error)) throw MachineFault(folder.string() + ": cannot be created (" + error.message() + ")");
    throw BadInput(folder.string() + ": cannot be created (" + error.message() + "): choose a folder you may write to");
  }
}

OutputFolder::~OutputFolder() {
  std::error_code ignored;
  fs::remove_all(partial_, ignored);
}

void OutputFolder::fill(const std::function<void()>& write) const {
  try {
    write();
  } catch (const std::system_error& error) {
    std::string text = words_of(error);
    const std::string partial = partial_.string();
    if (text.find(partial) == std::string::npos) throw;
    for (size_t at = 0; (at = text.find(partial, at)) != std::string::npos; at += shown_.string().size())
      text.replace(at, partial.size(), shown_.string());
    refuse_place(error.code(), text);
  }
}

void OutputFolder::keep() {
  const Finishing finishing;
  fill([this] {
    std::error_code error;
    flush_tree(partial_);
    if (!fs::exists(final_, error) || fs::is_empty(final_, error)) {
      fs::rename(partial_, final_);
      flush_folder(final_.parent_path());
    } else {
      move_tree(partial_, final_);
    }
  });
}

}  // namespace ldp
