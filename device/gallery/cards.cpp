#include "device/gallery/cards.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <system_error>

#include "core/base/files.h"
#include "core/panorama/file/ldp_file.h"
#include "core/verdict/words.h"

namespace ldp::gallery {
namespace {

// The file behind a descriptor: its pages are read where they are needed alone.
std::filesystem::path path_of(int fd) { return "/proc/self/fd/" + std::to_string(fd); }

std::string value_of(const std::map<std::string, std::string>& metadata, const char* key) {
  const auto found = metadata.find(key);
  return found == metadata.end() ? std::string() : found->second;
}

void describe(std::span<const uint8_t> bytes, Card& card) {
  LdpDescription description = describe_ldp(bytes);
  const LayeredPanorama& panorama = description.panorama;
  card.width = panorama.grid.width;
  card.height = panorama.grid.height;
  card.layers = static_cast<int>(description.layers.size());
  const double degrees = panorama.grid.width * panorama.grid.theta_pitch * 180 / std::numbers::pi;
  card.degrees = static_cast<int>(std::lround(degrees));
  card.captured_utc = value_of(panorama.metadata, "captured_utc");
  card.device = value_of(panorama.metadata, "device");
  if (const std::optional<SweepQuality> quality = quality_from(panorama.quality)) {
    card.verdict = name_of(quality->grade);
    card.verdict_text = text_of(*quality);
  }
  card.thumbnail_jpeg = std::move(description.thumbnail);
}

SharedCard unreadable(const std::string& name, const std::system_error& error) {
  auto card = std::make_shared<Card>();
  card->name = name, card->trouble = error.what();
  return card;
}

SharedCard card_of(const std::string& name, const OpenFile& file) {
  auto card = std::make_shared<Card>();
  card->name = name;
  card->version = file.version;
  try {
    describe(MappedFile(path_of(file.fd.get())).bytes(), *card);
  } catch (const std::system_error& error) {  // no fault of the file's: another time may go better
    return unreadable(name, error);
  } catch (const std::runtime_error& error) {  // damaged
    card->trouble = error.what();
  }
  return card;
}

}  // namespace

// One that cannot be opened keeps no others from being shown; it is tried again next time, for it has no version.
SharedCard Cards::read(const std::string& name) {
  std::optional<OpenFile> file;
  try {
    file = folder_.open_panorama(name);
  } catch (const std::system_error& error) {
    return unreadable(name, error);
  }
  if (!file) return nullptr;
  const auto found = known_.find(name);
  if (found != known_.end() && found->second->version == file->version) return found->second;
  return card_of(name, *file);
}

SharedCard Cards::of(const std::string& name) {
  const std::lock_guard lock(mutex_);
  SharedCard card = read(name);
  if (card) known_[name] = card;
  return card;
}

std::vector<SharedCard> Cards::newest_first() {
  const std::lock_guard lock(mutex_);
  std::map<std::string, SharedCard> present;
  for (const std::string& name : folder_.panoramas())
    if (const SharedCard card = read(name)) present[name] = card;
  known_ = std::move(present);  // what is gone is forgotten
  std::vector<SharedCard> cards;
  for (const auto& [name, card] : known_) cards.push_back(card);
  std::stable_sort(cards.begin(), cards.end(), [](const SharedCard& a, const SharedCard& b) {
    return a->version.changed_ns > b->version.changed_ns;
  });
  return cards;
}

}  // namespace ldp::gallery
