// Decides when a robot of bounded memory lets go of what others made and is not near any more.
#ifndef CORBSLAM_CLIENT_AGENT_AGENT_SHARE_SHEDDING_H_
#define CORBSLAM_CLIENT_AGENT_AGENT_SHARE_SHEDDING_H_

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace corbslam::client_agent {

struct SheddingLimits {
  // Bytes that the local map in use may take; 0: no bound.
  uint64_t max_map_bytes = 0;
  // Others' share of them at most: beyond, others' far parts go before the robot's own do.
  double max_share = 0.5;
  // How far from the robot others' keyframes come, in metres, and how far at least.
  double radius_m = 50;
  double min_radius_m = 5;
};

struct SheddingEvidence {
  uint64_t map_bytes = 0;
  size_t own_keyframes = 0;
  size_t foreign_keyframes = 0;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  // The robot, in its local map.
  int64_t timestamp_ns = 0;
};

// Not thread-safe.
class ShareShedder {
 public:
  explicit ShareShedder(const SheddingLimits& limits)
      : limits_(limits), radius_m_(limits.radius_m) {}

  void SetMaxMapBytes(uint64_t bytes) { limits_.max_map_bytes = bytes; }

  // Returns within what radius others' keyframes are to be told anew, which lets go of all others;
  // nullopt: not now. Where the robot has not gone on since it asked last, there is more near it
  // than it may hold, and the radius shrinks; it grows again as the robot goes on.
  std::optional<double> Judge(const SheddingEvidence& evidence);
  // Returns whether what was asked for may still be on its way, so that the map is no reason yet
  // to let go of own parts.
  bool IsUnderWay(int64_t timestamp_ns) const;

 private:
  struct Asked {
    Eigen::Vector3d centre;
    int64_t timestamp_ns = 0;
  };
  SheddingLimits limits_;
  double radius_m_;
  std::optional<Asked> asked_;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_AGENT_SHARE_SHEDDING_H_
