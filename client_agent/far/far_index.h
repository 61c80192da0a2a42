// Remembers which places lie in the local maps that have left a robot's memory.
#ifndef CORBSLAM_CLIENT_AGENT_FAR_FAR_INDEX_H_
#define CORBSLAM_CLIENT_AGENT_FAR_FAR_INDEX_H_

#include <Eigen/Core>
#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "slam/place/keyframe_database.h"
#include "slam/util/ids.h"
#include "slam/vocabulary/words.h"

namespace corbslam::client_agent {

// A keyframe that is not in memory.
struct FarPlace {
  KeyframeId id;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  // Of its camera, in the frame of the index.
  std::shared_ptr<const Words> words;                // May be null.
};

// The index has the place of every keyframe, some 50 bytes, and what every few of them look like:
// some 16 KiB each, so that their number is bounded. Not thread-safe.
class FarIndex {
 public:
  // The words of one keyframe in so many are kept at first: neighbours look alike.
  static constexpr size_t kFirstStride = 4;

  explicit FarIndex(size_t max_bags) : max_bags_(max_bags) {}

  // Adds keyframes in the order in which they were made.
  void Add(const std::vector<FarPlace>& places);
  // Forgets a local map.
  void Remove(LocalMapId local_map);
  void Clear();

  struct Near {
    KeyframeId id;
    double distance = 0;  // From the nearest of the points.
  };
  // Returns the keyframes nearest to any of the points, the nearest first: at most `count`, none
  // farther than `radius`. It looks at every keyframe.
  std::vector<Near> Nearest(std::span<const Eigen::Vector3d> points, double radius,
                            size_t count) const;

  // Returns where the keyframe is that looks most like the bag, if it does at least so much.
  std::optional<Eigen::Vector3d> Recognise(const BagOfWords& bag, double least_score) const;

  size_t keyframes() const { return centres_.size(); }
  size_t bags() const { return bags_.size(); }

 private:
  // Drops the bag of every second of the keyframes.
  void Thin();

  const size_t max_bags_;
  size_t stride_ = kFirstStride;
  size_t added_ = 0;
  std::map<KeyframeId, Eigen::Vector3d> centres_;
  KeyframeDatabase bags_;
  std::vector<KeyframeId> with_bag_;  // In the order in which they were added.
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_FAR_FAR_INDEX_H_
