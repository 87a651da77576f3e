#include "device/capture/frame_writer.h"

#include <sys/eventfd.h>
#include <unistd.h>

#include <utility>

#include "core/photos/images.h"
#include "drivers/interface/errors.h"

namespace ldp {
namespace {

std::string write(const WriteJob& job) {
  try {
    if (!job.file.empty()) write_file(job.folder / job.file, job.bytes);
    if (!job.capture_json.empty()) {
      const auto* const text = reinterpret_cast<const uint8_t*>(job.capture_json.data());
      write_file(job.folder / "capture.json", {text, job.capture_json.size()});
    }
    return {};
  } catch (const std::exception& error) {
    return error.what();
  }
}

}  // namespace

FrameWriter::FrameWriter() : event_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
  if (!event_.is_open()) throw_errno("cannot make an event descriptor");
  thread_ = std::thread([this] { run(); });
}

FrameWriter::~FrameWriter() {
  {
    const std::scoped_lock lock(mutex_);
    ending_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

void FrameWriter::put(WriteJob job) {
  {
    const std::scoped_lock lock(mutex_);
    jobs_.push_back(std::move(job));
    ++pending_;
  }
  wake_.notify_one();
}

std::optional<WriteOutcome> FrameWriter::take() {
  const std::scoped_lock lock(mutex_);
  if (outcomes_.empty()) {
    uint64_t count = 0;
    [[maybe_unused]] const ssize_t got = ::read(event_.get(), &count, sizeof count);
    return std::nullopt;
  }
  WriteOutcome outcome = std::move(outcomes_.front());
  outcomes_.pop_front();
  --pending_;
  return outcome;
}

size_t FrameWriter::pending() const {
  const std::scoped_lock lock(mutex_);
  return pending_;
}

void FrameWriter::run() {
  for (;;) {
    WriteJob job;
    {
      std::unique_lock lock(mutex_);
      wake_.wait(lock, [this] { return ending_ || !jobs_.empty(); });
      if (jobs_.empty()) return;
      job = std::move(jobs_.front());
      jobs_.pop_front();
    }
    WriteOutcome outcome{job.folder, job.file, write(job)};
    {
      const std::scoped_lock lock(mutex_);
      outcomes_.push_back(std::move(outcome));
    }
    const uint64_t one = 1;
    [[maybe_unused]] const ssize_t put = ::write(event_.get(), &one, sizeof one);
  }
}

}  // namespace ldp
