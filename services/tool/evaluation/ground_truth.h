// Reads where a sequence's camera really was. Nothing else under `corbslam run` opens ground truth.
#ifndef CORBSLAM_SERVICES_TOOL_EVALUATION_GROUND_TRUTH_H_
#define CORBSLAM_SERVICES_TOOL_EVALUATION_GROUND_TRUTH_H_

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client_agent/source/source_spec.h"
#include "slam/camera/recorded_camera.h"
#include "slam/evaluation/trajectory.h"

namespace corbslam::services {

struct GroundTruth {
  // Poses of the camera as recorded; sorted, no time twice.
  Trajectory trajectory;
  std::string path;  // Empty if the sequence is simulated.
  // Number of rows that are not finite or repeat a time.
  size_t rows_left_out = 0;
  // A sentence for each kind of what was left out or put in order.
  std::vector<std::string> notes;
};

// Reads the truth that lies beside a recorded sequence, the first of:
//
//   KITTI: DIR/poses.txt, DIR/../../poses/NN.txt
//   TUM and its like: DIR/groundtruth.txt, ICL-NUIM's DIR/*.gt.freiburg, 7-Scenes'
//   DIR/frame-000000.pose.txt
//   EuRoC and its like: state_groundtruth_estimate0/data.csv, TUM-VI's mocap0/data.csv; both are of
//   the body, and cam0's T_BS makes them the camera's
//
// Returns nullopt if there is none. The truth of a simulation is where its camera is.
// INVALID_ARGUMENT names file and line; a file without poses is one, too.
absl::StatusOr<std::optional<GroundTruth>> ReadGroundTruth(const client_agent::SourceSpec& source);

// Returns the same poses for another frame. FAILED_PRECONDITION if the sequence's calibration
// doesn't know that frame.
absl::StatusOr<Trajectory> TruthOf(const GroundTruth& truth, const client_agent::SourceSpec& source,
                                   PosesOf poses_of);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_EVALUATION_GROUND_TRUTH_H_
