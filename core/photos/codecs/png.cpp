#include <csetjmp>
#include <cstring>
#include <stdexcept>
#include <string>

#include <png.h>
#include "core/photos/codecs/formats.h"
#include "core/photos/images.h"

namespace ldp {
namespace {

constexpr char kSoftware[] = "Software";  // a keyword of the PNG standard
constexpr int kCompressionLevel = 4;      // zlib's; photos take a third of the time of 6, for 1 to 3 % more bytes
constexpr uint8_t kSignature[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};

// As with libjpeg, errors come by a call that must not return: run() catches by longjmp, and what runs below it holds
// nothing with a destructor.
struct Session {
  jmp_buf escape;
  char message[256] = {};
};

[[noreturn]] void on_error(png_structp png, png_const_charp text) {
  auto* session = static_cast<Session*>(png_get_error_ptr(png));
  std::strncpy(session->message, text, sizeof session->message - 1);
  std::longjmp(session->escape, 1);
}

void on_warning(png_structp, png_const_charp) {}

template <typename State>
bool run(State& state, void (*step)(State&)) {
  if (setjmp(state.session.escape) != 0) return false;
  step(state);
  return true;
}

struct Decoder {
  Session session;
  std::span<const uint8_t> bytes;
  size_t position = 0;
  png_structp png = nullptr;
  png_infop info = nullptr;
  int shrink = 1;  // rows and columns averaged into one
  RgbImage image;
  std::vector<png_bytep> rows;  // interlaced files only
  RgbImage row;                 // one row of the file
  std::vector<uint32_t> sums;   // running sums of the rows averaged into one

  explicit Decoder(std::span<const uint8_t> from) : bytes(from) {
    png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &session, on_error, on_warning);
    if (png) info = png_create_info_struct(png);
    if (!info) throw std::bad_alloc();
  }
  ~Decoder() { png_destroy_read_struct(&png, &info, nullptr); }
  Decoder(const Decoder&) = delete;
  Decoder& operator=(const Decoder&) = delete;
  int width() const { return static_cast<int>(png_get_image_width(png, info)); }
  int height() const { return static_cast<int>(png_get_image_height(png, info)); }
};

void take(png_structp png, png_bytep to, size_t count) {
  auto* d = static_cast<Decoder*>(png_get_io_ptr(png));
  if (count > d->bytes.size() - d->position) png_error(png, "the file ends too early");
  std::memcpy(to, d->bytes.data() + d->position, count);
  d->position += count;
}

void read_header(Decoder& d) {
  png_set_read_fn(d.png, &d, take);
  png_set_user_limits(d.png, 0x7FFFFFFF, 0x7FFFFFFF);  // ours are checked next, with words of our own
  png_set_chunk_malloc_max(d.png, 1 << 24);
  png_read_info(d.png, d.info);
}

void ask_for_rgb(Decoder& d) {
  png_set_expand(d.png);
  png_set_scale_16(d.png);
  png_set_strip_alpha(d.png);
  png_set_gray_to_rgb(d.png);
  png_set_interlace_handling(d.png);
  png_read_update_info(d.png, d.info);
}

void read_interlaced(Decoder& d) {
  ask_for_rgb(d);
  png_read_image(d.png, d.rows.data());
  png_read_end(d.png, nullptr);
}

// Adds a row of the file to the sums and, with the last row of a square, writes the means.
void average_row(Decoder& d, int y) {
  const int k = d.shrink;
  const auto area = static_cast<uint32_t>(k) * static_cast<uint32_t>(k);
  for (int x = 0; x < d.image.width * k; ++x) {
    const Rgb from = d.row.at(x, 0);
    uint32_t* sum = &d.sums[static_cast<size_t>(x / k) * 3];
    sum[0] += from.r, sum[1] += from.g, sum[2] += from.b;
  }
  if (y % k != k - 1) return;
  for (int x = 0; x < d.image.width; ++x) {
    uint32_t* sum = &d.sums[static_cast<size_t>(x) * 3];
    const auto mean = [area](uint32_t s) { return static_cast<uint8_t>((s + area / 2) / area); };
    d.image.at(x, y / k) = {mean(sum[0]), mean(sum[1]), mean(sum[2])};
    sum[0] = sum[1] = sum[2] = 0;
  }
}

void read_rows(Decoder& d) {
  ask_for_rgb(d);
  const int height = d.height();
  for (int y = 0; y < height; ++y) {
    if (d.shrink == 1) {
      png_read_row(d.png, reinterpret_cast<png_bytep>(d.image.row(y)), nullptr);
      continue;
    }
    png_read_row(d.png, reinterpret_cast<png_bytep>(d.row.row(0)), nullptr);
    if (y / d.shrink < d.image.height) average_row(d, y);
  }
  png_read_end(d.png, nullptr);
}

[[noreturn]] void fail(const Decoder& d, const std::string& name) { refuse_damaged(name, "PNG", d.session.message); }

ImageSize header_size(Decoder& d, const std::string& name) {
  if (!run(d, read_header)) fail(d, name);
  check_size(png_get_image_width(d.png, d.info), png_get_image_height(d.png, d.info), name);
  return {d.width(), d.height()};
}

int shrink_that_fits(ImageSize size, int64_t max_pixels, const std::string& name) {
  for (int k = 1; k <= 64; ++k) {
    const int64_t width = size.width / k;
    const int64_t height = size.height / k;
    if (width == 0 || height == 0) break;
    if (width * height <= max_pixels) return k;
  }
  refuse_too_large(size, max_pixels, name);
}

struct Encoder {
  Session session;
  png_structp png = nullptr;
  png_infop info = nullptr;
  int width, height, bits, colour_type;
  std::vector<png_bytep> rows;
  std::vector<uint8_t> out;
  bool out_of_memory = false;
  std::string xmp, software;  // empty = none

