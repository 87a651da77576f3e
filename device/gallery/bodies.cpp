#include "device/gallery/bodies.h"

#define ZLIB_CONST
#include <zlib.h>

#include <cstdio>
#include <stdexcept>

namespace ldp::gallery {
namespace {

// A number that changes with the bytes (FNV-1a). Nobody gains by making two pages that share one.
std::string checksum_tag(std::span<const uint8_t> bytes, const char* kind) {
  uint64_t hash = 14695981039346656037ULL;
  for (const uint8_t byte : bytes) hash = (hash ^ byte) * 1099511628211ULL;
  char text[40];
  std::snprintf(text, sizeof text, "\"%016llx%s\"", static_cast<unsigned long long>(hash), kind);
  return text;
}

bool names(const std::string& list, const std::string& etag) {
  return list == "*" || list.find(etag) != std::string::npos;
}

// The reply without its body, and which part of the body it is to have.
Reply head_of(const Asked& asked, const std::string& etag, const std::string& type, uint64_t bytes) {
  Reply reply;
  reply.type = type;
  reply.headers = {{"ETag", etag}, {"Cache-Control", "no-cache"}};  // kept, and asked after
  if (names(asked.header("If-None-Match"), etag)) {
    reply.status = 304;
    return reply;
  }
  const std::string only_if = asked.header("If-Range");
  const RangeAnswer part = range_of(only_if.empty() || only_if == etag ? asked.header("Range") : "", bytes);
  reply.status = part.status;
  reply.range = part.range;
  reply.headers.push_back({"Accept-Ranges", "bytes"});
  const std::string all = std::to_string(bytes);
  if (part.status == 416) reply.headers.push_back({"Content-Range", "bytes */" + all});
  if (part.status == 206)
    reply.headers.push_back({"Content-Range", "bytes " + std::to_string(part.range.begin) + "-" +
                                                  std::to_string(part.range.end - 1) + "/" + all});
  return reply;
}

bool has_body(const Reply& reply) { return reply.status == 200 || reply.status == 206; }

bool takes_gzip(const Asked& asked) {
  const std::string codings = asked.header("Accept-Encoding");
  return codings.find("gzip") != std::string::npos && codings.find("gzip;q=0") == std::string::npos;
}

std::string unpacked(std::span<const uint8_t> gzip) {
  z_stream stream{};
  if (::inflateInit2(&stream, 16 + MAX_WBITS) != Z_OK) throw std::runtime_error("zlib cannot begin");
  std::string text;
  char part[16384];
  stream.next_in = gzip.data();
  stream.avail_in = static_cast<uInt>(gzip.size());
  int result = Z_OK;
  while (result == Z_OK) {
    stream.next_out = reinterpret_cast<Bytef*>(part);
    stream.avail_out = sizeof part;
    result = ::inflate(&stream, Z_NO_FLUSH);
    text.append(part, sizeof part - stream.avail_out);
  }
  ::inflateEnd(&stream);
  return text;
}

}  // namespace

Reply refuse(int status, const std::string& words) {
  Reply reply;
  reply.status = status;
  reply.text = words + "\n";
  return reply;
}

Reply send_file(const Asked& asked, OpenFile file, const std::string& type) {
  Reply reply = head_of(asked, etag_of(file.version), type, file.version.bytes);
  if (has_body(reply)) reply.file = std::make_shared<UniqueFd>(std::move(file.fd));
  return reply;
}

Reply send_bytes(const Asked& asked, SharedBytes bytes, const std::string& etag, const std::string& type) {
  Reply reply = head_of(asked, etag, type, bytes->size());
  if (has_body(reply)) reply.bytes = std::move(bytes);
  return reply;
}

Reply send_text(const Asked& asked, std::string text, const std::string& type) {
  const std::string etag = checksum_tag({reinterpret_cast<const uint8_t*>(text.data()), text.size()}, "");
  Reply reply;
  reply.type = type;
  reply.headers = {{"ETag", etag}, {"Cache-Control", "no-cache"}, {"Vary", "Accept-Encoding"}};
  reply.status = names(asked.header("If-None-Match"), etag) ? 304 : 200;
  if (reply.status == 200) reply.text = std::move(text);
  return reply;
}

Reply send_packed(const Asked& asked, std::span<const uint8_t> gzip, const std::string& type) {
  if (!takes_gzip(asked)) return send_text(asked, unpacked(gzip), type);
  const std::string etag = checksum_tag(gzip, "-gzip");
  Reply reply;
  reply.type = type;
  reply.headers = {{"ETag", etag}, {"Cache-Control", "no-cache"}, {"Vary", "Accept-Encoding"}};
  if (names(asked.header("If-None-Match"), etag)) {
    reply.status = 304;
    return reply;
  }
  reply.headers.push_back({"Content-Encoding", "gzip"});
  reply.bytes = std::make_shared<const std::vector<uint8_t>>(gzip.begin(), gzip.end());
  reply.range = {0, gzip.size()};
  return reply;
}

}  // namespace ldp::gallery
