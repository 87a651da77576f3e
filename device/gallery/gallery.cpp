#include "device/gallery/gallery.h"

#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>

#include "core/captures/json_text.h"
#include "device/gallery/bodies.h"
#include "device/gallery/gallery_pages.h"

namespace ldp::gallery {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kHtml = "text/html; charset=utf-8";
constexpr const char* kScript = "text/javascript; charset=utf-8";
constexpr const char* kLdp = "application/octet-stream";

// What stands behind a prefix; none: the text begins otherwise, or ends there.
std::optional<std::string> behind(const std::string& text, std::string_view prefix) {
  if (!text.starts_with(prefix) || text.size() == prefix.size()) return std::nullopt;
  return text.substr(prefix.size());
}

Json json_of(const Card& card) {
  Json json{{"name", card.name}, {"bytes", card.version.bytes}, {"changed_ms", card.version.changed_ns / 1'000'000}};
  if (!card.trouble.empty()) {
    json["trouble"] = card.trouble;
    return json;
  }
  for (const auto& [key, text] : {std::pair{"captured_utc", &card.captured_utc},
                                  {"device", &card.device},
                                  {"verdict", &card.verdict},
                                  {"verdict_text", &card.verdict_text}})
    if (!text->empty()) json[key] = *text;
  json["width"] = card.width;
  json["height"] = card.height;
  json["degrees"] = card.degrees;
  json["layers"] = card.layers;
  json["thumbnail"] = !card.thumbnail_jpeg.empty();
  return json;
}

// In a time that tells nothing of where they differ.
bool same_secret(const std::string& a, const std::string& b) {
  unsigned differences = a.size() == b.size() ? 0 : 1;
  for (size_t i = 0; i < a.size(); ++i) differences |= static_cast<unsigned>(a[i] ^ b[b.empty() ? 0 : i % b.size()]);
  return differences == 0;
}

std::optional<Command> command_named(const std::string& word) {
  for (const Command command : kCommands)
    if (word == name_of(command)) return command;
  return std::nullopt;
}

Reply not_found() { return refuse(404, "there is nothing of that name here"); }

}  // namespace

Gallery::Gallery(const Folder& folder, LiveFeed& feed, const GalleryOptions& options, const Job& job)
    : folder_(folder), feed_(feed), options_(options), cards_(folder), conversions_(options.conversions, job) {
  if (!options.token.empty() && options.token.size() < kShortestToken)
    throw std::invalid_argument("the token has " + std::to_string(options.token.size()) +
                                " characters: at least 16 keep strangers from guessing it");
}

Reply Gallery::answer(const Asked& asked) {
  try {
    if (asked.method == "GET" || asked.method == "HEAD") return look_at(asked);
    if (asked.method == "POST" || asked.method == "DELETE") return change(asked);
    Reply reply = refuse(405, "only GET, HEAD, POST and DELETE are answered here");
    reply.headers = {{"Allow", "GET, HEAD, POST, DELETE"}};
    return reply;
  } catch (const Impossible& error) {
    return refuse(422, error.what());
  } catch (const std::exception& error) {
    return refuse(500, error.what());
  }
}

Reply Gallery::look_at(const Asked& asked) {
  const std::string& path = asked.path;
  if (path == "/") return send_packed(asked, kGalleryPage, kHtml);
  if (path == "/gallery.js") return send_packed(asked, kGalleryScript, kScript);
  if (path == "/viewer.js") return send_packed(asked, kViewerScript, kScript);
  if (path == "/worker.js") return send_packed(asked, kWorkerScript, kScript);
  if (path == "/panoramas.json") return list(asked);
  if (path == "/events") {
    Reply reply;
    reply.type = "text/event-stream";
    reply.headers = {{"Cache-Control", "no-store"}};
    reply.follows = true;
    return reply;
  }
  if (const auto name = behind(path, "/view/")) return show(asked, *name);
  if (const auto name = behind(path, "/panoramas/")) return panorama(asked, *name);
  if (const auto name = behind(path, "/thumbnails/")) return thumbnail(asked, *name);
  if (const auto name = behind(path, "/sweeps/")) return frame(asked, *name);
  return not_found();
}

