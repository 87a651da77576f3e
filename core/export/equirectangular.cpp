#include "core/export/equirectangular.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/export/export.h"
#include "core/photos/images.h"

namespace ldp {
namespace {

// The colour that is seen first: of the frontmost layer that is present.
RgbImage seen_first(const LayeredPanorama& panorama) {
  RgbImage image = panorama.layers.front().colour;
  for (size_t i = 0; i < image.samples.size(); ++i)
    for (const Layer& layer : panorama.layers) {
      if (!layer.coverage.samples[i]) continue;
      image.samples[i] = layer.colour.samples[i];
      break;
    }
  return image;
}

uint8_t between(uint8_t a, uint8_t b, double t) { return static_cast<uint8_t>(std::lround(a + (b - a) * t)); }

// Rows lie at equal steps of tan(elevation) in the panorama, at equal steps of elevation in the result.
RgbImage equal_angles(const RgbImage& image, const PanoramaGrid& grid, double top_rad, int height, int width) {
  RgbImage flat(width, height);
  for (int y = 0; y < height; ++y) {
    const double v = std::tan(top_rad - (y + 0.5) * grid.theta_pitch);
    const double from = std::clamp((grid.v_top - v) / grid.v_pitch - 0.5, 0.0, image.height - 1.0);
    const int above = std::min(static_cast<int>(from), std::max(0, image.height - 2));
    const int below = std::min(above + 1, image.height - 1);
    for (int x = 0; x < width; ++x) {
      const Rgb a = image.at(x, above);
      const Rgb b = image.at(x, below);
      const double t = from - above;
      flat.at(x, y) = {between(a.r, b.r, t), between(a.g, b.g, t), between(a.b, b.b, t)};
    }
  }
  return flat;
}

std::string value_of(const LayeredPanorama& panorama, const char* key) {
  const auto found = panorama.metadata.find(key);
  return found == panorama.metadata.end() ? std::string() : found->second;
}

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '"')
      out += "&quot;";
    else if (static_cast<unsigned char>(c) >= 32)
      out += c;
  }
  return out;
}

// "2026-01-02T03:04:05Z" as EXIF writes it, "2026:01:02 03:04:05"; empty if it is anything else.
std::string exif_time(const std::string& iso) {
  constexpr std::string_view kForm = "0000-00-00T00:00:00";
  if (iso.size() < kForm.size()) return {};
  for (size_t i = 0; i < kForm.size(); ++i) {
    const bool digit = iso[i] >= '0' && iso[i] <= '9';
    if (kForm[i] == '0' ? !digit : iso[i] != kForm[i]) return {};
  }
  std::string time = iso.substr(0, kForm.size());
  time[4] = time[7] = ':';
  time[10] = ' ';
  return time;
}

// A TIFF structure of ASCII fields: the main directory and, for times, the EXIF directory.
class ExifWriter {
 public:
  void add(uint16_t tag, const std::string& text) { main_.push_back({tag, text}); }
  void add_exif(uint16_t tag, const std::string& text) { exif_.push_back({tag, text}); }

  std::vector<uint8_t> bytes() {
    std::erase_if(main_, [](const Field& field) { return field.text.empty(); });
    std::erase_if(exif_, [](const Field& field) { return field.text.empty(); });
    out_ = {'E', 'x', 'i', 'f', 0, 0, 'I', 'I', 42, 0};
    u32(8);
    const size_t pointer = exif_.empty() ? 0 : 1;
    const size_t exif_at = 8 + directory_bytes(main_.size() + pointer);
    text_at_ = exif_at + (exif_.empty() ? 0 : directory_bytes(exif_.size()));
    u16(static_cast<uint16_t>(main_.size() + pointer));
    for (const Field& field : main_) put(field);
    if (pointer > 0) {
      u16(0x8769), u16(4), u32(1);
      u32(static_cast<uint32_t>(exif_at));
    }
    u32(0);
    if (pointer > 0) {
      u16(static_cast<uint16_t>(exif_.size()));
      for (const Field& field : exif_) put(field);
      u32(0);
    }
    out_.insert(out_.end(), texts_.begin(), texts_.end());
    return out_;
  }

 private:
  struct Field {
    uint16_t tag;
    std::string text;
  };

  static size_t directory_bytes(size_t fields) { return 2 + 12 * fields + 4; }
  void u16(uint16_t v) { out_.insert(out_.end(), {static_cast<uint8_t>(v & 255), static_cast<uint8_t>(v >> 8)}); }
  void u32(uint32_t v) {
    u16(static_cast<uint16_t>(v & 0xFFFF));
    u16(static_cast<uint16_t>(v >> 16));
  }
  // Texts of up to four bytes, the final zero included, stand in the field itself.
  void put(const Field& field) {
    const size_t length = field.text.size() + 1;
    u16(field.tag), u16(2), u32(static_cast<uint32_t>(length));
    if (length <= 4) {
      for (size_t i = 0; i < 4; ++i) out_.push_back(i < field.text.size() ? static_cast<uint8_t>(field.text[i]) : 0);
      return;
    }
    u32(static_cast<uint32_t>(text_at_ + texts_.size()));
    texts_.insert(texts_.end(), field.text.begin(), field.text.end());
    texts_.push_back(0);
  }

  std::vector<Field> main_, exif_;
  std::vector<uint8_t> out_, texts_;
  size_t text_at_ = 0;
};

