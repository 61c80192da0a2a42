// Makes batches of robots that drive the same ring: maps of any size without pictures.
#ifndef CORBSLAM_TESTS_BENCH_SYNTHETIC_FLEET_H_
#define CORBSLAM_TESTS_BENCH_SYNTHETIC_FLEET_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <random>
#include <vector>

#include "slam/exchange/fusion_worker.h"
#include "slam/exchange/map_update.h"

namespace corbslam::tests {

struct FleetOptions {
  size_t robots = 10;
  // Places of the ring, a metre apart; a keyframe is made at each.
  size_t places = 1000;
  // A robot begins so many places behind the one after it.
  size_t spacing = 25;
  // Number of things to see at a place. The first robot that comes makes points of all; a robot
  // that comes later sees a third of these as what others made, and makes points of its own of the
  // rest.
  size_t points_per_place = 150;
  size_t features = 1000;
  uint64_t seed = 1;
};

// Robots drive one behind the other. Each has one local map, whose frame is the ring's own.
class SyntheticFleet {
 public:
  explicit SyntheticFleet(const FleetOptions& options);

  size_t robots() const { return robots_.size(); }
  LocalMapId local_map(size_t robot) const { return robots_[robot].local_map; }
  // Returns the robot's next keyframe: with new points, what it sees of this place and of those
  // before, the last keyframes a little elsewhere, and points that replace one another.
  MapUpdateBatch NextBatch(size_t robot);
  // Returns the number of all points made so far.
  size_t point_count() const { return points_; }

 private:
  struct Robot {
    LocalMapId local_map;
    size_t begin = 0;
    uint32_t keyframes = 0;
    uint32_t points = 0;
    // Points by place and by the thing to see; invalid where the robot has not been.
    std::vector<std::vector<MapPointId>> seen;
    std::deque<LightKeyframe> newest;
  };

  static constexpr size_t kPlacesInSight = 5;

  size_t PlaceOf(const Robot& robot, uint32_t keyframe) const {
    return (robot.begin + keyframe) % options_.places;
  }
  Rigid3d CameraFromRing(size_t place) const;
  Eigen::Vector3d PositionOf(size_t place, size_t i) const;
  Descriptor DescriptorOf(size_t place, size_t i) const;
  std::shared_ptr<const KeyframePayload> MakePayload(const Robot& robot, KeyframeId id);
  void SeePlace(size_t place, KeyframeId reference, Robot& robot, MapUpdateBatch& batch);
  void Observe(KeyframeId keyframe, const Robot& robot, MapUpdateBatch& batch) const;
  void ReplaceSome(size_t place, Robot& robot, MapUpdateBatch& batch);

  const FleetOptions options_;
  const std::shared_ptr<const Camera> camera_;
  std::mt19937_64 random_;
  std::vector<Robot> robots_;
  // Points that the first robot made of each place.
  std::vector<std::vector<MapPointId>> first_seen_;
  size_t points_ = 0;
};

// Believes what the views say, which is the truth of a SyntheticFleet: near keyframes overlap,
// islands join where they lie, and there is nothing to adjust. Thread-safe.
class BelievingWorker : public FusionWorker {
 public:
  absl::StatusOr<VerifyOverlapResult> VerifyOverlap(const VerifyOverlapRequest& request,
                                                    const ProgressCallback& progress) override;
  absl::StatusOr<FuseMapsResult> FuseMaps(const FuseMapsRequest& request,
                                          const ProgressCallback& progress) override;
  absl::StatusOr<AdjustBundleResult> AdjustBundle(const AdjustBundleRequest& request,
                                                  const ProgressCallback& progress) override;
};

}  // namespace corbslam::tests

#endif  // CORBSLAM_TESTS_BENCH_SYNTHETIC_FLEET_H_
