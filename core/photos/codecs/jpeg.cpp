#include <algorithm>
#include <csetjmp>
#include <cstddef>
#include <cstdio>  // jpeglib.h needs FILE and size_t
#include <cstdlib>
#include <cstring>
#include <stdexcept>

#include <jpeglib.h>
#include "core/photos/codecs/formats.h"
#include "core/photos/images.h"
// After jpeglib.h:
#include <jerror.h>

namespace ldp {
namespace {

static_assert(sizeof(Rgb) == 3, "rows of Rgb are handed to libjpeg as bytes");

// A progressive file of endless tiny scans would take forever: each goes over all pixels and needs hardly a byte.
constexpr int kMaxScans = 200;
constexpr uint64_t kEasyScannedPixels = uint64_t{1} << 30, kScannedPixelsPerByte = 1024;

// libjpeg reports errors by a call that must not return. It is C, so an exception must not pass through it on every
// architecture: run() catches by longjmp, and what runs below it holds nothing with a destructor.
struct ErrorSink {
  jpeg_error_mgr base;  // first: libjpeg hands back a pointer to it
  jmp_buf escape;
  char message[JMSG_LENGTH_MAX] = {};
};

[[noreturn]] void escape(j_common_ptr info) {
  auto* sink = reinterpret_cast<ErrorSink*>(info->err);
  info->err->format_message(info, sink->message);
  std::longjmp(sink->escape, 1);
}

[[noreturn]] void refuse(j_common_ptr info, const char* why) {
  auto* sink = reinterpret_cast<ErrorSink*>(info->err);
  std::strncpy(sink->message, why, sizeof sink->message - 1);
  std::longjmp(sink->escape, 1);
}

// Damage is only a warning to libjpeg, which fills the rest with grey. Bytes between segments, unknown progressions
// and the like are harmless and common.
void on_warning(j_common_ptr info, int level) {
  if (level >= 0) return;
  switch (info->err->msg_code) {
    case JWRN_JPEG_EOF:
    case JWRN_HIT_MARKER:
    case JWRN_HUFF_BAD_CODE:
    case JWRN_MUST_RESYNC:
    case JWRN_ARITH_BAD_CODE:
      escape(info);
    default:
      return;
  }
}

void install(ErrorSink& sink) {
  jpeg_std_error(&sink.base);
  sink.base.error_exit = escape;
  sink.base.emit_message = on_warning;
}

template <typename State>
bool run(ErrorSink& sink, State& state, void (*step)(State&)) {
  if (setjmp(sink.escape) != 0) return false;
  step(state);
  return true;
}

struct Decoder {
  ErrorSink errors;
  jpeg_decompress_struct info;
  jpeg_progress_mgr progress;
  int most_scans = kMaxScans;
  std::span<const uint8_t> bytes;
  RgbImage image;
  std::vector<uint8_t> cmyk_row;

  explicit Decoder(std::span<const uint8_t> from) : bytes(from) {
    install(errors);
    info.err = &errors.base;
    jpeg_create_decompress(&info);
    progress.progress_monitor = [](j_common_ptr common) {
      auto* decompress = reinterpret_cast<j_decompress_ptr>(common);
      const auto* decoder = static_cast<const Decoder*>(common->client_data);
      if (decompress->input_scan_number > decoder->most_scans) refuse(common, "too many scans");
    };
    info.progress = &progress;
    info.client_data = this;
  }
  ~Decoder() { jpeg_destroy_decompress(&info); }
  Decoder(const Decoder&) = delete;
  Decoder& operator=(const Decoder&) = delete;

  bool cmyk() const { return info.jpeg_color_space == JCS_CMYK || info.jpeg_color_space == JCS_YCCK; }
};

void read_header(Decoder& d) {
  jpeg_mem_src(&d.info, d.bytes.data(), static_cast<unsigned long>(d.bytes.size()));
  jpeg_read_header(&d.info, TRUE);
}

void start(Decoder& d) {
  d.info.dct_method = JDCT_ISLOW;  // the same bytes on every architecture
  d.info.out_color_space = d.cmyk() ? JCS_CMYK : JCS_RGB;
  jpeg_start_decompress(&d.info);
}

void read_rows(Decoder& d) {
  while (d.info.output_scanline < d.info.output_height) {
    auto* row = reinterpret_cast<uint8_t*>(d.image.row(static_cast<int>(d.info.output_scanline)));
    if (!d.cmyk()) {
      jpeg_read_scanlines(&d.info, &row, 1);
      continue;
    }
    uint8_t* cmyk = d.cmyk_row.data();
    jpeg_read_scanlines(&d.info, &cmyk, 1);
    // Adobe stores inks inverted: 255 = no ink.
    for (JDIMENSION i = 0; i < d.info.output_width * 3; ++i) {
      const int ink = cmyk[i / 3 * 4 + i % 3];
      const int black = cmyk[i / 3 * 4 + 3];
      row[i] = static_cast<uint8_t>(ink * black / 255);
    }
  }
  jpeg_finish_decompress(&d.info);
}

[[noreturn]] void fail(const Decoder& d, const std::string& name) { refuse_damaged(name, "JPEG", d.errors.message); }

ImageSize header_size(Decoder& d, const std::string& name) {
  if (!run(d.errors, d, read_header)) fail(d, name);
  check_size(d.info.image_width, d.info.image_height, name);
  const uint64_t pixels = uint64_t{d.info.image_width} * d.info.image_height;
  const uint64_t scanned = kEasyScannedPixels + kScannedPixelsPerByte * d.bytes.size();
  d.most_scans = static_cast<int>(std::min<uint64_t>(kMaxScans, scanned / pixels));
  return {static_cast<int>(d.info.image_width), static_cast<int>(d.info.image_height)};
}

// The largest number of eighths at which the image has at most max_pixels.
int eighths_that_fit(ImageSize size, int64_t max_pixels, const std::string& name) {
  for (int eighths = 8; eighths >= 1; --eighths) {
    const int64_t width = (int64_t{size.width} * eighths + 7) / 8;
    const int64_t height = (int64_t{size.height} * eighths + 7) / 8;
    if (width * height <= max_pixels) return eighths;
  }
  refuse_too_large(size, max_pixels, name);
}

struct Encoder {
  ErrorSink errors;
  jpeg_compress_struct info;
  const RgbImage& image;
  std::span<const JpegSegment> segments;
  int quality;
  bool full_colour;  // 4:4:4
  unsigned char* out = nullptr;
  unsigned long out_size = 0;