Reply Gallery::list(const Asked& asked) {
  Json json{{"live", feed_.has_device()}, {"changes", !options_.token.empty()}, {"panoramas", Json::array()}};
  for (const SharedCard& card : cards_.newest_first()) json["panoramas"].push_back(json_of(*card));
  return send_text(asked, json_text(json), "application/json");
}

Reply Gallery::show(const Asked& asked, const std::string& name) {
  return folder_.open_panorama(name) ? send_packed(asked, kViewPage, kHtml) : not_found();
}

Reply Gallery::panorama(const Asked& asked, const std::string& name) {
  if (std::optional<OpenFile> file = folder_.open_panorama(name)) return send_file(asked, std::move(*file), kLdp);
  for (const std::string ending : {".jpg", ".glb"})
    if (name.ends_with(ending)) return converted(asked, name.substr(0, name.size() - ending.size()), ending);
  return not_found();
}

Reply Gallery::converted(const Asked& asked, const std::string& stem, const std::string& ending) {
  const std::optional<OpenFile> file = folder_.open_panorama(stem + ".ldp");
  if (!file) return not_found();
  std::string etag = etag_of(file->version);
  etag.insert(etag.size() - 1, ending);
  const char* const type = ending == ".jpg" ? "image/jpeg" : "model/gltf-binary";
  const bool is_known = asked.header("If-None-Match") == etag;  // then it is not made only to be thrown away
  const SharedBytes bytes =
      is_known ? std::make_shared<const std::vector<uint8_t>>() : conversions_.convert(*file, ending);
  if (bytes) return send_bytes(asked, bytes, etag, type);
  Reply reply = refuse(503, "others wait for a conversion already: ask again in a minute");
  reply.headers = {{"Retry-After", "60"}};
  return reply;
}

Reply Gallery::thumbnail(const Asked& asked, const std::string& name) {
  const SharedCard card = cards_.of(name);
  if (card && card->version == FileVersion{}) return refuse(500, card->trouble);
  if (!card || card->thumbnail_jpeg.empty()) return not_found();
  return send_bytes(asked, {card, &card->thumbnail_jpeg}, etag_of(card->version), "image/jpeg");
}

Reply Gallery::frame(const Asked& asked, const std::string& sweep_and_name) {
  const size_t slash = sweep_and_name.find('/');
  if (slash == std::string::npos) return not_found();
  std::optional<OpenFile> file = folder_.open_frame(sweep_and_name.substr(0, slash), sweep_and_name.substr(slash + 1));
  return file ? send_file(asked, std::move(*file), "image/jpeg") : not_found();
}

bool Gallery::may_change(const Asked& asked) const {
  constexpr std::string_view kBearer = "Bearer ";
  const std::string header = asked.header("Authorization");
  return !options_.token.empty() && header.starts_with(kBearer) &&
         same_secret(header.substr(kBearer.size()), options_.token);
}

Reply Gallery::change(const Asked& asked) {
  if (options_.token.empty()) return refuse(403, "nothing can be changed here: no token is configured");
  if (!may_change(asked)) {
    Reply reply = refuse(401, "the token is missing or wrong");
    reply.headers = {{"WWW-Authenticate", "Bearer"}};
    return reply;
  }
  Reply done;
  done.status = 204;
  if (const auto name = behind(asked.path, "/panoramas/"); name && asked.method == "DELETE")
    return folder_.remove_panorama(*name) ? done : not_found();
  const auto word = behind(asked.path, "/device/");
  const std::optional<Command> command = word && asked.method == "POST" ? command_named(*word) : std::nullopt;
  if (!command) return not_found();
  if (!feed_.has_device()) return refuse(503, "no device is connected to this gallery");
  feed_.send(*command);
  return done;
}

}  // namespace ldp::gallery
