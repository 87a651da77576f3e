// One client's socket as cpp-httplib reads and writes it, within the bounds of server_tuning.h: whoever sends or reads
// too slowly, or sends too much, finds it at its end.
#pragma once

#include <httplib.h>

#include <array>
#include <cstdint>

#include "device/gallery/http/server_tuning.h"
#include "drivers/interface/unique_fd.h"

namespace ldp::gallery {

class Connection : public httplib::Stream {
 public:
  explicit Connection(UniqueFd socket) : socket_(std::move(socket)) {}

  void begin_request();
  bool has_more() const { return begin_ < end_; }  // another request came with the last one
  bool was_given_away() const { return !socket_.is_open(); }
  UniqueFd give_away() { return std::move(socket_); }
  // Ends it so that the client can read what was sent last.
  void say_goodbye();

  bool is_readable() const override;
  bool is_writable() const override;
  ssize_t read(char* bytes, size_t size) override;
  ssize_t write(const char* bytes, size_t size) override;
  void get_remote_ip_and_port(std::string&, int&) const override {}
  void get_local_ip_and_port(std::string&, int&) const override {}
  socket_t socket() const override { return socket_.get(); }

 private:
  bool fill();

  UniqueFd socket_;
  std::array<char, 4096> buffer_;
  size_t begin_ = 0, end_ = 0;  // of what is in the buffer
  int64_t head_until_ns_ = 0, written_ = 0, waited_ns_ = 0;
  size_t head_bytes_ = 0;
};

}  // namespace ldp::gallery