JpegSegment exif_segment(const LayeredPanorama& panorama) {
  const auto limited = [&](const char* key) { return value_of(panorama, key).substr(0, 1000); };
  const std::string time = exif_time(value_of(panorama, "captured_utc"));
  ExifWriter exif;
  exif.add(0x010E, "Panorama with depth, front layer");
  exif.add(0x0110, limited("device"));
  exif.add(0x0131, limited("software"));
  exif.add(0x0132, time);
  exif.add_exif(0x9003, time);
  exif.add_exif(0x9011, time.empty() ? "" : "+00:00");
  return {0xE1, exif.bytes()};
}

JpegSegment xmp_segment(const std::string& xmp) {
  constexpr std::string_view kSignature{"http://ns.adobe.com/xap/1.0/\0", 29};
  JpegSegment segment{0xE1, {kSignature.begin(), kSignature.end()}};
  segment.bytes.insert(segment.bytes.end(), xmp.begin(), xmp.end());
  return segment;
}

std::string packet(const std::string& namespaces, const std::string& fields) {
  return "<?xpacket begin=\"\xEF\xBB\xBF\" id=\"W5M0MpCehiHzreSzNTczkc9d\"?>\n"
         "<x:xmpmeta xmlns:x=\"adobe:ns:meta/\">\n <rdf:RDF "
         "xmlns:rdf=\"http://www.w3.org/1999/02/22-rdf-syntax-ns#\">\n"
         "  <rdf:Description rdf:about=\"\" " +
         namespaces + "\n" + fields + "  />\n </rdf:RDF>\n</x:xmpmeta>\n<?xpacket end=\"w\"?>";
}

}  // namespace

FlatPanorama flatten(const LayeredPanorama& panorama) {
  const PanoramaGrid& grid = panorama.grid;
  FlatPanorama flat;
  flat.full_width = std::max(2, static_cast<int>(std::lround(2 * std::numbers::pi / grid.theta_pitch)));
  flat.full_height = flat.full_width / 2;
  const int width = std::min(grid.width, flat.full_width);  // an arc that overlaps itself is cut
  const double top = std::atan(grid.v_top);
  const double bottom = std::atan(grid.v(grid.height));
  const int height = std::clamp(static_cast<int>(std::lround((top - bottom) / grid.theta_pitch)), 1, flat.full_height);
  flat.image = equal_angles(seen_first(panorama), grid, top, height, width);
  flat.left = (flat.full_width - width) / 2;
  const int top_px = static_cast<int>(std::lround((std::numbers::pi / 2 - top) / grid.theta_pitch));
  flat.top = std::clamp(top_px, 0, flat.full_height - height);
  return flat;
}

std::string gpano_xmp(const FlatPanorama& flat, const LayeredPanorama& panorama) {
  std::string fields;
  const auto field = [&](const std::string& name, const std::string& value) {
    if (!value.empty()) fields += "   GPano:" + name + "=\"" + escaped(value) + "\"\n";
  };
  field("UsePanoramaViewer", "True");
  field("ProjectionType", "equirectangular");
  field("FullPanoWidthPixels", std::to_string(flat.full_width));
  field("FullPanoHeightPixels", std::to_string(flat.full_height));
  field("CroppedAreaImageWidthPixels", std::to_string(flat.image.width));
  field("CroppedAreaImageHeightPixels", std::to_string(flat.image.height));
  field("CroppedAreaLeftPixels", std::to_string(flat.left));
  field("CroppedAreaTopPixels", std::to_string(flat.top));
  field("InitialViewHeadingDegrees", "180");
  field("SourcePhotosCount", std::to_string(panorama.cameras.size()));
  field("StitchingSoftware", value_of(panorama, "software").substr(0, 1000));
  return packet("xmlns:GPano=\"http://ns.google.com/photos/1.0/panorama/\"", fields);
}

std::string stereo_xmp(const LayeredPanorama& panorama) {
  const std::string software = escaped(value_of(panorama, "software").substr(0, 1000));
  return packet(
      "xmlns:GPano=\"http://ns.google.com/photos/1.0/panorama/\" "
      "xmlns:GSpherical=\"http://ns.google.com/videos/1.0/spherical/\"",
      "   GPano:ProjectionType=\"equirectangular\"\n   GPano:StitchingSoftware=\"" + software +
          "\"\n   GSpherical:Spherical=\"true\"\n   GSpherical:Stitched=\"true\"\n"
          "   GSpherical:ProjectionType=\"equirectangular\"\n   GSpherical:StereoMode=\"top-bottom\"\n");
}

std::vector<uint8_t> picture_file(const std::string& ending, const RgbImage& image, const std::string& xmp,
                                  const LayeredPanorama& panorama, int jpeg_quality) {
  if (ending == ".png") return encode_png(image, xmp);
  const std::vector<JpegSegment> segments = {exif_segment(panorama), xmp_segment(xmp)};
  return encode_jpeg(image, jpeg_quality, segments);
}

std::vector<uint8_t> export_jpeg(const LayeredPanorama& panorama, const ExportOptions& options) {
  const FlatPanorama flat = flatten(panorama);
  return picture_file(".jpg", flat.image, gpano_xmp(flat, panorama), panorama, options.quality);
}

std::vector<uint8_t> export_png(const LayeredPanorama& panorama) {
  const FlatPanorama flat = flatten(panorama);
  return picture_file(".png", flat.image, gpano_xmp(flat, panorama), panorama, 0);
}

}  // namespace ldp
