// Sizes and speeds of an .ldp file against other coders, for the tables of core/panorama/file/FORMAT.md.
//
//   ldp_sizes FILE.ldp     best a file with lossless colour, so that quality is measured against the truth
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <exception>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include <zlib.h>
#include "core/base/files.h"
#include "core/panorama/file/ldp_file.h"
#include "core/photos/images.h"
#ifdef LDP_ZSTD
#include <zstd.h>
#endif

namespace ldp {
namespace {

using Bytes = std::vector<uint8_t>;

// Of processor time: one thread, whatever else the machine does.
double seconds(const std::function<void()>& action) {
  const std::clock_t begin = std::clock();
  action();
  return static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
}

constexpr int kAllLayers = -1;

double bytes_of(std::span<const uint8_t> file, const char* type, int layer = kAllLayers) {
  double sum = 0;
  for (const LdpChunk& chunk : describe_ldp(file).chunks)
    if (chunk.type == type && (layer == kAllLayers || chunk.layer == layer)) sum += static_cast<double>(chunk.length);
  return sum;
}

Bytes nibbles(const Plane<uint8_t>& codes) {
  Bytes packed((codes.samples.size() + 1) / 2);
  for (size_t i = 0; i < codes.samples.size(); ++i)
    packed[i / 2] = static_cast<uint8_t>(packed[i / 2] | codes.samples[i] << (i % 2 * 4));
  return packed;
}

size_t zlib_size(const Bytes& bytes) {
  uLongf length = compressBound(static_cast<uLong>(bytes.size()));
  Bytes out(length);
  compress2(out.data(), &length, bytes.data(), static_cast<uLong>(bytes.size()), 9);
  return length;
}

size_t zstd_size([[maybe_unused]] const Bytes& bytes) {
#ifdef LDP_ZSTD
  Bytes out(ZSTD_compressBound(bytes.size()));
  return ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), 19);
#else
  return 0;
#endif
}

RgbImage grey(const Plane<uint8_t>& codes, int scale) {
  RgbImage image(codes.width, codes.height);
  for (size_t i = 0; i < codes.samples.size(); ++i) {
    const auto v = static_cast<uint8_t>(codes.samples[i] * scale);
    image.samples[i] = {v, v, v};
  }
  return image;
}

// As others would keep the same: codes with 0 where absent, and a bit map of what is present.
void print_others(const LayeredPanorama& panorama) {
  double png = 0, zlib = 0, zstd = 0, webp = 0;
  for (const Layer& layer : panorama.layers) {
    const bool dense =
        std::all_of(layer.coverage.samples.begin(), layer.coverage.samples.end(), [](uint8_t c) { return c == 1; });
    for (const Plane<uint8_t>* plane : {&layer.depth.codes, &layer.coverage}) {
      if (plane == &layer.coverage && dense) continue;
      png += static_cast<double>(encode_png(*plane).size());
      zlib += static_cast<double>(zlib_size(nibbles(*plane)));
      zstd += static_cast<double>(zstd_size(nibbles(*plane)));
      webp += static_cast<double>(encode_webp_lossless(grey(*plane, 17)).size());
    }
  }
  const double scale = 8.0 / static_cast<double>(panorama.layers[0].coverage.samples.size());
  std::printf("  8-bit PNG %.3f   nibbles + zlib -9 %.3f   nibbles + zstd -19 %.3f   WebP lossless %.3f\n", png * scale,
              zlib * scale, zstd * scale, webp * scale);
}

void print_depth(LayeredPanorama panorama, int block_px) {
  for (Layer& layer : panorama.layers) {
    DisparityMap disparity = decode_depth(layer.depth, layer.coverage);
    if (block_px == 0)
      for (uint16_t& d : disparity.samples)
        if (d != kNoDisparity) d = static_cast<uint16_t>((d + 127) / 255 * 255);
    layer.depth = encode_depth(disparity, block_px);
    layer.colour = RgbImage(layer.coverage.width, layer.coverage.height);
  }
  Bytes file;
  const double encoding = seconds([&] { file = encode_ldp(panorama, {50, LdpCodec::jpeg}); });
  const auto pixels = static_cast<double>(panorama.layers[0].coverage.samples.size());
  const LdpReader reader(file);
  std::printf("blocks of %d px: all layers %.4f bit per panorama pixel, encoded in %.2f s\n", block_px,
              bytes_of(file, "DPTH") * 8 / pixels, encoding);
  double whole = 0;
  for (size_t l = 0; l < panorama.layers.size(); ++l) {
    double best = 1e9;
    for (int i = 0; i < 5; ++i)
      best = std::min(best, seconds([&] { reader.read_layer(static_cast<int>(l), {0, panorama.grid.width}, false); }));
    std::printf("  layer %zu: %.4f bit, decoded at %.0f Mpixel/s\n", l + 1,
                bytes_of(file, "DPTH", static_cast<int>(l)) * 8 / pixels, pixels / best / 1e6);
    whole += best;
  }
  std::printf("  all: decoded at %.0f Mpixel/s\n", pixels * static_cast<double>(panorama.layers.size()) / whole / 1e6);
  print_others(panorama);
}

