#include <libexif/exif-data.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "core/photos/codecs/formats.h"

namespace ldp {
namespace {

struct Unref {
  void operator()(ExifData* data) const { exif_data_unref(data); }
};

std::optional<double> number(ExifData* data, ExifTag tag) {
  const ExifEntry* entry = exif_data_get_entry(data, tag);
  if (!entry || !entry->data || entry->components < 1) return std::nullopt;
  const ExifByteOrder order = exif_data_get_byte_order(data);
  if (entry->format == EXIF_FORMAT_SHORT && entry->size >= 2) return exif_get_short(entry->data, order);
  if (entry->format == EXIF_FORMAT_LONG && entry->size >= 4) return exif_get_long(entry->data, order);
  if (entry->format == EXIF_FORMAT_RATIONAL && entry->size >= 8) {
    const ExifRational value = exif_get_rational(entry->data, order);
    if (value.denominator != 0) return static_cast<double>(value.numerator) / value.denominator;
  }
  return std::nullopt;
}

double millimetres_per_unit(double resolution_unit) {
  if (resolution_unit == 3) return 10.0;
  if (resolution_unit == 4) return 1.0;
  return 25.4;
}

// From the 35 mm equivalent, which compares diagonals; else from the sensor's pixels per millimetre.
std::optional<double> focal_hint(ExifData* data, ImageSize size) {
  const double longer = std::max(size.width, size.height);
  const auto equivalent_mm = number(data, EXIF_TAG_FOCAL_LENGTH_IN_35MM_FILM);
  if (equivalent_mm && *equivalent_mm > 0) {
    const double diagonal_35mm = std::hypot(36.0, 24.0);
    return *equivalent_mm / diagonal_35mm * std::hypot(size.width, size.height) / longer;
  }
  const auto focal_mm = number(data, EXIF_TAG_FOCAL_LENGTH);
  const auto resolution = number(data, EXIF_TAG_FOCAL_PLANE_X_RESOLUTION);
  if (!focal_mm || !resolution || *focal_mm <= 0 || *resolution <= 0) return std::nullopt;
  const double unit_mm = millimetres_per_unit(number(data, EXIF_TAG_FOCAL_PLANE_RESOLUTION_UNIT).value_or(2));
  // The resolution speaks of the photo as taken, which may have been made smaller since.
  const double taken = std::max(number(data, EXIF_TAG_PIXEL_X_DIMENSION).value_or(size.width),
                                number(data, EXIF_TAG_PIXEL_Y_DIMENSION).value_or(size.height));
  if (taken <= 0) return std::nullopt;
  return *focal_mm * *resolution / unit_mm / taken;
}

}  // namespace

Exif read_exif(std::span<const uint8_t> jpeg, ImageSize size) {
  constexpr size_t kLargestHeader = 1 << 20;  // EXIF stands near the start, in a segment of at most 64 KiB
  const auto head = static_cast<unsigned>(std::min(jpeg.size(), kLargestHeader));
  const std::unique_ptr<ExifData, Unref> data(exif_data_new_from_data(jpeg.data(), head));
  Exif exif;
  if (!data) return exif;
  const double orientation = number(data.get(), EXIF_TAG_ORIENTATION).value_or(1);
  if (orientation >= 1 && orientation <= 8) exif.orientation = static_cast<int>(orientation);
  exif.focal_hint = focal_hint(data.get(), size);
  // 0.2 to 20 image sides: from fisheye to the longest telephoto; anything else is a slip of the writer.
  if (exif.focal_hint && (*exif.focal_hint < 0.2 || *exif.focal_hint > 20)) exif.focal_hint.reset();
  return exif;
}

}  // namespace ldp
