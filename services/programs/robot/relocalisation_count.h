// Counts how often a robot that was lost was found again, and whose map it was found in.
#ifndef CORBSLAM_SERVICES_PROGRAMS_ROBOT_RELOCALISATION_COUNT_H_
#define CORBSLAM_SERVICES_PROGRAMS_ROBOT_RELOCALISATION_COUNT_H_

#include <optional>

#include "client_agent/tracking/tracking_result.h"

namespace corbslam::services {

// Not thread-safe.
class RelocalisationCount {
 public:
  // Takes the next frame's result.
  void Add(const client_agent::TrackingResult& result) {
    const bool is_tracked = result.state == client_agent::TrackingState::kTracking;
    if (is_tracked && was_lost_ && last_map_ == result.local_map) {
      ++all_;
      if (2 * result.foreign_points_matched > result.points_matched) ++by_others_;
    }
    was_lost_ = !is_tracked;
    if (is_tracked) last_map_ = result.local_map;
  }

  // Frames with a pose behind one without, in the local map of the last pose.
  int all() const { return all_; }
  // Of them those whose pose rests on others' map points by more than half.
  int by_others() const { return by_others_; }

 private:
  bool was_lost_ = false;
  std::optional<LocalMapId> last_map_;  // Of the last pose.
  int all_ = 0;
  int by_others_ = 0;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_ROBOT_RELOCALISATION_COUNT_H_
