// Replies whose body may be known already: ETag, If-None-Match, Range and If-Range (RFC 9110, sections 13 and 14).
#pragma once

#include <span>
#include <string>

#include "device/gallery/folder.h"
#include "device/gallery/reply.h"

namespace ldp::gallery {

Reply refuse(int status, const std::string& words);

// Of a file; of bytes; of a text made for the occasion, whose ETag is a checksum.
Reply send_file(const Asked& asked, OpenFile file, const std::string& type);
Reply send_bytes(const Asked& asked, SharedBytes bytes, const std::string& etag, const std::string& type);
Reply send_text(const Asked& asked, std::string text, const std::string& type);

// A text that is compressed (gzip) already; unpacked for who cannot.
Reply send_packed(const Asked& asked, std::span<const uint8_t> gzip, const std::string& type);

}  // namespace ldp::gallery
