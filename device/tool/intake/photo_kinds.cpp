#include "device/tool/intake/photo_kinds.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <string>
#include <string_view>

#include "device/tool/output.h"

namespace ldp {
namespace {

using namespace std::string_view_literals;

template <size_t kCount>
bool one_of(std::string_view word, const std::array<std::string_view, kCount>& words) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

template <size_t kCount>
bool starts_with_one_of(std::string_view bytes, const std::array<std::string_view, kCount>& words) {
  return std::any_of(words.begin(), words.end(), [&](std::string_view word) { return bytes.starts_with(word); });
}

// Of a file of ISO's base media format; empty for any other.
std::string_view brand_of(std::string_view head) {
  return head.size() >= 12 && head.substr(4, 4) == "ftyp" ? head.substr(8, 4) : std::string_view();
}

}  // namespace

FileKind kind_of_content(const std::filesystem::path& file) {
  check_input_file(file);
  std::string bytes(16, '\0');
  std::ifstream in(file, std::ios::binary);
  in.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  bytes.resize(static_cast<size_t>(in.gcount()));
  const std::string_view head = bytes;
  constexpr std::array kPhoto = {"\xff\xd8\xff"sv, "\x89PNG"sv};
  constexpr std::array kZip = {"PK\x03\x04"sv, "PK\x05\x06"sv};
  constexpr std::array kHeif = {"heic"sv, "heix"sv, "heim"sv, "heis"sv, "hevc"sv, "mif1"sv, "msf1"sv, "avif"sv};
  constexpr std::array kRaw = {"II*\0"sv, "MM\0*"sv, "IIRO"sv, "IIRS"sv, "IIU\0"sv, "FUJIFILMCCD-RAW"sv};
  if (starts_with_one_of(head, kPhoto)) return FileKind::photo;
  if (starts_with_one_of(head, kZip)) return FileKind::zip;
  if (head.starts_with("\xABLDP"sv)) return FileKind::panorama;
  if (one_of(brand_of(head), kHeif)) return FileKind::heif;
  if (brand_of(head) == "crx " || starts_with_one_of(head, kRaw)) return FileKind::raw;
  return FileKind::other;
}

FileKind kind_of_name(const std::filesystem::path& file) {
  constexpr std::array kPhoto = {".jpg"sv, ".jpeg"sv, ".png"sv};
  constexpr std::array kHeif = {".heic"sv, ".heif"sv, ".avif"sv};
  constexpr std::array kRaw = {".dng"sv, ".cr2"sv, ".cr3"sv, ".nef"sv, ".arw"sv, ".orf"sv,
                               ".rw2"sv, ".raf"sv, ".pef"sv, ".srw"sv, ".nrw"sv, ".raw"sv};
  const std::string ending = extension_of(file);
  if (one_of(ending, kPhoto)) return FileKind::photo;
  if (one_of(ending, kHeif)) return FileKind::heif;
  return one_of(ending, kRaw) ? FileKind::raw : FileKind::other;
}

}  // namespace ldp