  Encoder(int w, int h, int b, int type) : width(w), height(h), bits(b), colour_type(type) {
    png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &session, on_error, on_warning);
    if (png) info = png_create_info_struct(png);
    if (!info) throw std::bad_alloc();
  }
  ~Encoder() { png_destroy_write_struct(&png, &info); }
  Encoder(const Encoder&) = delete;
  Encoder& operator=(const Encoder&) = delete;
};

void give(png_structp png, png_bytep from, size_t count) {
  auto* e = static_cast<Encoder*>(png_get_io_ptr(png));
  try {
    e->out.insert(e->out.end(), from, from + count);
  } catch (const std::bad_alloc&) {
    e->out_of_memory = true;
  }
  if (e->out_of_memory) png_error(png, "out of memory");
}

// No locals that an error's jump would leave undestroyed.
void add_text(Encoder& e, int kind, const char* key, std::string& value) {
  char own_key[80] = {};  // keys are no longer than 79 characters
  std::strncpy(own_key, key, sizeof own_key - 1);
  png_text text = {};
  text.compression = kind;
  text.key = own_key;
  text.text = value.data();
  text.text_length = text.itxt_length = value.size();  // the one of its kind is looked at
  png_set_text(e.png, e.info, &text, 1);
}

void compress(Encoder& e) {
  png_set_write_fn(e.png, &e, give, nullptr);
  png_set_IHDR(e.png, e.info, static_cast<png_uint_32>(e.width), static_cast<png_uint_32>(e.height), e.bits,
               e.colour_type, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_set_compression_level(e.png, kCompressionLevel);
  if (!e.xmp.empty()) add_text(e, PNG_ITXT_COMPRESSION_NONE, "XML:com.adobe.xmp", e.xmp);
  if (!e.software.empty()) add_text(e, PNG_TEXT_COMPRESSION_NONE, kSoftware, e.software);
  png_write_info(e.png, e.info);
  png_write_image(e.png, e.rows.data());
  png_write_end(e.png, nullptr);
}

std::vector<uint8_t> encode(Encoder& e, const uint8_t* samples, size_t bytes_per_row) {
  e.rows.resize(static_cast<size_t>(e.height));
  for (size_t y = 0; y < e.rows.size(); ++y) e.rows[y] = const_cast<png_bytep>(samples + y * bytes_per_row);
  if (!run(e, compress)) throw std::runtime_error(std::string("cannot write PNG: ") + e.session.message);
  return std::move(e.out);
}

}  // namespace

bool is_png(std::span<const uint8_t> bytes) {
  return bytes.size() >= sizeof kSignature && std::memcmp(bytes.data(), kSignature, sizeof kSignature) == 0;
}

