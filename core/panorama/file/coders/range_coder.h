// Adaptive binary range coding (FORMAT.md, "Range coding"): the carry-propagating coder of LZMA with 16-bit
// probabilities. Encoder and decoder have the same function bit(), so that one template codes and decodes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace ldp::file {

// What is known of one kind of decision: the probability of 0 in 1/65536, and how often it was seen (up to 63).
struct BitModel {
  uint16_t zero = 32768;
  uint16_t seen = 0;

  static constexpr uint16_t kMostSeen = 63;

  void update(bool bit) {
    const uint32_t rate = kRates[seen];
    if (bit)
      zero = static_cast<uint16_t>(zero - (zero * rate >> 16));
    else
      zero = static_cast<uint16_t>(zero + ((65535U - zero) * rate >> 16));
    seen = static_cast<uint16_t>(seen + (seen < kMostSeen));
  }

 private:
  // 1 / (seen + 1.6) in 1/65536: the mean of what was seen, at first; a moving mean over about 64 decisions later.
  static constexpr std::array<uint32_t, kMostSeen + 1> kRates = [] {
    std::array<uint32_t, kMostSeen + 1> rates{};
    for (uint32_t n = 0; n <= kMostSeen; ++n) rates[n] = 655360 / (10 * n + 16);
    return rates;
  }();
};

class RangeEncoder {
 public:
  bool bit(BitModel& model, bool value) {
    const uint32_t bound = (range_ >> 16) * model.zero;
    if (value) {
      low_ += bound;
      range_ -= bound;
    } else {
      range_ = bound;
    }
    model.update(value);
    while (range_ < kLeastRange) {
      range_ <<= 8;
      shift_low();
    }
    return value;
  }

  bool ended() const { return false; }

  std::vector<uint8_t> finish() {
    for (int i = 0; i < 5; ++i) shift_low();
    return std::move(bytes_);
  }

 private:
  static constexpr uint32_t kLeastRange = 1 << 24;

  // The top byte of low goes out once no carry can change it any more.
  void shift_low() {
    if (low_ < 0xFF000000U || low_ > 0xFFFFFFFFU) {
      const auto carry = static_cast<uint8_t>(low_ >> 32);
      if (started_) bytes_.push_back(static_cast<uint8_t>(held_ + carry));
      started_ = true;
      for (; held_ones_ > 0; --held_ones_) bytes_.push_back(static_cast<uint8_t>(0xFF + carry));
      held_ = static_cast<uint8_t>(low_ >> 24 & 255);
    } else {
      ++held_ones_;
    }
    low_ = (low_ & 0x00FFFFFF) << 8;
  }

  uint64_t low_ = 0;
  uint32_t range_ = 0xFFFFFFFF;
  uint8_t held_ = 0;      // the last byte, which a carry may still raise
  size_t held_ones_ = 0;  // bytes 0xFF after it, which a carry would turn to 0
  bool started_ = false;
  std::vector<uint8_t> bytes_;
};

class RangeDecoder {
 public:
  explicit RangeDecoder(std::span<const uint8_t> bytes) : next_(bytes.data()), end_(bytes.data() + bytes.size()) {
    for (int i = 0; i < 4; ++i) code_ = code_ << 8 | next_byte();
  }

  bool bit(BitModel& model, bool = false) {
    const uint32_t bound = (range_ >> 16) * model.zero;
    const bool value = code_ >= bound;
    if (value) {
      code_ -= bound;
      range_ -= bound;
    } else {
      range_ = bound;
    }
    model.update(value);
    while (range_ < kLeastRange) {
      range_ <<= 8;
      code_ = code_ << 8 | next_byte();
    }
    return value;
  }

  bool ended() const { return missing_ > 0; }  // what is decoded from there on is nothing, and takes as long
  size_t bytes_left() const { return static_cast<size_t>(end_ - next_); }

 private:
  static constexpr uint32_t kLeastRange = 1 << 24;

  uint8_t next_byte() {
    if (next_ < end_) return *next_++;
    ++missing_;
    return 0;
  }

  const uint8_t* next_;
  const uint8_t* end_;
  uint32_t range_ = 0xFFFFFFFF;
  uint32_t code_ = 0;
  size_t missing_ = 0;
};

}  // namespace ldp::file
