// How the map of one camera begins: with two frames between which it moved aside.
#ifndef CORBSLAM_CLIENT_AGENT_TRACKING_MONOCULAR_START_H_
#define CORBSLAM_CLIENT_AGENT_TRACKING_MONOCULAR_START_H_

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "client_agent/mapping/mapping_queue.h"
#include "client_agent/tracking/frame.h"
#include "slam/monocular/two_view_geometry.h"

namespace corbslam::client_agent {

// The map's frame is that of the first camera, its unit the median depth there.
struct MonocularBeginning {
  Frame first;
  Frame second;  // With its pose, and the depths that were found of its keypoints.
  std::vector<FoundPoint> points;
};

// Holds the first of the two and where its keypoints are by now; what is found no more of it makes
// the newest frame the first. Thread-compatible.
class MonocularStart {
 public:
  explicit MonocularStart(uint64_t seed) : seed_(seed) {}

  // Takes the next frame, which shows enough keypoints. Returns a beginning once the camera has
  // moved enough, and then forgets all.
  std::optional<MonocularBeginning> Add(const Frame& frame);

  // Returns why the last frame gave no beginning.
  TwoViewVerdict verdict() const { return verdict_; }

 private:
  struct Pair {
    uint32_t in_first = 0;
    uint32_t in_second = 0;
  };
  void BeginWith(const Frame& frame);
  // Finds the first frame's keypoints around where they were seen last.
  std::vector<Pair> Match(const Frame& frame);
  std::vector<TwoViewMatch> PixelsOf(const std::vector<Pair>& pairs, const Frame& frame) const;

  const uint64_t seed_;
  std::optional<Frame> first_;
  std::vector<Eigen::Vector2d> last_px_;  // One entry a keypoint of the first frame.
  TwoViewVerdict verdict_ = TwoViewVerdict::kFewMatches;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_TRACKING_MONOCULAR_START_H_
