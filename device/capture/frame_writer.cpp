#include "device/capture/frame_writer.h"

#include <sys/eventfd.h>
#include <unistd.h>

#include <new>
#include <utility>

#include "core/base/files.h"
#include "drivers/interface/errors.h"

namespace ldp {
namespace {

// Short enough to be kept without memory.
constexpr const char* kNoMemory = "no memory left";

void write(const WriteJob& job) {
  if (!job.file.empty()) write_file(job.folder / job.file, job.bytes);
  if (!job.capture_json.empty()) write_file(job.folder / "capture.json", job.capture_json);
}

}  // namespace

// Nothing leaves it, or the thread would end the program: neither what went wrong, nor what telling of it needs.
void FrameWriter::write(Entry& entry) noexcept {
  try {
    try {
      ldp::write(entry.job);
    } catch (const std::bad_alloc&) {
      throw;
    } catch (const std::exception& error) {
      entry.code = code_of(error);
      entry.error = error.what();
    }
  } catch (const std::bad_alloc& error) {
    entry.code = code_of(error);
    entry.error = kNoMemory;
  }
}

FrameWriter::FrameWriter() : shared_(std::make_shared<Shared>()) {
  shared_->event.reset(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC));
  if (!shared_->event.is_open()) throw_errno("cannot make an event descriptor");
  try {
    thread_ = std::thread([shared = shared_] { run(*shared); });
  } catch (const std::system_error& error) {
    throw_errno("cannot start the thread that stores frames", error.code().value());
  }
}

FrameWriter::~FrameWriter() {
  {
    const std::scoped_lock lock(shared_->mutex);
    shared_->ending = true;
  }
  shared_->wake.notify_one();
  if (thread_.joinable()) thread_.join();
}

void FrameWriter::put(WriteJob job) {
  {
    const std::scoped_lock lock(shared_->mutex);
    shared_->jobs.push_back({std::move(job), {}, {}});
    ++shared_->pending;
  }
  shared_->wake.notify_one();
}

void FrameWriter::forget(const std::filesystem::path& folder) {
  const std::scoped_lock lock(shared_->mutex);
  shared_->pending -= std::erase_if(shared_->jobs, [&](const Entry& entry) { return entry.job.folder == folder; });
}

void FrameWriter::leave() {
  const std::scoped_lock lock(shared_->mutex);
  shared_->jobs.clear();
  if (thread_.joinable()) thread_.detach();
}

std::optional<WriteOutcome> FrameWriter::take() {
  const std::scoped_lock lock(shared_->mutex);
  if (shared_->done.empty()) {
    uint64_t count = 0;
    [[maybe_unused]] const ssize_t got = ::read(shared_->event.get(), &count, sizeof count);
    return std::nullopt;
  }
  Entry& entry = shared_->done.front();
  WriteOutcome outcome{std::move(entry.job.folder), std::move(entry.job.file), std::move(entry.error), entry.code};
  shared_->done.pop_front();
  --shared_->pending;
  return outcome;
}

size_t FrameWriter::pending() const {
  const std::scoped_lock lock(shared_->mutex);
  return shared_->pending;
}

void FrameWriter::run(Shared& shared) {
  for (;;) {
    std::list<Entry> current;
    {
      std::unique_lock lock(shared.mutex);
      shared.wake.wait(lock, [&] { return shared.ending || !shared.jobs.empty(); });
      if (shared.jobs.empty()) return;
      current.splice(current.begin(), shared.jobs, shared.jobs.begin());
    }
    Entry& entry = current.front();
    write(entry);
    std::vector<uint8_t>().swap(entry.job.bytes);
    {
      const std::scoped_lock lock(shared.mutex);
      shared.done.splice(shared.done.end(), current);
    }
    const uint64_t one = 1;
    [[maybe_unused]] const ssize_t put = ::write(shared.event.get(), &one, sizeof one);
  }
}

}  // namespace ldp