  Encoder(const RgbImage& from, std::span<const JpegSegment> with, int at_quality, bool with_full_colour)
      : image(from), segments(with), quality(at_quality), full_colour(with_full_colour) {
    install(errors);
    info.err = &errors.base;
    jpeg_create_compress(&info);
  }
  ~Encoder() {
    jpeg_destroy_compress(&info);
    std::free(out);
  }
  Encoder(const Encoder&) = delete;
  Encoder& operator=(const Encoder&) = delete;
};

void compress(Encoder& e) {
  jpeg_mem_dest(&e.info, &e.out, &e.out_size);
  e.info.image_width = static_cast<JDIMENSION>(e.image.width);
  e.info.image_height = static_cast<JDIMENSION>(e.image.height);
  e.info.input_components = 3;
  e.info.in_color_space = JCS_RGB;
  jpeg_set_defaults(&e.info);
  jpeg_set_quality(&e.info, e.quality, TRUE);
  e.info.dct_method = JDCT_ISLOW;
  e.info.optimize_coding = TRUE;
  if (e.full_colour) e.info.comp_info[0].h_samp_factor = e.info.comp_info[0].v_samp_factor = 1;
  jpeg_start_compress(&e.info, TRUE);
  for (size_t i = 0; i < e.segments.size(); ++i) {
    const JpegSegment& segment = e.segments[i];
    jpeg_write_marker(&e.info, segment.marker, segment.bytes.data(), static_cast<unsigned>(segment.bytes.size()));
  }
  while (e.info.next_scanline < e.info.image_height) {
    const Rgb* row = e.image.row(static_cast<int>(e.info.next_scanline));
    auto* bytes = const_cast<JSAMPROW>(reinterpret_cast<const uint8_t*>(row));
    jpeg_write_scanlines(&e.info, &bytes, 1);
  }
  jpeg_finish_compress(&e.info);
}

}  // namespace

bool is_jpeg(std::span<const uint8_t> bytes) {
  return bytes.size() >= 3 && bytes[0] == 0xFF && bytes[1] == 0xD8 && bytes[2] == 0xFF;
}

ImageSize jpeg_size(std::span<const uint8_t> bytes, const std::string& name) {
  Decoder d(bytes);
  return header_size(d, name);
}

ScaledImage decode_jpeg(std::span<const uint8_t> bytes, const std::string& name, int64_t max_pixels) {
  Decoder d(bytes);
  const ImageSize full_size = header_size(d, name);
  const int eighths = eighths_that_fit(full_size, max_pixels, name);
  d.info.scale_num = static_cast<unsigned>(eighths);
  d.info.scale_denom = 8;
  if (!run(d.errors, d, start)) fail(d, name);
  if (d.cmyk()) d.cmyk_row.resize(size_t{4} * d.info.output_width);
  d.image = RgbImage(static_cast<int>(d.info.output_width), static_cast<int>(d.info.output_height));
  if (!run(d.errors, d, read_rows)) fail(d, name);
  return {std::move(d.image), full_size, eighths / 8.0};
}

namespace {

std::vector<uint8_t> encode(const RgbImage& image, int quality, bool full_colour,
                            std::span<const JpegSegment> segments) {
  if (quality < 1 || quality > 100)
    throw std::logic_error("JPEG quality must be 1 to 100, not " + std::to_string(quality));
  for (const JpegSegment& segment : segments)
    if (segment.bytes.size() > 65533) throw std::logic_error("a JPEG segment holds at most 65533 bytes");
  Encoder e(image, segments, quality, full_colour);
  if (!run(e.errors, e, compress)) throw std::runtime_error(std::string("cannot write JPEG: ") + e.errors.message);
  return {e.out, e.out + e.out_size};
}

}  // namespace

std::vector<uint8_t> encode_jpeg(const RgbImage& image, int quality, std::span<const JpegSegment> segments) {
  constexpr int kFullColourFrom = 90;
  return encode(image, quality, quality >= kFullColourFrom, segments);
}

std::vector<uint8_t> encode_jpeg(const RgbImage& image, int quality) { return encode_jpeg(image, quality, {}); }

std::vector<uint8_t> encode_jpeg_444(const RgbImage& image, int quality) { return encode(image, quality, true, {}); }

}  // namespace ldp
