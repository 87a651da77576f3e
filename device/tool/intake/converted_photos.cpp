#include "device/tool/intake/converted_photos.h"

#include <array>
#include <string>
#include <system_error>

#include "device/tool/intake/intake_tuning.h"
#include "device/tool/intake/photo_kinds.h"
#include "device/tool/process/child_process.h"
#include "device/tool/session.h"

namespace ldp {
namespace {

namespace fs = std::filesystem;

// What runs, and where the first photo that it makes may be.
struct Converter {
  std::string kind, remedy;
  std::vector<std::string> words;
  std::array<fs::path, 2> made;
};

// A file of several pictures becomes as many, numbered.
Converter heif_converter(const fs::path& photo, const fs::path& wanted) {
  const fs::path first = wanted.parent_path() / (wanted.stem().string() + "-1.jpg");
  return {"HEIC photos need heif-convert",
          "install it (libheif-examples)",
          {"heif-convert", "-q", "95", fs::absolute(photo).string(), wanted.string()},
          {wanted, first}};
}

// It writes beside what it reads: beside a link, then.
Converter raw_converter(const fs::path& photo, const fs::path& wanted) {
  const fs::path link = wanted.parent_path() / (wanted.stem().string() + ".link");
  fs::create_symlink(fs::absolute(photo), link);
  return {"raw photos need simple_dcraw",
          "install it (libraw-bin)",
          {"simple_dcraw", "-e", link.string()},
          {link.string() + ".thumb.jpg", fs::path()}};
}

void run(const Converter& converter, const PhotoFile& photo, const Job& job) {
  try {
    ChildProcess program(converter.words, ChildProcess::Pipe::from_child, kDecoderMemory_bytes);
    uint8_t unread[4096];
    while (program.read(unread, job) > 0) {
    }
    if (program.wait() == 0) return;
    const std::string complaint = program.first_line_said();
    throw BadInput(photo.called + ": cannot be read by " + converter.words[0] +
                   (complaint.empty() ? "" : " (" + complaint + ")") + ": copy it again, or leave it out");
  } catch (const std::system_error& error) {
    if (is_machine_fault(error.code())) throw;
    throw BadInput(photo.called + ": " + converter.kind + ", which could not be started: " + converter.remedy +
                   ", or give .jpg photos");
  }
}

fs::path converted(const PhotoFile& photo, FileKind kind, const UnpackedFolder& to, const Job& job) {
  fs::path wanted = to.path() / (photo.path.stem().string() + ".jpg");
  if (fs::exists(wanted))
    throw BadInput(photo.called + ": two photos are named " + photo.path.stem().string() + ": rename one");
  const Converter converter =
      kind == FileKind::heif ? heif_converter(photo.path, wanted) : raw_converter(photo.path, wanted);
  run(converter, photo, job);
  for (const fs::path& made : converter.made) {
    if (!fs::exists(made)) continue;
    fs::rename(made, wanted);
    return wanted;
  }
  throw BadInput(photo.called + ": no JPEG picture in it: develop it, and give that as .jpg");
}

}  // namespace

std::vector<PhotoFile> converted_photos(const std::vector<PhotoFile>& photos, const UnpackedFolder& to,
                                        const Job& job) {
  std::vector<PhotoFile> all = photos;
  size_t done = 0;
  for (PhotoFile& photo : all) {
    job.report("unpacking", static_cast<double>(done++) / static_cast<double>(all.size()));
    const FileKind kind = kind_of_name(photo.path);
    if (kind == FileKind::heif || kind == FileKind::raw) photo.path = converted(photo, kind, to, job);
  }
  return all;
}

}  // namespace ldp
