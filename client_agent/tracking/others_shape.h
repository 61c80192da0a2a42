// Holds the shape of others' maps against what the robot's own camera sees of its motion.
#ifndef CORBSLAM_CLIENT_AGENT_TRACKING_OTHERS_SHAPE_H_
#define CORBSLAM_CLIENT_AGENT_TRACKING_OTHERS_SHAPE_H_

#include <cstddef>
#include <deque>
#include <optional>
#include <set>
#include <vector>

#include "client_agent/tracking/frame.h"
#include "slam/exchange/agent_report.h"
#include "slam/geometry/lie.h"
#include "slam/geometry/rigid3.h"
#include "slam/optimisation/pose_optimisation.h"
#include "slam/util/ids.h"

namespace corbslam::client_agent {

// Where its robot was nearly lost a map is bent or torn, and who drives by it is bent along: both
// sides of the tear fit their own pixels (docs/adr/0042-others-distances.md). What two frames of a
// stereo camera see of the same points tells how it moved between them, whatever the map says.
// Sizes are not judged: OthersScale does that. Not thread-safe.
class OthersShape {
 public:
  // Looks at a frame that was tracked. `own` is the robot's local map. Returns the local map of
  // others' that frames are mostly tracked by if it is certain from now on that it is bent; each
  // once.
  std::optional<MapContradiction> Add(const Frame& frame, LocalMapId own);

 private:
  // How the camera moved from one frame to a later one.
  struct Step {
    Rigid3d by_map;                          // later_from_earlier.
    Rigid3d by_sight;                        // Likewise.
    Matrix6d covariance = Matrix6d::Zero();  // Of by_sight, as PoseCovariance gives it.
  };
  void BeginAnew(const Frame& frame, LocalMapId local_map);
  // Ends the step from first_ to the frame, which both see `common`.
  std::optional<MapContradiction> EndStep(const Frame& frame,
                                          const std::vector<PoseObservation>& common);
  // Returns by how much the last so many steps contradict; nullopt where that is not certain.
  std::optional<MapBend> Judge(size_t steps) const;

  LocalMapId local_map_;
  std::optional<Frame> first_;
  int frames_ = 0;  // Since first_.
  std::deque<Step> steps_;
  std::set<LocalMapId> contradicting_;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_TRACKING_OTHERS_SHAPE_H_
