// Any bytes as a datagram of each of the device's LCM channels; what is accepted must be sendable again.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "drivers/lcm_messages.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::span<const uint8_t> bytes(data, size);
  for (const char* channel : ldp::kMessageChannels) {
    const auto heard = ldp::decode_message(channel, bytes);
    if (heard && !ldp::decode_message(channel, ldp::encode_message(heard->message))) std::abort();
  }
  if (const auto command = ldp::decode_command(bytes))
    if (ldp::decode_command(ldp::encode_command(*command)) != command) std::abort();
  return 0;
}
