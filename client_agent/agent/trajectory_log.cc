#include "client_agent/agent/trajectory_log.h"

namespace corbslam::client_agent {

void AppendTrajectory(const std::vector<TrackedFrame>& frames, const GuardedMap& guarded,
                      std::vector<TrajectoryPose>& trajectory) {
  guarded.ReadWithHistory([&](const Map& map, const MapHistory& history) {
    for (const TrackedFrame& frame : frames) {
      if (!guarded.IsOwn(frame.reference)) continue;
      const auto reference = history.CameraFromMap(map, frame.reference);
      if (!reference.has_value()) continue;
      trajectory.push_back({frame.timestamp_ns, guarded.local_map(),
                            reference->Inverse() * frame.reference_from_camera});
    }
  });
}

}  // namespace corbslam::client_agent
