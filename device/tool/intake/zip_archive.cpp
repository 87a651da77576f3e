#include "device/tool/intake/zip_archive.h"

#include <archive.h>
#include <archive_entry.h>
#include <locale.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "device/tool/intake/intake_tuning.h"
#include "device/tool/intake/photo_kinds.h"
#include "device/tool/session.h"

namespace ldp {
namespace {

namespace fs = std::filesystem;

// libarchive gives up names that the locale cannot write; here they are UTF-8 on this thread while one is alive.
class Utf8Names {
 public:
  Utf8Names() : utf8_(::newlocale(LC_CTYPE_MASK, "C.UTF-8", nullptr)), before_(::uselocale(utf8_)) {}
  ~Utf8Names() {
    ::uselocale(before_);
    if (utf8_ != nullptr) ::freelocale(utf8_);
  }
  Utf8Names(const Utf8Names&) = delete;
  Utf8Names& operator=(const Utf8Names&) = delete;

 private:
  locale_t utf8_, before_;
};

struct Free {
  void operator()(archive* reader) const { archive_read_free(reader); }
};

class Unpacking {
 public:
  Unpacking(const fs::path& file, const UnpackedFolder& to)
      : file_(file), to_(to), packed_bytes_(static_cast<int64_t>(fs::file_size(file))), reader_(archive_read_new()) {
    archive_read_support_format_zip(reader_.get());
    constexpr size_t kBlock_bytes = 1 << 16;
    if (archive_read_open_filename(reader_.get(), file.c_str(), kBlock_bytes) != ARCHIVE_OK) refuse_damaged();
  }

  void run(const Job& job) {
    archive_entry* entry = nullptr;
    int entries = 0;
    for (;;) {
      const int result = archive_read_next_header(reader_.get(), &entry);
      if (result == ARCHIVE_EOF) break;
      if (result != ARCHIVE_OK && result != ARCHIVE_WARN) refuse_damaged();
      if (++entries > kMaxEntries) refuse_too_much("more than " + std::to_string(kMaxEntries) + " files");
      take(*entry, job);
    }
    if (photos_ == 0) refuse("no photos in it", "give an archive of the .jpg or .png photos of one sweep");
    put_notes();
  }

 private:
  [[noreturn]] void refuse(const std::string& what, const std::string& remedy) const {
    throw BadInput(file_.string() + ": " + what + ": " + remedy);
  }
  [[noreturn]] void refuse_damaged() const {
    const char* const said = archive_error_string(reader_.get());
    refuse(std::string("cannot be unpacked (") + (said != nullptr ? said : "damaged") + ")",
           "copy it again, or unpack it, and give the folder of its photos");
  }
  [[noreturn]] void refuse_too_much(const std::string& what) const {
    refuse("holds " + what, "give an archive of the photos of one sweep");
  }

  void take(archive_entry& entry, const Job& job) {
    const char* const named = archive_entry_pathname(&entry);
    if (named == nullptr || archive_entry_filetype(&entry) != AE_IFREG) return;
    const fs::path name(named);
    if (name.is_absolute() || std::find(name.begin(), name.end(), "..") != name.end())
      refuse("names a file outside of itself, " + name.string(), "it is not to be trusted");
    const std::string last = name.filename().string();
    const bool is_notes = last == "capture.json";
    if (last.starts_with('.') || last.empty() || (!is_notes && kind_of_name(last) == FileKind::other)) return;
    if (archive_entry_is_encrypted(&entry) != 0) refuse("is encrypted", "unpack it, and give the folder of its photos");
    if (is_notes)
      take_notes(name, job);
    else
      take_photo(name, job);
  }

  void take_notes(const fs::path& name, const Job& job) {
    if (notes_.size() >= kMaxNotes) refuse_too_much("more than " + std::to_string(kMaxNotes) + " files capture.json");
    notes_.push_back({name.parent_path(), unpacked(name.string(), kMaxNotes_bytes, job)});
  }

  void take_photo(const fs::path& name, const Job& job) {
    if (photos_ > 0 && name.parent_path() != folder_)
      refuse("photos in two folders of it, " + shown(folder_) + " and " + shown(name.parent_path()),
             "give an archive of one sweep");
    folder_ = name.parent_path();
    if (++photos_ > kMaxUnpackedPhotos) refuse_too_much("more than " + std::to_string(kMaxUnpackedPhotos) + " photos");
    const std::string last = name.filename().string();
    if (fs::exists(to_.path() / last)) refuse("two photos named " + name.string(), "make it again");
    to_.put(last, unpacked(name.string(), kMaxPhoto_bytes, job));
  }

  static std::string shown(const fs::path& folder) { return folder.empty() ? "its top" : folder.string(); }

  // Of the entry at hand.
  std::vector<uint8_t> unpacked(const std::string& name, int64_t most, const Job& job) {
    std::vector<uint8_t> bytes;
    uint8_t block[1 << 16];
    for (;;) {
      job.check();
      const la_ssize_t got = archive_read_data(reader_.get(), block, sizeof block);
      if (got < 0) refuse_damaged();
      if (got == 0) return bytes;
      unpacked_bytes_ += got;
      bytes.insert(bytes.end(), block, block + got);
      if (static_cast<int64_t>(bytes.size()) > most)
        refuse_too_much("a file of more than " + std::to_string(most >> 20) + " MiB, " + name);
      if (unpacked_bytes_ > kMaxUnpacked_bytes)
        refuse_too_much("more than " + std::to_string(kMaxUnpacked_bytes >> 30) + " GiB");
      if (unpacked_bytes_ > kSmallUnpacked_bytes + kMaxUnpackedRatio * packed_bytes_)
        refuse_too_much("more than " + std::to_string(kMaxUnpackedRatio) + " times its size, which no photos do");
    }
  }

  // Those beside the photos before those of the folder above.
  void put_notes() const {
    for (const fs::path& folder : {folder_.parent_path(), folder_})
      for (const Notes& notes : notes_)
        if (notes.folder == folder) to_.put("capture.json", notes.bytes);
  }

  struct Notes {
    fs::path folder;
    std::vector<uint8_t> bytes;
  };

  const fs::path& file_;
  const UnpackedFolder& to_;
  int64_t packed_bytes_, unpacked_bytes_ = 0;
  std::unique_ptr<archive, Free> reader_;
  fs::path folder_;  // of the photos, in the archive
  std::vector<Notes> notes_;
  int photos_ = 0;
};

}  // namespace

void unpack_photos(const fs::path& archive, const UnpackedFolder& to, const Job& job) {
  job.report("unpacking", 0);
  const Utf8Names names;
  Unpacking(archive, to).run(job);
}

}  // namespace ldp
