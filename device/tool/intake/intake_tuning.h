// Limits on what strangers' archives, films and photos may cost: unit, meaning, and the range that makes sense. Those
// of pixels stand in core/photos/images.h.
#pragma once

#include <cstddef>
#include <cstdint>

namespace ldp {

// --- archives (zip_archive.h) ---

inline constexpr int kMaxEntries = 20'000;                      // of an archive, photos or not; 1,000 .. 100,000
inline constexpr int kMaxUnpackedPhotos = 2'000;                // 500 .. 10,000
inline constexpr int64_t kMaxPhoto_bytes = int64_t{256} << 20;  // of one photo; 64 MiB .. 1 GiB
inline constexpr int64_t kMaxNotes_bytes = int64_t{1} << 20;    // of a capture.json; 64 KiB .. 16 MiB
inline constexpr size_t kMaxNotes = 100;                        // of an archive; 10 .. 1,000
inline constexpr int64_t kMaxUnpacked_bytes = int64_t{4} << 30;
// Photos are packed already. An archive that unpacks to more than so many times its size, and this much besides, holds
// something else; 5 .. 100, 1 MiB .. 64 MiB.
inline constexpr int64_t kMaxUnpackedRatio = 20, kSmallUnpacked_bytes = int64_t{16} << 20;

// --- films (film_frames.h) ---

inline constexpr int kMaxFilmPictures = 36'000;  // that are looked at: twenty minutes; 10,000 .. 200,000
inline constexpr int kMaxFilmFrames = 200;       // that are chosen; 40 .. 1,000
inline constexpr double kFilmOverlap = 0.8;      // of neighbours among them, at least; 0.7 .. 0.9
// Of a film that turns so little that fewer than kFewFilmFrames are chosen, so many, with overlaps at most so large;
// 8 .. 20, 10 .. 40, 0.9 .. 0.95
inline constexpr int kFewFilmFrames = 16, kWantedFilmFrames = 20;
inline constexpr double kMostFilmOverlap = 0.95;
inline constexpr int kFilmJpegQuality = 95;  // of frames while they are worked on, 1 .. 100; 90 .. 98
inline constexpr double kFilmRate = 30;      // pictures a second, where it matters: for speeds between two of them

// --- other programs that read foreign bytes ---

inline constexpr uint64_t kDecoderMemory_bytes = uint64_t{4} << 30;  // of address space; 2 GiB .. 16 GiB

// --- lists of photos ---

inline constexpr int64_t kMaxList_bytes = int64_t{4} << 20;

}  // namespace ldp