double squared_error(const RgbImage& a, const RgbImage& b, const Plane<uint8_t>& coverage, double& count) {
  double sum = 0;
  for (size_t i = 0; i < a.samples.size(); ++i) {
    if (!coverage.samples[i]) continue;
    const Rgb p = a.samples[i];
    const Rgb q = b.samples[i];
    sum += std::pow(p.r - q.r, 2) + std::pow(p.g - q.g, 2) + std::pow(p.b - q.b, 2);
    count += 3;
  }
  return sum;
}

void print_colour(const LayeredPanorama& panorama, LdpCodec codec, int quality) {
  Bytes file;
  const double encoding = seconds([&] { file = encode_ldp(panorama, {quality, codec}); });
  LayeredPanorama back;
  const double decoding = seconds([&] { back = decode_ldp(file); });
  double error = 0, count = 0, front = 0, front_count = 0;
  for (size_t l = 0; l < panorama.layers.size(); ++l) {
    const double e =
        squared_error(panorama.layers[l].colour, back.layers[l].colour, panorama.layers[l].coverage, count);
    error += e;
    if (l == 0) front = e, front_count = count;
  }
  const RgbImage& image = panorama.layers[0].colour;
  const bool jpeg = codec == LdpCodec::jpeg;
  Bytes flat;
  const double flat_encoding = seconds([&] {
    flat = jpeg             ? encode_jpeg(image, quality)
           : quality == 101 ? encode_webp_lossless(image)
                            : encode_webp(image, quality);
  });
  // Whichever is smaller: the image as it is, black where the layer is absent, or as the file continues it there.
  const double alone = std::min(static_cast<double>(flat.size()), bytes_of(file, "COLR", 0));
  const auto psnr = [](double e, double n) { return e == 0 ? 99.0 : 10 * std::log10(255 * 255 * n / e); };
  std::printf(
      "%s %3d: file %8zu  colour %8.0f  layer 1 alone %8.0f (%.2f s)  ratio %.3f  %.2f dB (layer 1 %.2f)  encode %.2f "
      "s "
      "decode %.2f s\n",
      jpeg ? "JPEG" : "WebP", quality, file.size(), bytes_of(file, "COLR"), alone, flat_encoding,
      static_cast<double>(file.size()) / alone, psnr(error, count), psnr(front, front_count), encoding, decoding);
}

void print_all(const char* name) {
  const MappedFile mapped(name);
  const double describing = seconds([&] { describe_ldp(mapped.bytes()); });
  const LayeredPanorama panorama = decode_ldp(mapped.bytes());
  const auto pixels = static_cast<double>(panorama.layers[0].coverage.samples.size());
  std::printf("%s: %d x %d, %zu layers, described in %.2f ms\n", name, panorama.grid.width, panorama.grid.height,
              panorama.layers.size(), 1e3 * describing);
  for (size_t l = 0; l < panorama.layers.size(); ++l) {
    const auto& coverage = panorama.layers[l].coverage.samples;
    std::printf("  layer %zu: coverage %.4f, as stored %.4f bit of depth and coverage per panorama pixel\n", l + 1,
                static_cast<double>(std::count(coverage.begin(), coverage.end(), 1)) / pixels,
                bytes_of(mapped.bytes(), "DPTH", static_cast<int>(l)) * 8 / pixels);
  }
  std::printf("  all: as stored %.4f bit\n", bytes_of(mapped.bytes(), "DPTH") * 8 / pixels);
  for (const int block_px : {0, 8, 16, 32}) print_depth(panorama, block_px);
  for (const int quality : {75, 85, 90, 93, 94, 95, 96, 97})
    for (const LdpCodec codec : {LdpCodec::jpeg, LdpCodec::webp}) print_colour(panorama, codec, quality);
  print_colour(panorama, LdpCodec::webp, 101);
}

}  // namespace
}  // namespace ldp

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: ldp_sizes FILE.ldp\n");
    return 2;
  }
  try {
    ldp::print_all(argv[1]);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "ldp_sizes: %s\n", e.what());
    return 1;
  }
}
