#include "device/tool/exr/exr_view.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfChromaticities.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStandardAttributes.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

namespace ldp {
namespace {

// The file in memory: it reaches the disk as every other result does.
class Bytes : public Imf::OStream {
 public:
  Bytes() : Imf::OStream("a view") {}

  void write(const char* chars, int count) override {
    const auto end = static_cast<size_t>(at_) + static_cast<size_t>(count);
    if (bytes.size() < end) bytes.resize(end);
    std::copy_n(chars, count, bytes.begin() + static_cast<std::ptrdiff_t>(at_));
    at_ = end;
  }
  uint64_t tellp() override { return at_; }
  void seekp(uint64_t position) override { at_ = position; }  // back to the table of rows, once they are written

  std::vector<uint8_t> bytes;

 private:
  uint64_t at_ = 0;
};

struct HalfPixel {
  half r, g, b, a;
};

// IEC 61966-2-1.
std::array<float, 256> linear_of_srgb() {
  std::array<float, 256> linear{};
  for (size_t code = 0; code < linear.size(); ++code) {
    const double s = static_cast<double>(code) / 255;
    linear[code] = static_cast<float>(s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4));
  }
  return linear;
}

void fill_row(const View& view, int y, const std::array<float, 256>& linear, std::vector<HalfPixel>& row) {
  const Rgb* const colour = view.colour.row(y);
  const uint8_t* const alpha = view.alpha.row(y);
  for (size_t x = 0; x < row.size(); ++x) {
    const float a = static_cast<float>(alpha[x]) / 255;
    row[x] = {half(linear[colour[x].r] * a), half(linear[colour[x].g] * a), half(linear[colour[x].b] * a), half(a)};
  }
}

Imf::Header header_of(const View& view) {
  Imf::Header header(view.colour.width, view.colour.height);
  header.compression() = Imf::ZIP_COMPRESSION;
  Imf::addChromaticities(header, Imf::Chromaticities());  // those of sRGB
  for (const char* channel : {"R", "G", "B", "A"}) header.channels().insert(channel, Imf::Channel(Imf::HALF));
  header.channels().insert("Z", Imf::Channel(Imf::FLOAT));
  return header;
}

// Colours from the one row at hand, again and again; depths from where they are, which the library only reads.
Imf::FrameBuffer buffer_of(const View& view, std::vector<HalfPixel>& row) {
  Imf::FrameBuffer buffer;
  const auto colour = [&](const char* name, half& first) {
    buffer.insert(name, Imf::Slice(Imf::HALF, reinterpret_cast<char*>(&first), sizeof(HalfPixel), 0));
  };
  colour("R", row.front().r);
  colour("G", row.front().g);
  colour("B", row.front().b);
  colour("A", row.front().a);
  auto* const depth = const_cast<float*>(view.depth.samples.data());
  buffer.insert("Z", Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(depth), sizeof(float),
                                sizeof(float) * static_cast<size_t>(view.depth.width)));
  return buffer;
}

}  // namespace

void check_exr_is_built() {}

std::vector<uint8_t> encode_exr(const View& view) {
  if (view.depth.empty()) throw std::logic_error("encode_exr: a view without depth");
  const std::array<float, 256> linear = linear_of_srgb();
  std::vector<HalfPixel> row(static_cast<size_t>(view.colour.width));
  Bytes out;
  {
    Imf::OutputFile file(out, header_of(view), 0);
    file.setFrameBuffer(buffer_of(view, row));
    for (int y = 0; y < view.colour.height; ++y) {
      fill_row(view, y, linear, row);
      file.writePixels(1);
    }
  }  // the table of rows is written by its end
  return std::move(out.bytes);
}

}  // namespace ldp
