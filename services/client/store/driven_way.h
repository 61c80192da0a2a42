// Says where robots drove between keyframes: where a straight line stands for the way, and where
// not.
#ifndef CORBSLAM_SERVICES_CLIENT_STORE_DRIVEN_WAY_H_
#define CORBSLAM_SERVICES_CLIENT_STORE_DRIVEN_WAY_H_

#include <Eigen/Core>
#include <map>
#include <vector>

#include "services/client/store/served_mission.h"
#include "slam/geometry/rigid3.h"
#include "slam/util/ids.h"

namespace corbslam::services {

// Where a robot drove, piece by piece: nothing connects one with the next.
using DrivenPath = std::vector<std::vector<Eigen::Vector3d>>;

// Returns the centres of a trajectory's frames, cut where tracking was lost, and where another
// local map, run or island begins.
DrivenPath PiecesOf(const ServedTrajectory& served);

// Returns how far a robot usually went from one keyframe to the next that it made; 0 if nobody
// knows. Of a closed session the store lets most keyframes go: their numbers are missing then, and
// a step over them is shared out.
double UsualStep(const std::map<KeyframeId, Rigid3d>& world_from_camera);

// Returns true if the robot may not have been where a straight line between two keyframes runs:
// they are many usual steps apart, or some and turned against each other, so that a corner lies
// between them. Without a usual step nothing is a gap.
bool IsGap(const Rigid3d& from, const Rigid3d& to, double usual_step);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_CLIENT_STORE_DRIVEN_WAY_H_
