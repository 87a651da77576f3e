// Bounds of the gallery's server.
#pragma once

#include <cstddef>
#include <cstdint>

namespace ldp::gallery {

constexpr int64_t kMillisecond_ns = 1'000'000;

constexpr int kServers = 16;           // requests answered at a time; 8 .. 64
constexpr size_t kMostWaiting = 1024;  // connections that wait for a request, or to be served; more are closed
constexpr int kHeadWithin_ms =
    5'000;  // a request's whole head, from the connection or the last reply on; 2000 .. 10000
constexpr size_t kMostHeadBytes = 16'384;  // of a request
constexpr int kShortage_ms = 250;          // until connections are asked for again where there was no room for one
constexpr int kLateEvery_ms = 500;         // connections that are late are looked for
constexpr int kMostRequests = 1'000;       // of a connection that come at once
constexpr int kUnreadFor_ms = 5'000;       // that a client may read nothing in all, and more for
constexpr int kLeastBytesPer_ms = 16;      // every so many bytes that it has taken
constexpr int kSendBuffer = 131'072;       // bytes on the way to a client, and as many for the kernel's own
constexpr int kGoodbye_ms = 200;           // a client's last bytes are awaited, so that it reads why it was refused

}  // namespace ldp::gallery
