// Chooses which keyframes of earlier local maps a robot should have in memory.
#ifndef CORBSLAM_CLIENT_AGENT_FAR_FAR_CHOICE_H_
#define CORBSLAM_CLIENT_AGENT_FAR_FAR_CHOICE_H_

#include <Eigen/Core>
#include <cstddef>
#include <map>
#include <optional>
#include <vector>

#include "client_agent/far/far_index.h"

namespace corbslam::client_agent {

struct FarReach {
  // Keyframes come within this distance, in the local map's units...
  double radius = 50;
  // ... and so many at most, the nearest.
  size_t max_keyframes = 50;
};

struct FarChoice {
  // By local map, the nearest first.
  std::map<LocalMapId, std::vector<KeyframeId>> bring;
  std::vector<KeyframeId> take_out;

  bool IsEmpty() const { return bring.empty() && take_out.empty(); }
};

// Decides when keyframes come and go, so that none goes to and fro: a choice holds until the robot
// has gone on by a part of its reach. Not thread-safe.
class FarChooser {
 public:
  explicit FarChooser(const FarReach& reach) : reach_(reach) {}

  // Another local map is in use: what is near comes anew.
  void Restart() { at_.reset(); }
  void SetMaxKeyframes(size_t count) { reach_.max_keyframes = count; }
  const FarReach& reach() const { return reach_; }

  // Returns what is to change for a robot at `centre` that has `told`. `recognised` is a place that
  // looks like where it is; a new one is at once a reason to choose anew, and `anew` is, too.
  FarChoice Choose(const FarIndex& index, const std::map<KeyframeId, std::vector<MapPointId>>& told,
                   const Eigen::Vector3d& centre, const std::optional<Eigen::Vector3d>& recognised,
                   bool anew);

 private:
  FarReach reach_;
  // Where the robot was at the last choice, and how far it may go until the next.
  std::optional<Eigen::Vector3d> at_;
  double step_ = 0;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_FAR_FAR_CHOICE_H_
