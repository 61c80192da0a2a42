// Keyframes, map points and the graph between them, in one coordinate frame: a local map on its
// robot, or a view of an island that fusion works on. Holds no algorithm's scratch values:
// algorithms take a Map (or a copy) and return results.
#ifndef CORBSLAM_SLAM_MAP_MAP_H_
#define CORBSLAM_SLAM_MAP_MAP_H_

#include <map>
#include <memory>
#include <vector>

#include "slam/map/item_table.h"
#include "slam/map/keyframe.h"
#include "slam/map/map_observer.h"
#include "slam/map/map_point.h"

namespace corbslam {

struct CovisibleKeyframe {
  KeyframeId id;
  int weight = 0;  // Number of points seen by both.
};

// Where a map's covisibility comes from: counted from its own observations, or, for a view of a
// larger map, given by whoever knows the whole (none, where nobody gives it).
enum class Covisibility { kCounted, kGiven };

// A value; copying shares the payloads and drops the observer. Not thread-safe. Invariants, kept
// by every method: an observation stands in the keyframe and in the point; counted covisibility
// agrees with observations; the spanning tree has no cycle, and every child's parent lists it.
// Pointers to an item are good until that item is removed. Methods that name an unknown
// id do nothing and return false (or empty) unless said otherwise.
class Map {
 public:
  Map() = default;
  explicit Map(Covisibility covisibility) : covisibility_(covisibility) {}
  Map(const Map& other);
  Map& operator=(const Map& other);
  Map(Map&&) = default;
  Map& operator=(Map&&) = default;

  // The map does not own its observer; null for none.
  void SetObserver(MapObserver* observer) { observer_ = observer; }

  const std::map<KeyframeId, Keyframe>& keyframes() const { return keyframes_.items(); }
  const std::map<MapPointId, MapPoint>& points() const { return points_.items(); }
  // These return null when the id is unknown.
  const Keyframe* FindKeyframe(KeyframeId id) const { return keyframes_.Find(id); }
  const MapPoint* FindPoint(MapPointId id) const { return points_.Find(id); }

  // Adds a keyframe with its payload, words, pose and parent; `points` must be empty or all
  // invalid, children and covisible empty: observations come by AddObservation. Without features in
  // its payload it has as many keypoints as `points` has entries. A parent that is not in the map
  // is taken as none. Returns false if the id is there already.
  bool AddKeyframe(Keyframe keyframe);
  // Adds a point without observations. Returns false if the id is there already.
  bool AddPoint(MapPoint point);

  // Takes over another map in the same frame, as it is: the graphs stay apart. Returns false, and
  // changes nothing, if any id is in both. The observer isn't told; the other's covisibility must
  // come from where this map's does. It costs as much as the other map has items.
  bool Absorb(Map other);

  void SetPose(KeyframeId id, const Rigid3d& camera_from_map);
  void SetPosition(MapPointId id, const Eigen::Vector3d& position_in_map);
  void SetWords(KeyframeId id, std::shared_ptr<const Words> words);
  // Drops the features where the graph alone is needed. The payload is not edited: others may have
  // it too.
  void DropFeatures(KeyframeId id);
  // Sets better measured positions of its keypoints; what they look like and see stays. The payload
  // is not edited. Returns false, and changes nothing, if the keyframe is unknown, has not as many,
  // or the observer says no.
  bool SetKeypoints(KeyframeId id, std::vector<Keypoint> keypoints);
  // Returns false, and changes nothing, if that would make a cycle.
  bool SetParent(KeyframeId child, KeyframeId parent);
  bool AddLoopEdge(KeyframeId a, KeyframeId b);
  // Returns false where covisibility is counted. `weight` is greater than 0.
  bool SetCovisibility(KeyframeId a, KeyframeId b, int weight);

  // Returns false if either is unknown, the keypoint is taken or out of range, or the keyframe sees
  // the point already.
  bool AddObservation(MapPointId point, KeyframeId keyframe, uint32_t keypoint);
  // Adds all that the keyframe sees: keypoint i sees points[i]. Invalid ids, and observations for
  // which AddObservation would return false, are left out.
  void AddObservations(KeyframeId keyframe, const std::vector<MapPointId>& points);
  // The point stays even when nobody sees it any more.
  bool RemoveObservation(MapPointId point, KeyframeId keyframe);
  // Moves the observations of `replaced` to `survivor` and removes `replaced`.
  bool ReplacePoint(MapPointId replaced, MapPointId survivor);
  bool RemovePoint(MapPointId id);
  // Removes the keyframe and its observations; children go to their most covisible relative of
  // their own local map that makes no cycle, else to the removed keyframe's parent. Removing the
  // root promotes a child.
  bool RemoveKeyframe(KeyframeId id);

  // Computes the point's normal, distance range and representative descriptor from its
  // observations. It does nothing to points nobody sees.
  void UpdatePointAppearance(MapPointId id);
  // Computes the normal and distance range only (after poses moved).
  void UpdatePointGeometry(MapPointId id);
  // Sets the appearance of points for which it came from elsewhere (the wire).
  void SetPointAppearance(MapPointId id, const Descriptor& descriptor,
                          const Eigen::Vector3d& normal_in_map, double min_distance,
                          double max_distance, KeyframeId reference);

  // Returns the named keyframes and points (each once; unknown ones are skipped) with what lies
  // between them, for an optimisation to work on: observations, covisibility (given: the whole
  // map's) and edges that lead elsewhere are left out. It costs as much as the part is large.
  Map CopyPart(const std::vector<KeyframeId>& keyframes,
               const std::vector<MapPointId>& points) const;

  // Returns keyframes that share at least `min_weight` points with `id`, most first, ties by id.
  std::vector<CovisibleKeyframe> Covisible(KeyframeId id, int min_weight = 15) const;
  // Returns the first `count` of them, of any weight.
  std::vector<CovisibleKeyframe> BestCovisible(KeyframeId id, int count) const;

 private:
  bool Observe(MapPoint& point, Keyframe& keyframe, uint32_t keypoint);
  void Connect(MapPoint& point, Keyframe& keyframe, uint32_t keypoint);
  void Disconnect(MapPoint& point, Keyframe& keyframe);
  void ChangeCovisibility(const MapPoint& point, Keyframe& keyframe, int change);
  void ForgetCovisibility(const Keyframe& removed);
  bool IsAncestor(KeyframeId ancestor, KeyframeId id) const;
  void Attach(Keyframe& child, KeyframeId parent);
  class BranchFinder;
  KeyframeId ChooseNewParent(const Keyframe& child, const Keyframe& removed,
                             BranchFinder& branches) const;
  void RehangChildren(const Keyframe& removed);

  ItemTable<KeyframeId, Keyframe> keyframes_;
  ItemTable<MapPointId, MapPoint> points_;
  Covisibility covisibility_ = Covisibility::kCounted;
  MapObserver* observer_ = nullptr;
};

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_MAP_MAP_H_
