// Keeps what the map store has shared with the robot, in the global frame, and which of it is news
// to the robot's map.
#ifndef CORBSLAM_CLIENT_AGENT_SHARED_SHARED_CONTENT_H_
#define CORBSLAM_CLIENT_AGENT_SHARED_SHARED_CONTENT_H_

#include <map>
#include <memory>
#include <set>
#include <vector>

#include "absl/container/btree_set.h"
#include "absl/container/flat_hash_map.h"
#include "client_agent/shared/own_places.h"
#include "slam/exchange/shared_update.h"
#include "slam/map/item_table.h"
#include "slam/map/map.h"

namespace corbslam::client_agent {

// One step of the store's view, as it came, with what the robot computes of it.
struct ArrivedUpdate {
  SharedUpdate update;
  // The words of each of its keyframes.
  std::vector<std::shared_ptr<const Words>> words;
};

struct ForeignKeyframe {
  std::shared_ptr<const KeyframePayload> payload;
  std::shared_ptr<const Words> words;
  Similarity3d camera_from_global;
  KeyframeId parent;
  // One entry a keypoint.
  std::vector<MapPointId> points;
};

// The items of one foreign local map that are to be looked at again. What is named here and not in
// the content is gone.
struct SourceNews {
  absl::btree_set<KeyframeId> keyframes;
  // Keyframes that may see other points than they did.
  absl::btree_set<KeyframeId> sights;
  absl::btree_set<MapPointId> points;
};

// The content that one local map's robot was sent. Not thread-safe.
class SharedContent {
 public:
  explicit SharedContent(LocalMapId own) : own_(own) {}

  void Apply(const ArrivedUpdate& arrived);
  // Takes out what came of a foreign local map, and takes nothing of it any more.
  void LeaveOut(LocalMapId local_map);

  const std::map<KeyframeId, ForeignKeyframe>& keyframes() const { return keyframes_.items(); }
  const std::map<MapPointId, SharedMapPoint>& points() const { return points_.items(); }
  // Both return null when the item is unknown.
  const ForeignKeyframe* FindKeyframe(KeyframeId id) const { return keyframes_.Find(id); }
  const SharedMapPoint* FindPoint(MapPointId id) const { return points_.Find(id); }
  // The places of own keyframes that fusion has placed.
  const OwnPlaces& own_places() const { return own_places_; }
  OwnPlaces& own_places() { return own_places_; }
  // Returns the keyframe that the point is placed with: its reference, else one that sees it, if
  // that is here. Invalid where there is none.
  KeyframeId PlacingKeyframeOf(const SharedMapPoint& point) const;
  // Returns the point that stands for `id` in the robot's map: an own one of its landmark that the
  // map holds, else the landmark's survivor.
  MapPointId Representative(const Map& map, MapPointId id) const;

  // News of every local map that was ever named; who has placed it empties it.
  const std::map<LocalMapId, SourceNews>& news() const { return news_; }
  std::map<LocalMapId, SourceNews>& news() { return news_; }
  // Makes news of every keyframe that sees a point of the landmark of `id`.
  void MarkViewers(MapPointId id);

 private:
  bool Takes(LocalMapId id) const { return id != own_ && !left_out_.contains(id); }
  void Restart();
  void TakePoint(const SharedMapPoint& point);
  void TakeKeyframe(const SharedKeyframe& shared, std::shared_ptr<const Words> words);
  void TakeObservation(const ObservationChange& change);
  void TakeLandmark(const Landmark& landmark);
  void LeaveLandmark(MapPointId member);
  void DissolveLandmark(MapPointId survivor);
  void RemoveKeyframe(KeyframeId id);
  void RemovePoint(MapPointId id);
  void ListViewer(MapPointId point, KeyframeId viewer);
  void UnlistViewer(MapPointId point, KeyframeId viewer);
  // Returns whether the viewer may be the one that the point is placed with (its reference, or the
  // first that sees it), so that the point is news when the viewer comes or goes.
  bool MayHold(KeyframeId viewer, MapPointId point, const std::vector<KeyframeId>& viewers) const;
  void MarkViewersOf(MapPointId id);
  void MarkPoint(MapPointId id);
  MapPointId SurvivorOf(MapPointId id) const;

  const LocalMapId own_;
  std::set<LocalMapId> left_out_;
  ItemTable<KeyframeId, ForeignKeyframe> keyframes_;
  ItemTable<MapPointId, SharedMapPoint> points_;
  OwnPlaces own_places_;
  absl::flat_hash_map<MapPointId, MapPointId> survivor_of_;
  absl::flat_hash_map<MapPointId, std::vector<MapPointId>> members_of_;  // Members by survivor.
  // The foreign keyframes that list a point, once for each keypoint.
  absl::flat_hash_map<MapPointId, std::vector<KeyframeId>> viewers_of_;
  std::map<LocalMapId, SourceNews> news_;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SHARED_SHARED_CONTENT_H_
