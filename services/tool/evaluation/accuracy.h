// Compares what the store serves with the truth.
#ifndef CORBSLAM_SERVICES_TOOL_EVALUATION_ACCURACY_H_
#define CORBSLAM_SERVICES_TOOL_EVALUATION_ACCURACY_H_

#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client_agent/source/source_spec.h"
#include "services/client/store/served_mission.h"
#include "services/programs/robot/told_poses.h"
#include "services/tool/evaluation/ground_truth.h"
#include "slam/evaluation/trajectory.h"
#include "slam/evaluation/trajectory_error.h"

namespace corbslam::services {

// Holds a robot's trajectories. Their poses are of the camera as recorded, as the truth's are.
struct RobotPaths {
  std::string name;
  client_agent::SourceSpec source;
  ServedTrajectory local;
  ServedTrajectory global;
  ToldPaths told = {};
};

// RMSE of poses as they were told, each under an alignment of its own.
struct ToldAccuracy {
  // In the global frame; of a robot that was told of none, in its local map's.
  std::optional<double> ate_m;
  // In the local map's frame, of the frames before the robot knew where the global one is.
  std::optional<double> ate_before_m;
};

struct RobotAccuracy {
  // RMSE of the local trajectory under an alignment of its own; of the global one where tracking
  // began more than one local map.
  std::optional<double> ate_m;
  std::optional<double> ate_from_frame_m;
  // RMSE of the global trajectory under an alignment of its own.
  std::optional<double> ate_global_m;
  ToldAccuracy told;
  // Relative error of the trajectory that ate_m is of.
  std::optional<RelativeError> relative;
  // The same by the segments' length.
  std::vector<LengthError> by_length;
  // The error of each pose: of the global trajectory under the one alignment of all robots, if the
  // robot lies in the global frame; else of the trajectory that ate_m is of, under its own.
  std::vector<PoseError> profile;
  bool is_profile_global = false;
};

struct FusedAccuracy {
  // Error of all robots under one alignment; set only if all local maps are connected to the global
  // frame and all truths are in one frame: of one sequence, of one simulated world, or of sequences
  // that say so (SourceSpec::truth_frame).
  std::optional<AbsoluteError> all;
  std::optional<AbsoluteError> from_frame;
  // The same as `all`, but under one similarity: the error that is left when the map's size does
  // not count.
  std::optional<AbsoluteError> without_scale;
  // Error over the path that robots of one sequence drove together; for several sequences in one
  // world the mean over all segments.
  std::optional<RelativeError> relative;
  // The alignment of whatever lies in the global frame, for pictures, and the truth of that time.
  std::optional<Similarity3d> truth_from_global;
  std::optional<Trajectory> truth;
};

struct Accuracy {
  std::vector<RobotAccuracy> robots;  // In the order of the paths.
  FusedAccuracy fused;
};

// Returns a name that is equal for sources whose cameras go one way by one clock, though they may
// take their pictures at other moments of it and through other lenses: the truth of one is where
// the others were, too.
std::string WayOf(const client_agent::SourceSpec& source);

// Returns the errors as told of a robot that drove alone, in its own local map's frame, of those
// frames which `company`, the same robot in company, told in the global frame, and before.
absl::StatusOr<ToldAccuracy> ComputeToldAccuracy(const RobotPaths& robot, const ToldPaths& company,
                                                 Alignment alignment);

// Computes the errors; `from_frame` is a frame's number in its sequence.
absl::StatusOr<Accuracy> ComputeAccuracy(const std::vector<RobotPaths>& robots, size_t from_frame,
                                         Alignment alignment);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_EVALUATION_ACCURACY_H_
