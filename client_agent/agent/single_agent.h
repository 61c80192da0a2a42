// The Agent: composes sensor, tracking, mapping, loop closing and memory management.
#ifndef CORBSLAM_CLIENT_AGENT_AGENT_SINGLE_AGENT_H_
#define CORBSLAM_CLIENT_AGENT_AGENT_SINGLE_AGENT_H_

#include <memory>
#include <random>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "client_agent/agent/agent.h"
#include "client_agent/agent/local_map_session.h"
#include "client_agent/link/store_link.h"
#include "client_agent/source_checks/input_watch.h"

namespace corbslam {

class SingleAgent : public Agent {
 public:
  SingleAgent(const AgentOptions& options, std::unique_ptr<Sensor> sensor,
              const SensorCalibration& calibration, const RecordedCamera& recorded_camera,
              std::shared_ptr<const Vocabulary> vocabulary, Uplink* uplink,
              std::unique_ptr<Spool> spool);
  ~SingleAgent() override;

  absl::StatusOr<TrackingResult> Track(const SensorImages& images) override;
  void BeginLocalMap() override;
  void Step() override;
  absl::Status Finish(absl::Duration timeout) override;
  AgentStatus GetStatus() const override;
  std::optional<Similarity3d> GlobalFromLocal() const override;
  AgentTimings GetTimings() const override;
  std::vector<TrajectoryPose> LocalTrajectory() const override;
  Map CopyMap() const override;

 private:
  void OpenLocalMap();
  void Watch(const Features& features);
  void Record(const TrackingResult& result, double tracking_ms);
  LocalMapSession& current() const { return *current_session_; }
  std::vector<const LocalMapSession*> Sessions() const;

  const AgentOptions options_;
  const bool is_stereo_;
  const absl::Time created_;
  const std::unique_ptr<Sensor> sensor_;
  InputWatch input_watch_;
  const std::shared_ptr<const Camera> camera_;
  const std::shared_ptr<const Vocabulary> vocabulary_;
  std::mt19937_64 random_;
  LocalMapSession* current_session_ = nullptr;

  mutable absl::Mutex mutex_;
  // The last one is in use; the others are kept for their trajectories and what is still to send.
  std::vector<std::unique_ptr<LocalMapSession>> sessions_ ABSL_GUARDED_BY(mutex_);
  std::vector<TrackedFrame> tracked_frames_ ABSL_GUARDED_BY(mutex_);
  AgentStatus status_ ABSL_GUARDED_BY(mutex_);
  std::vector<double> tracking_ms_ ABSL_GUARDED_BY(mutex_);
  int64_t points_matched_ ABSL_GUARDED_BY(mutex_) = 0;
  int64_t foreign_points_matched_ ABSL_GUARDED_BY(mutex_) = 0;
  // Reads the sessions' maps: goes before them.
  std::unique_ptr<StoreLink> link_;
};

}  // namespace corbslam

#endif  // CORBSLAM_CLIENT_AGENT_AGENT_SINGLE_AGENT_H_
