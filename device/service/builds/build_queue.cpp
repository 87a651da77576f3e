#include "device/service/builds/build_queue.h"

#include <algorithm>
#include <exception>
#include <thread>
#include <utility>

#include "device/capture/log.h"
#include "device/service/session_tuning.h"

namespace ldp {

// --- the backlog -----------------------------------------------------------------------------------------------------

void BuildQueue::add_unfinished() {
  for (const CaptureState& capture : store_.recover()) {
    const BuildRecord& build = capture.build;
    const bool wants = !capture.built && !build.cancelled && !build.failed && build.interruptions < kMaxInterruptions;
    if (wants && capture.frames >= config_.min_frames) backlog_.push_back(capture.name);
  }
}

void BuildQueue::add_failed() {
  backlog_.clear();
  try {
    for (const CaptureState& capture : store_.recover()) {
      if (capture.built || capture.frames < config_.min_frames) continue;
      store_.forget_build_record(capture.name);
      backlog_.push_back(capture.name);
    }
  } catch (const std::exception& error) {
    log_warning(error.what());
  }
}

std::string BuildQueue::take_next() {
  std::string capture = std::move(backlog_.front());
  backlog_.pop_front();
  return capture;
}

// --- the build that follows the sweep --------------------------------------------------------------------------------

void BuildQueue::follow(const std::string& capture, const std::string& stored_file, bool is_first) {
  try {
    if (is_first) {
      store_.clear_building();
      follower_ = std::make_unique<BuildChild>(command_for(capture, true));
    }
    if (follower_) follower_->tell(stored_file);
  } catch (const std::exception& error) {
    log_warning(std::string(error.what()) + "; the sweep is built after its end");
    follower_.reset();
  }
}

bool BuildQueue::follower_takes_over() {
  if (!follower_) return false;
  try {
    follower_->tell("end");
    return true;
  } catch (const std::exception&) {
    follower_.reset();  // it has just died
    return false;
  }
}

void BuildQueue::serve_follower() {
  if (!follower_) return;
  follower_->read_errors();
  follower_->read_progress();
  const auto end = follower_->end();
  if (!end) return;
  const std::string why = end->ok ? "it did not wait for the end" : end->reason;
  log_warning("the build that followed the sweep is over: " + why + "; the sweep is built after its end");
  follower_.reset();
}

// --- the build in work -----------------------------------------------------------------------------------------------

BuildCommand BuildQueue::command_for(const std::string& capture, bool follows) const {
  BuildCommand command;
  command.is_told = follows;
  command.program = program_of(config_);
  command.niceness = config_.niceness;
  command.memory_limit_bytes = uint64_t{static_cast<unsigned>(config_.memory_limit_mib)} << 20;
  const unsigned cores = std::max(1U, std::thread::hardware_concurrency());
  const int threads = config_.threads > 0 ? config_.threads : static_cast<int>(cores);
  command.arguments = {
      "build",    store_.folder_of(capture).string(), "-o",        store_.building_of(capture).string(),
      "--report", store_.report_of(capture).string(), "--threads", std::to_string(threads)};
  if (config_.fov_degrees > 0) {
    command.arguments.insert(command.arguments.end(), {"--fov", std::to_string(config_.fov_degrees)});
  }
  if (config_.effort != Config().effort)
    command.arguments.insert(command.arguments.end(), {"--effort", config_.effort});
  if (follows) command.arguments.emplace_back("--follow");
  command.arguments.insert(command.arguments.end(), config_.options.begin(), config_.options.end());
  return command;
}

void BuildQueue::start(const std::string& capture) {
  store_.clear_building();
  BuildRecord record = store_.read_build_record(capture);
  ++record.interruptions;  // taken back when the build comes to a verdict
  store_.write_build_record(capture, record);
  build_ = follower_takes_over() ? std::move(follower_) : std::make_unique<BuildChild>(command_for(capture, false));
}

std::optional<BuildProgress> BuildQueue::read_progress() {
  build_->read_errors();
  return build_->read_progress();
}

std::optional<std::string> BuildQueue::take_remark() { return build_->take_remark(); }

BuildEnd BuildQueue::conclude(const std::string& capture, const BuildEnd& end) {
  build_.reset();
  BuildEnd outcome = end;
  if (end.ok) {
    try {
      store_.publish_panorama(capture);
      return outcome;
    } catch (const std::exception& error) {
      outcome = {false, error.what(), true};
    }
  } else {
    // The build knows its file by the name that it has until it is whole.
    const std::string building = store_.building_of(capture).string();
    if (const size_t at = outcome.reason.find(building); at != std::string::npos)
      outcome.reason.replace(at, building.size(), store_.panorama_of(capture).string());
  }
  record_failure(capture, outcome);
  return outcome;
}

// Where another time may go better the next start tries again; else only a command does.
void BuildQueue::record_failure(const std::string& capture, const BuildEnd& end) {
  try {
    store_.clear_building();
    const int interruptions = end.retry ? store_.read_build_record(capture).interruptions : 0;
    store_.write_build_record(capture, {interruptions, false, !end.retry, end.reason});
  } catch (const std::exception& error) {
    log_warning(error.what());
  }
}

void BuildQueue::record_stop(const std::string& capture, bool cancelled) {
  try {
    store_.clear_building();
    BuildRecord record = store_.read_build_record(capture);
    record.interruptions = std::max(0, record.interruptions - 1);
    record.cancelled = cancelled;
    if (cancelled) record.reason = "cancelled";
    store_.write_build_record(capture, record);
  } catch (const std::exception& error) {
    log_warning(std::string(error.what()) + ": the next start builds " + capture + " again");
  }
}

Watches BuildQueue::watches(const std::function<void()>& serve_build) {
  Watches watched;
  const auto add = [&](const BuildChild& build, const std::function<void()>& serve) {
    for (const int fd : {build.progress_fd(), build.error_fd(), build.end_fd()})
      if (fd >= 0) watched.push_back({fd, serve});
  };
  if (build_) add(*build_, serve_build);
  if (follower_) add(*follower_, [this] { serve_follower(); });
  return watched;
}

}  // namespace ldp
