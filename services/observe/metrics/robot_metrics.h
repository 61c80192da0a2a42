// Counts what a robot does, as metrics: frames, and its sessions with the map store.
#ifndef CORBSLAM_SERVICES_OBSERVE_METRICS_ROBOT_METRICS_H_
#define CORBSLAM_SERVICES_OBSERVE_METRICS_ROBOT_METRICS_H_

#include <prometheus/counter.h>
#include <prometheus/family.h>
#include <prometheus/gauge.h>
#include <prometheus/histogram.h>
#include <prometheus/registry.h>

#include <array>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "services/observe/observed_agent.h"
#include "services/observe/observed_uplink.h"
#include "services/observe/pending_batches.h"

namespace corbslam::services {

// Observes one robot. Thread-safe.
class RobotMetrics : public FrameObserver, public UplinkObserver {
 public:
  // `registry` is not owned and must outlive it.
  explicit RobotMetrics(prometheus::Registry& registry);

  void OnTracked(const client_agent::TrackingResult& result, absl::Duration took) override;
  // Sets how many frames came too fast so far.
  void SetDropped(uint64_t frames);

  void OnOpening() override;
  void OnOpened() override;
  void OnClosed(const absl::Status& reason) override;
  void OnSent(const MapUpdateBatch& batch, absl::Time offered) override;
  void OnAcknowledged(const Acknowledgement& acknowledgement) override;

 private:
  // Metrics of one tracking state; states_ is in the order of TrackingState.
  struct State {
    prometheus::Counter* frames = nullptr;
    prometheus::Gauge* is_now = nullptr;
  };

  void ObserveAcknowledged(const std::vector<absl::Time>& sent);

  std::array<State, 3> states_;
  prometheus::Histogram& frame_durations_;
  prometheus::Counter& keyframes_made_;
  prometheus::Counter& frames_dropped_;
  prometheus::Counter& attempts_;
  prometheus::Counter& reconnects_;
  prometheus::Gauge& connected_;
  prometheus::Histogram& acknowledgements_;

  absl::Mutex mutex_;
  bool was_connected_ ABSL_GUARDED_BY(mutex_) = false;
  PendingBatches<absl::Time> pending_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_OBSERVE_METRICS_ROBOT_METRICS_H_
