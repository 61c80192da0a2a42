// Finds where a picture was taken, in a part of a map.
#ifndef CORBSLAM_SLAM_VERIFICATION_FRAME_LOCATION_H_
#define CORBSLAM_SLAM_VERIFICATION_FRAME_LOCATION_H_

#include <cstdint>
#include <functional>
#include <tuple>
#include <vector>

#include "slam/exchange/frame_location.h"
#include "slam/verification/camera_check.h"

namespace corbslam {

// Returns whether the search behind `a` got farther than that behind `b`: by the stage, then by the
// counts, the last one first. Both are results or answers of one (LocateFrameResult).
template <typename A, typename B>
bool GotFarther(const A& a, const B& b) {
  return std::tie(a.stage, a.inliers, a.pose_inliers, a.word_matches) >
         std::tie(b.stage, b.inliers, b.pose_inliers, b.word_matches);
}

struct FrameLocationOptions {
  uint64_t seed = 1;
  // Number of keyframes covisible with a candidate whose points take part.
  int neighbours = 5;
  size_t min_features = 50;
  int min_word_matches = 15;
  int min_pose_inliers = 12;
  int min_inliers = 30;
  // Points found must be this many times what is found right beside where they should be, on the
  // mean of four sides: where many keypoints are, some match by chance.
  double min_inliers_to_chance = 4;
  // ... and this share of those that should be in the picture.
  double min_inliers_to_visible = 0.04;
  // A pose is not believed where the points agree with another camera, or with others as well
  // (slam/verification/camera_check.h): it may be metres off, by a covariance of centimetres.
  bool check_camera = true;
  CameraCheckOptions camera = {};
};

// How many of a map's points must be found where a pose has them for it to be believed.
struct InliersNeeded {
  int needed = 0;   // By the rule that asks for most.
  int visible = 0;  // Points that should be in the picture.
  int by_chance = 0;
};
InliersNeeded CountInliersNeeded(const Keyframe& frame, const std::vector<const MapPoint*>& points,
                                 const Rigid3d& camera_from_map,
                                 const FrameLocationOptions& options = {});

// Tries the candidates in turn: features that look like points of the candidate and its neighbours,
// a pose by PnP RANSAC, then a guided search for all points around, twice (as ORB-SLAM relocalises,
// T-RO 2015, V.C), a search beside it for what matches by chance, and with a camera that is free to
// be any (CheckCamera). Ends with the first that is
// located; else says of the one that got farthest how far. Candidates that the view does not hold
// are passed over. `goes_on` (may be null) is asked before each; once it says no, the result so far
// is returned. Deterministic and pure; it takes milliseconds a candidate.
LocateFrameResult LocateFrame(const LocateFrameRequest& request,
                              const FrameLocationOptions& options = {},
                              const std::function<bool(double)>& goes_on = nullptr);

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_VERIFICATION_FRAME_LOCATION_H_