ImageSize png_size(std::span<const uint8_t> bytes, const std::string& name) {
  Decoder d(bytes);
  return header_size(d, name);
}

ScaledImage decode_png(std::span<const uint8_t> bytes, const std::string& name, int64_t max_pixels) {
  Decoder d(bytes);
  const ImageSize full_size = header_size(d, name);
  d.shrink = shrink_that_fits(full_size, max_pixels, name);
  if (png_get_interlace_type(d.png, d.info) != PNG_INTERLACE_NONE) {
    if (d.shrink > 1)
      throw std::runtime_error(name + ": an interlaced PNG cannot be read in parts; save it without interlacing");
    d.image = RgbImage(full_size.width, full_size.height);
    for (int y = 0; y < full_size.height; ++y) d.rows.push_back(reinterpret_cast<png_bytep>(d.image.row(y)));
    if (!run(d, read_interlaced)) fail(d, name);
  } else {
    d.image = RgbImage(full_size.width / d.shrink, full_size.height / d.shrink);
    d.row = RgbImage(full_size.width, 1);
    d.sums.resize(static_cast<size_t>(d.image.width) * 3);
    if (!run(d, read_rows)) fail(d, name);
  }
  return {std::move(d.image), full_size, 1.0 / d.shrink};
}

std::vector<uint8_t> encode_png(const RgbImage& image, const std::string& xmp) {
  Encoder e(image.width, image.height, 8, PNG_COLOR_TYPE_RGB);
  e.xmp = xmp;
  return encode(e, reinterpret_cast<const uint8_t*>(image.samples.data()), static_cast<size_t>(image.width) * 3);
}

std::vector<uint8_t> encode_png(const RgbImage& image) { return encode_png(image, std::string()); }

std::string png_software(std::span<const uint8_t> bytes) {
  if (!is_png(bytes)) return {};
  Decoder d(bytes);
  if (!run(d, read_header)) return {};
  png_textp texts = nullptr;
  const int count = png_get_text(d.png, d.info, &texts, nullptr);
  for (const png_text& text : std::span(texts, static_cast<size_t>(count))) {
    if (std::strcmp(text.key, kSoftware) == 0) return text.text;
  }
  return {};
}

std::vector<uint8_t> encode_png(const RgbImage& image, const Plane<uint8_t>& alpha, const std::string& software) {
  if (alpha.width != image.width || alpha.height != image.height)
    throw std::logic_error("alpha and image differ in size");
  std::vector<uint8_t> rgba(image.samples.size() * 4);
  for (size_t i = 0; i < image.samples.size(); ++i) {
    const Rgb c = image.samples[i];
    rgba[4 * i] = c.r, rgba[4 * i + 1] = c.g, rgba[4 * i + 2] = c.b, rgba[4 * i + 3] = alpha.samples[i];
  }
  Encoder e(image.width, image.height, 8, PNG_COLOR_TYPE_RGB_ALPHA);
  e.software = software;
  return encode(e, rgba.data(), static_cast<size_t>(image.width) * 4);
}

std::vector<uint8_t> encode_png(const RgbImage& image, const Plane<uint8_t>& alpha) {
  return encode_png(image, alpha, std::string());
}

std::vector<uint8_t> encode_png(const Plane<uint8_t>& grey) {
  Encoder e(grey.width, grey.height, 8, PNG_COLOR_TYPE_GRAY);
  return encode(e, grey.samples.data(), static_cast<size_t>(grey.width));
}

std::vector<uint8_t> encode_png(const Plane<uint16_t>& grey) { return encode_png(grey, std::string()); }

std::vector<uint8_t> encode_png(const Plane<uint16_t>& grey, const std::string& xmp) {
  std::vector<uint8_t> big_endian;
  big_endian.reserve(grey.samples.size() * 2);
  for (const uint16_t sample : grey.samples) {
    big_endian.push_back(static_cast<uint8_t>(sample >> 8));
    big_endian.push_back(static_cast<uint8_t>(sample & 255));
  }
  Encoder e(grey.width, grey.height, 16, PNG_COLOR_TYPE_GRAY);
  e.xmp = xmp;
  return encode(e, big_endian.data(), static_cast<size_t>(grey.width) * 2);
}

}  // namespace ldp
