// The device's LCM messages as bytes, apart from any connection: channel names, encoding, and decoding of whatever
// strangers send. Decoding never throws; what is malformed, of another version or out of range is none.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drivers/interface/status.h"

namespace ldp {

constexpr const char* kMessageChannels[] = {"LDP_STATUS", "LDP_PROGRESS", "LDP_GUIDANCE",
                                            "LDP_RESULT"};  // as StatusMessage
constexpr const char* kCommandChannel = "LDP_COMMAND";

std::vector<uint8_t> encode_message(const StatusMessage& message);  // stamped with the present time
std::vector<uint8_t> encode_command(Command command);
std::optional<HeardMessage> decode_message(const std::string& channel, std::span<const uint8_t> bytes);
std::optional<Command> decode_command(std::span<const uint8_t> bytes);

}  // namespace ldp
