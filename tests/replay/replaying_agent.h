// A robot that only uploads: streams recorded batches at a pace, resumes by itself, and keeps a
// ledger of what was acknowledged when.
#ifndef CORBSLAM_TESTS_REPLAY_REPLAYING_AGENT_H_
#define CORBSLAM_TESTS_REPLAY_REPLAYING_AGENT_H_

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "slam/exchange/uplink.h"
#include "tests/replay/recorded_uploads.h"

namespace corbslam::tests {

struct ReplayOptions {
  std::string mission;
  std::string agent;
  // Local map of the first lap; each further lap has the next id.
  LocalMapId local_map;
  int laps = 1;
  // Full keyframes a second; 0: as fast as they are acknowledged.
  double keyframes_per_s = 0;
  // With a pace, the robot starts so much later than it is constructed.
  absl::Duration start_after = absl::ZeroDuration();
  // At most so many batches are sent and not acknowledged.
  size_t max_waiting = 16;
  // The next session is opened so much later after one ended.
  absl::Duration retry_after = absl::Milliseconds(50);
  // They are called, where set, with each batch as it is sent and when it was due (see the ledger),
  // and with what comes back; on threads of the agent's, without locks.
  std::function<void(const MapUpdateBatch& batch, absl::Time due)> on_sent = nullptr;
  std::function<void(const SharedUpdate& update)> on_shared = nullptr;
};

// Returns the options of robot `index` of `count` in one mission, each with a name and a local map
// of its own. Robots don't see their frames at the same moment: with a pace they start out of step.
ReplayOptions OptionsOfOne(const std::string& mission, size_t index, size_t count,
                           double keyframes_per_s);

struct ReplayLedger {
  uint64_t acknowledged = 0;  // Number of batches over all laps.
  uint64_t keyframes = 0;     // Number of keyframes in those.
  int sessions = 0;
  // The delay of one batch with keyframes: when it was due (without a pace: sent), and when it was
  // acknowledged.
  struct Delay {
    absl::Time due;
    absl::Time acknowledged;

    double ms() const { return absl::ToDoubleMilliseconds(acknowledged - due); }
  };
  std::vector<Delay> delays;
};

// Adds the ledger's delays to `delays_ms`.
void AppendDelays(const ReplayLedger& ledger, std::vector<double>& delays_ms);

// Streams from its construction on, on a thread of its own. Thread-safe.
class ReplayingAgent : private UplinkListener {
 public:
  // `uploads` (not owned) must outlive it.
  ReplayingAgent(const ReplayOptions& options, const RecordedUploads* uploads,
                 std::unique_ptr<Uplink> uplink);
  // Stops wherever it is.
  ~ReplayingAgent() override;

  // Returns OK when all was acknowledged; DEADLINE_EXCEEDED, or why the store does not want to hear
  // more.
  absl::Status WaitUntilDone(absl::Duration timeout);
  // Sends no more batches.
  void Stop();
  ReplayLedger ledger() const;
  uint64_t bytes_up() const { return uplink_->bytes_up(); }
  uint64_t bytes_down() const { return uplink_->bytes_down(); }

 private:
  void OnSessionOpened(const SessionGrant& grant) override;
  void OnAcknowledged(const Acknowledgement& acknowledgement) override;
  void OnShared(SharedUpdate update) override;
  void OnExactPlacesWanted() override {}
  void OnSessionClosed(const absl::Status& reason) override;

  void Run();
  // Batches are counted over all laps, from 1.
  LocalMapId LocalMapOf(uint64_t count) const;
  const MapUpdateBatch& BatchOf(uint64_t count) const;
  uint64_t CountOf(const Acknowledgement& acknowledgement) const;
  uint64_t KeyframesUpTo(uint64_t count) const;
  uint64_t batches() const { return uploads_.size() * static_cast<uint64_t>(options_.laps); }
  absl::Time DueTime(uint64_t count) const;
  void TakeAcknowledgement(uint64_t count) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void MakeSession();
  void SendNext();
  bool HasEnded() const ABSL_SHARED_LOCKS_REQUIRED(mutex_) {
    return stopped_ || ledger_.acknowledged >= batches() || !failure_.ok();
  }

  const ReplayOptions options_;
  const RecordedUploads& uploads_;
  const absl::Time start_;
  // Number of keyframes of one lap, up to and with batch i.
  std::vector<uint64_t> keyframes_up_to_ = {0};

  mutable absl::Mutex mutex_;
  ReplayLedger ledger_ ABSL_GUARDED_BY(mutex_);
  bool stopped_ ABSL_GUARDED_BY(mutex_) = false;
  bool has_session_ ABSL_GUARDED_BY(mutex_) = false;
  bool is_opening_ ABSL_GUARDED_BY(mutex_) = false;
  absl::Time open_at_ ABSL_GUARDED_BY(mutex_) = absl::InfinitePast();
  uint64_t sent_ ABSL_GUARDED_BY(mutex_) = 0;
  std::map<uint64_t, absl::Time> waiting_ ABSL_GUARDED_BY(mutex_);
  absl::Status failure_ ABSL_GUARDED_BY(mutex_);

  const std::unique_ptr<Uplink> uplink_;
  std::thread thread_;
};

}  // namespace corbslam::tests

#endif  // CORBSLAM_TESTS_REPLAY_REPLAYING_AGENT_H_
