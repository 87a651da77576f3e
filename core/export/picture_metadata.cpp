#include "core/export/picture_metadata.h"

#include <md5.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <string_view>

#include "core/base/markup_text.h"
#include "core/photos/images.h"

namespace ldp {
namespace {

std::string value_of(const LayeredPanorama& panorama, const char* key) {
  const auto found = panorama.metadata.find(key);
  return found == panorama.metadata.end() ? std::string() : found->second;
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

JpegSegment app1_segment(std::string_view signature, std::string_view content) {
  JpegSegment segment{0xE1, {signature.begin(), signature.end()}};
  segment.bytes.insert(segment.bytes.end(), content.begin(), content.end());
  return segment;
}

JpegSegment xmp_segment(const std::string& xmp) {
  constexpr std::string_view kSignature{"http://ns.adobe.com/xap/1.0/\0", 29};
  return app1_segment(kSignature, xmp);
}

constexpr char kGPanoNamespace[] = "xmlns:GPano=\"http://ns.google.com/photos/1.0/panorama/\"";
constexpr char kGDepthNamespace[] = "xmlns:GDepth=\"http://ns.google.com/photos/1.0/depthmap/\"";

std::string meta(const std::string& namespaces, const std::string& fields) {
  return "<x:xmpmeta xmlns:x=\"adobe:ns:meta/\">\n <rdf:RDF "
         "xmlns:rdf=\"http://www.w3.org/1999/02/22-rdf-syntax-ns#\">\n"
         "  <rdf:Description rdf:about=\"\" " +
         namespaces + "\n" + fields + "  />\n </rdf:RDF>\n</x:xmpmeta>";
}

std::string packet(const std::string& namespaces, const std::string& fields) {
  return "<?xpacket begin=\"\xEF\xBB\xBF\" id=\"W5M0MpCehiHzreSzNTczkc9d\"?>\n" + meta(namespaces, fields) +
         "\n<?xpacket end=\"w\"?>";
}

// Attributes of a description, a line each; those without a value are left out.
class Fields {
 public:
  explicit Fields(const char* prefix) : prefix_(prefix) {}
  void add(const std::string& name, const std::string& value) {
    if (!value.empty()) text_ += "   " + (prefix_ + (":" + name)) + "=\"" + escaped(value) + "\"\n";
  }
  void add(const std::string& name, int value) { add(name, std::to_string(value)); }
  const std::string& text() const { return text_; }

 private:
  std::string prefix_, text_;
};

std::string gpano_fields(const FlatPanorama& flat, const LayeredPanorama& panorama) {
  Fields fields("GPano");
  fields.add("UsePanoramaViewer", "True");
  fields.add("ProjectionType", "equirectangular");
  fields.add("FullPanoWidthPixels", flat.full_width);
  fields.add("FullPanoHeightPixels", flat.full_height);
  fields.add("CroppedAreaImageWidthPixels", flat.image.width);
  fields.add("CroppedAreaImageHeightPixels", flat.image.height);
  fields.add("CroppedAreaLeftPixels", flat.left);
  fields.add("CroppedAreaTopPixels", flat.top);
  fields.add("InitialViewHeadingDegrees", 180);
  fields.add("SourcePhotosCount", static_cast<int>(panorama.cameras.size()));
  fields.add("StitchingSoftware", value_of(panorama, "software").substr(0, 1000));
  return fields.text();
}

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", value);
  return text;
}

std::string gdepth_fields(const RangeInverse& depth) {
  Fields fields("GDepth");
  fields.add("Format", "RangeInverse");
  fields.add("Near", number(depth.nearest));
  fields.add("Far", number(depth.farthest));
  fields.add("MeasureType", "OpticRay");
  fields.add("Mime", "image/png");
  fields.add("ImageWidth", depth.codes.width);
  fields.add("ImageHeight", depth.codes.height);
  return fields.text();
}

// The name under which the main packet refers to extended XMP: the MD5 digest of it.
std::string digest_of(const std::string& extended) {
  char text[MD5_DIGEST_STRING_LENGTH];
  MD5Data(reinterpret_cast<const uint8_t*>(extended.data()), extended.size(), text);
  for (char& digit : text) digit = static_cast<char>(std::toupper(static_cast<unsigned char>(digit)));
  return text;
}

std::string big_endian(size_t value) {
  std::string bytes;
  for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(value >> shift & 255);
  return bytes;
}

// Extended XMP (XMP specification, part 3), in as many segments as it takes.
void append_extended(const std::string& extended, const std::string& digest, std::vector<JpegSegment>& segments) {
  constexpr std::string_view kSignature{"http://ns.adobe.com/xmp/extension/\0", 35};
  constexpr size_t kMostInSegment = 65000;
  for (size_t begin = 0; begin < extended.size(); begin += kMostInSegment) {
    const std::string place = digest + big_endian(extended.size()) + big_endian(begin);
    segments.push_back(app1_segment(kSignature, place + extended.substr(begin, kMostInSegment)));
  }
}

// How many times as far as the nearest thing the farthest one is told: as fine as the file's own steps.
constexpr double kFarthest = 4000;

}  // namespace

std::string gpano_xmp(const FlatPanorama& flat, const LayeredPanorama& panorama) {
  return packet(kGPanoNamespace, gpano_fields(flat, panorama));
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

RangeInverse range_inverse(const FlatPanorama& flat) {
  constexpr double kMostCode = 65535;
  double nearest = 0, farthest = 1e300;  // inverse distances
  for (const float w : flat.inverse_distance.samples) {
    nearest = std::max(nearest, static_cast<double>(w));
    if (w > 0) farthest = std::min(farthest, static_cast<double>(w));
  }
  if (!(nearest > 0)) nearest = 1;  // all of it is at infinity
  farthest = std::clamp(farthest, nearest / kFarthest, nearest / 2);
  RangeInverse depth{1 / nearest, 1 / farthest, Plane<uint16_t>(flat.image.width, flat.image.height)};
  for (size_t i = 0; i < depth.codes.samples.size(); ++i) {
    const double share = (nearest - static_cast<double>(flat.inverse_distance.samples[i])) / (nearest - farthest);
    depth.codes.samples[i] = static_cast<uint16_t>(std::lround(kMostCode * std::clamp(share, 0.0, 1.0)));
  }
  return depth;
}

std::vector<uint8_t> depth_file(const std::string& ending, const FlatPanorama& flat, const LayeredPanorama& panorama,
                                int jpeg_quality) {
  const RangeInverse depth = range_inverse(flat);
  const std::string fields = gpano_fields(flat, panorama) + gdepth_fields(depth);
  const std::string namespaces = std::string(kGPanoNamespace) + " " + kGDepthNamespace;
  if (ending == ".png") return encode_png(depth.codes, packet(namespaces, fields));
  const std::string extended = meta(kGDepthNamespace, "   GDepth:Data=\"" + base64(encode_png(depth.codes)) + "\"\n");
  const std::string digest = digest_of(extended);
  const std::string main = packet(namespaces + " xmlns:xmpNote=\"http://ns.adobe.com/xmp/note/\"",
                                  fields + "   xmpNote:HasExtendedXMP=\"" + digest + "\"\n");
  std::vector<JpegSegment> segments = {exif_segment(panorama), xmp_segment(main)};
  append_extended(extended, digest, segments);
  return encode_jpeg(flat.image, jpeg_quality, segments);
}

}  // namespace ldp
