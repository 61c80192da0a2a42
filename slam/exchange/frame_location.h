// The question where a picture was taken, and its answer.
#ifndef CORBSLAM_SLAM_EXCHANGE_FRAME_LOCATION_H_
#define CORBSLAM_SLAM_EXCHANGE_FRAME_LOCATION_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "slam/camera/camera.h"
#include "slam/camera/recorded_camera.h"
#include "slam/features/keypoint.h"
#include "slam/geometry/lie.h"
#include "slam/geometry/rigid3.h"
#include "slam/map/map.h"
#include "slam/util/ids.h"

namespace corbslam {

// How far a search got: a later stage compares greater.
enum class LocateStage {
  kFewFeatures,   // The picture has fewer features than a place is told by.
  kNoCandidates,  // No keyframe looks like it.
  kFewMatches,    // Too few of its features look like a candidate's.
  kNoPose,        // Too few of these agree on a pose.
  kFewInliers,    // Too few of the map's points are where the pose has them.
  // There is a pose, and it would be elsewhere with another camera that the points allow as well.
  kCameraInDoubt,
  kOutsidePrior,  // There is a pose, and it is not where it may be.
  kLocated,
};
// Returns "FEW_FEATURES", "LOCATED" and so on.
std::string ToString(LocateStage stage);

struct LocateFrameRequest {
  uint64_t base_revision = 0;
  // What is to be seen in the picture, as a keyframe without pose, points or a place in the graph:
  // its payload (with descriptors) and its words, of which the direct index is used.
  Keyframe frame;
  // The candidates and what is covisible with them, with their points; all in one frame.
  Map view;
  struct Candidate {
    KeyframeId id;
    int shared_words = 0;
  };
  std::vector<Candidate> candidates;  // Best first.
  std::string mission = {};           // As VerifyOverlapRequest has it.
};

struct LocateFrameResult {
  uint64_t base_revision = 0;
  LocateStage stage = LocateStage::kNoCandidates;
  // How far the best candidate got: features that look like one of the map's points, those that
  // agree on a pose, and points found once all around had been looked for.
  int word_matches = 0;
  int pose_inliers = 0;
  int inliers = 0;
  // Set from kFewInliers on: how many inliers were needed, how many of the points around should
  // have been in the picture, and how many of them chance finds.
  int inliers_needed = 0;
  int visible_points = 0;
  int chance_inliers = 0;
  // These are set with kLocated, in the view's frame; no covariance where the points don't
  // determine the pose (InMapAxes: of the camera's position along, its rotation about the map's
  // axes). It holds whatever camera took the picture, and not only for the frame's own.
  Rigid3d camera_from_map;
  std::optional<Matrix6d> covariance;
  // With kFewInliers: the points agree, with a camera like this one and not with the picture's own:
  // its focal length, centre, lens or baseline is another's.
  std::optional<Camera> fitting_camera;
  // Keyframes that see the inliers, the one that sees most first; at most 10.
  std::vector<KeyframeId> keyframes;
};

// A picture file and the camera that took it.
struct ExtractFeaturesRequest {
  std::string encoded;  // PNG or JPEG, at most 3 MiB.
  RawCamera camera;
  int features = 1000;
};
struct ExtractFeaturesResult {
  Features features;  // In the pixels of `camera`.
  Camera camera;      // Without distortion and without a baseline.
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_EXCHANGE_FRAME_LOCATION_H_
