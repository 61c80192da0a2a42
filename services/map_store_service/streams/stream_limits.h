// Limits how many streams a server keeps open, for whom, and how much unfinished work it holds for
// its callers.
#ifndef CORBSLAM_SERVICES_MAP_STORE_SERVICE_STREAMS_STREAM_LIMITS_H_
#define CORBSLAM_SERVICES_MAP_STORE_SERVICE_STREAMS_STREAM_LIMITS_H_

#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/synchronization/mutex.h"
#include "services/convert/limits.h"
#include "services/server/task_pool.h"

namespace corbslam::services {

struct StreamLimitOptions {
  // Most streams that are open at one time: of everybody, from one host, and of one agent (older
  // ones that are about to end count).
  size_t max_streams = 1000;
  size_t max_streams_per_host = 250;
  size_t max_streams_per_agent = 8;
  // Most bytes of one message, of a batch that comes in parts, and of all unfinished batches
  // together.
  size_t max_message_bytes = 4u << 20;
  size_t max_batch_bytes = 16u << 20;
  size_t max_unfinished_bytes = 512u << 20;
  // Seconds within which the first message must come, and the next part of an unfinished batch or
  // backup.
  double open_timeout_s = 30;
  double part_timeout_s = 300;
  // Most calls for which no thread is free yet.
  size_t max_waiting_calls = TaskPool::kMaxWaitingCalls;

  // Returns INVALID_ARGUMENT, naming the field, for a limit that is out of its range.
  absl::Status Validate() const;
};

// Returns "ipv4:10.0.0.7:4711" without the port.
std::string HostOfPeer(absl::string_view peer);

// Returns why a stream may not stay open; OK: it may. It outlives its call.
using StayCheck = std::function<absl::Status()>;

// Counts streams and their bytes. Errors are RESOURCE_EXHAUSTED, naming whose limit and what it is.
// Thread-safe.
class StreamLimits {
 public:
  explicit StreamLimits(const StreamLimitOptions& options) : options_(options) {}

  // One open stream; it counts until this is destroyed. Not thread-safe.
  class Ticket {
   public:
    Ticket(StreamLimits* limits, std::string host, StayCheck may_stay)
        : limits_(*limits), host_(std::move(host)), may_stay_(std::move(may_stay)) {}
    ~Ticket();
    Ticket(const Ticket&) = delete;
    Ticket& operator=(const Ticket&) = delete;

    // Sets a function that is called with the reason when the stream is to end, perhaps more than
    // once; it must not end this ticket itself. An error: it is to end already.
    absl::Status SetCloseListener(std::function<void(const absl::Status&)> listener);
    // Counts the stream for this agent ("missions/m/agents/a").
    absl::Status Name(const std::string& agent);
    // Counts so many bytes more that the stream holds, of a batch that is not whole, or of what the
    // store works on.
    absl::Status Hold(size_t bytes);
    // Counts so many of them no more.
    void Release(size_t bytes);
    // Counts none of them any more: the batch is whole, or given up.
    void ReleaseAll();

   private:
    friend class StreamLimits;

    StreamLimits& limits_;
    const std::string host_;
    const StayCheck may_stay_;                           // Null: it may.
    std::function<void(const absl::Status&)> on_close_;  // Guarded by the limits' mutex.
    std::string agent_;
    size_t held_ = 0;
  };

  // Lets a stream in; `peer` is as gRPC spells it. UNAVAILABLE after Close.
  absl::StatusOr<std::unique_ptr<Ticket>> Enter(absl::string_view peer,
                                                StayCheck may_stay = nullptr);

  // Tells the listeners that the server is about to stop, and lets no more streams in.
  void Close();
  // Asks of each stream with a listener whether it may stay, and tells those that may not why.
  void EndWhoMayNotStay();

  const StreamLimitOptions& options() const { return options_; }
  size_t open_streams() const;
  size_t unfinished_bytes() const;

 private:
  using Counts = std::map<std::string, size_t>;
  static void Decrease(const std::string& key, Counts& counts);

  const StreamLimitOptions options_;
  mutable absl::Mutex mutex_;
  bool closed_ ABSL_GUARDED_BY(mutex_) = false;
  std::set<Ticket*> tickets_ ABSL_GUARDED_BY(mutex_);
  size_t unfinished_bytes_ ABSL_GUARDED_BY(mutex_) = 0;
  Counts of_host_ ABSL_GUARDED_BY(mutex_);
  Counts of_agent_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_MAP_STORE_SERVICE_STREAMS_STREAM_LIMITS_H_
