// Decides what the mapper takes out of the map again.
#ifndef CORBSLAM_CLIENT_AGENT_MAPPING_CULLING_H_
#define CORBSLAM_CLIENT_AGENT_MAPPING_CULLING_H_

#include <vector>

#include "client_agent/map/guarded_map.h"
#include "client_agent/mapping/point_statistics.h"
#include "slam/map/map.h"

namespace corbslam::client_agent {

inline constexpr double kRedundantShare = 0.95;

// Points that must still prove themselves (ORB-SLAM, T-RO 2015, VI.B). Not thread-safe: the mapping
// thread uses it.
class RecentPoints {
 public:
  explicit RecentPoints(PointStatistics* statistics) : statistics_(statistics) {}

  void Add(const std::vector<MapPointId>& points, KeyframeId made_at);

  // Removes points found in less than a quarter of the frames that should have seen them, or seen
  // by too few keyframes two keyframes after; three keyframes after a point has proved itself.
  void Cull(KeyframeId newest, GuardedMap& map);

 private:
  struct Recent {
    MapPointId id;
    uint32_t made_at = 0;
  };
  enum class Verdict { kWait, kKeep, kRemove };
  Verdict Judge(const Map& map, const Recent& recent, uint32_t newest) const;

  PointStatistics* const statistics_;
  std::vector<Recent> recent_;
};

// Finds own keyframes covisible with `centre` of whose close points 95 % are seen at the same or a
// finer scale by at least three other own ones (ORB-SLAM, VI.E, with 90 %; ORB-SLAM2: close points
// only). Keyframes that nobody has been told of are judged less strictly (keyframe_judgement.h).
// The root, `centre` and keyframes that hold a loop edge stay. Other robots' keyframes make none
// redundant: the own map must hold together without them, for they may go, and no adjustment of it
// has them all. Pure.
std::vector<KeyframeId> FindRedundantKeyframes(const Map& map, KeyframeId centre, LocalMapId own);

// True unless the keyframe is the root or holds a loop edge.
bool MayGo(const Keyframe& keyframe);

// Returns the share of the keyframe's close points that others know well: at least four keyframes
// of theirs, or keyframes of two of their local maps, see the point at the same or a finer scale; 0
// if it has no close points.
double ShareKnownToOthers(const Map& map, const Keyframe& keyframe);

// True if more than `share` of the keyframe's close points are seen as FindRedundantKeyframes asks.
bool IsRedundant(const Map& map, const Keyframe& keyframe, double share = kRedundantShare);

// Removes the keyframe, and those of its points that too few see then.
void RemoveKeyframeAndItsPoints(KeyframeId id, Map& map);

// Removes those of `points` that are the own map's and are seen only once or not at all. An
// observation of each was dropped.
void RemoveWeakPoints(const std::vector<MapPointId>& points, LocalMapId own, Map& map);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_MAPPING_CULLING_H_
