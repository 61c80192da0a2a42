// Reads frames in order on a thread of its own, a few ahead of whoever takes them.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_READ_AHEAD_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_READ_AHEAD_H_

#include <cstddef>
#include <deque>
#include <functional>
#include <optional>
#include <thread>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "client_agent/source/frame_stream.h"

namespace corbslam::client_agent {

// The reader is thread-safe, though frames go to whoever asks first.
class ReadAhead {
 public:
  // `read(i)` is called once for each i from 0 on, in order, from one thread, until it says by
  // nullopt that there is no such frame.
  using Read = std::function<absl::StatusOr<std::optional<StreamFrame>>(size_t)>;

  ReadAhead(size_t capacity, Read read);
  ~ReadAhead();
  ReadAhead(const ReadAhead&) = delete;
  ReadAhead& operator=(const ReadAhead&) = delete;

  // Waits for the next frame; returns nullopt after the last. An error belongs to one frame: the
  // next call gives the one behind it.
  absl::StatusOr<std::optional<StreamFrame>> Next();

 private:
  void Run();
  bool HasRoom() const ABSL_SHARED_LOCKS_REQUIRED(mutex_);
  bool HasSomething() const ABSL_SHARED_LOCKS_REQUIRED(mutex_);

  const size_t capacity_;
  const Read read_;
  absl::Mutex mutex_;
  std::deque<absl::StatusOr<StreamFrame>> ready_ ABSL_GUARDED_BY(mutex_);
  bool finished_ ABSL_GUARDED_BY(mutex_) = false;  // True: nothing will be added.
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::thread thread_;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_READ_AHEAD_H_
