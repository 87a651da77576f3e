// The captures that wait to be built, the build in work, and the one that follows the sweep in work. What becomes of
// each is recorded beside its frames (capture_store.h), so that the next start knows.
#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "device/capture/capture_store.h"
#include "device/service/builds/build_child.h"
#include "device/service/config/config.h"
#include "device/service/events/poll_loop.h"

namespace ldp {

class BuildQueue {
 public:
  BuildQueue(const Config& config, const CaptureStore& store) : config_(config), store_(store) {}  // both live longer
  BuildQueue(const BuildQueue&) = delete;
  BuildQueue& operator=(const BuildQueue&) = delete;

  // The backlog.
  void add_unfinished();  // what an earlier run left behind and no verdict was passed on; throws what `recover` throws
  void add_failed();      // instead of what waits, everything without a panorama; forgets the verdicts
  void put_first(const std::string& capture) { backlog_.push_front(capture); }
  bool waits() const { return !backlog_.empty(); }
  std::string take_next();

  // The build of the sweep that still goes on is told of each frame, by the stored file's name. Whatever becomes of
  // it, the sweep goes on.
  void follow(const std::string& capture, const std::string& stored_file, bool is_first);
  void stop_following() { follower_.reset(); }

  // The build in work.
  bool runs() const { return build_ != nullptr; }
  void start(const std::string& capture);  // takes the follower over, where there is one; throws
  std::optional<BuildProgress> read_progress();
  std::optional<std::string> take_remark();
  std::optional<BuildEnd> end() { return build_->end(); }
  void kill() { build_.reset(); }

  // What came of a build. Each tells what cannot be recorded on the log.
  BuildEnd conclude(const std::string& capture, const BuildEnd& end);  // moves the panorama to its place, or fails
  void record_failure(const std::string& capture, const BuildEnd& end);
  void record_stop(const std::string& capture, bool cancelled);

  Watches watches(const std::function<void()>& serve_build);

 private:
  BuildCommand command_for(const std::string& capture, bool follows) const;
  bool follower_takes_over();
  void serve_follower();

  const Config& config_;
  const CaptureStore& store_;
  std::deque<std::string> backlog_;
  std::unique_ptr<BuildChild> build_;
  std::unique_ptr<BuildChild> follower_;  // becomes `build_` at the end of its sweep
};

}  // namespace ldp
