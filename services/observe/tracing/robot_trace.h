// Traces a robot's part of its keyframes' way.
#ifndef CORBSLAM_SERVICES_OBSERVE_TRACING_ROBOT_TRACE_H_
#define CORBSLAM_SERVICES_OBSERVE_TRACING_ROBOT_TRACE_H_

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "services/observe/observed_agent.h"
#include "services/observe/observed_uplink.h"
#include "services/observe/pending_batches.h"
#include "services/observe/tracing/trace_file.h"

namespace corbslam::services {

// Writes the robot's events. When a keyframe was captured is known if this process has tracked its
// frame. Thread-safe.
class RobotTrace : public FrameObserver, public UplinkObserver {
 public:
  // `file` is not owned and must outlive it.
  RobotTrace(TraceFile* file, std::string mission, std::string agent)
      : file_(*file), mission_(std::move(mission)), agent_(std::move(agent)) {}

  void OnFrame(int64_t timestamp_ns) override;
  void OnTracked(const client_agent::TrackingResult& result, absl::Duration took) override;
  void OnSent(const MapUpdateBatch& batch, absl::Time offered) override;
  void OnAcknowledged(const Acknowledgement& acknowledgement) override;
  void OnShared(const SharedUpdate& update) override;

 private:
  KeyframeEvent Event(absl::string_view name, KeyframeId keyframe, absl::Time time) const {
    return {name, keyframe, time, mission_, agent_};
  }
  void NoteAcknowledged(const std::vector<std::vector<KeyframeId>>& batches);

  TraceFile& file_;
  const std::string mission_;
  const std::string agent_;
  absl::Mutex mutex_;
  // When frames that became keyframes, or may, came from the camera, by their time in the sequence.
  std::map<int64_t, absl::Time> captured_ ABSL_GUARDED_BY(mutex_);
  PendingBatches<std::vector<KeyframeId>> pending_ ABSL_GUARDED_BY(mutex_);
  // Keyframes whose global pose was told.
  std::set<KeyframeId> posed_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_OBSERVE_TRACING_ROBOT_TRACE_H_
