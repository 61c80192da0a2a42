#include "map_store/fusion/revision_plan.h"

#include <map>
#include <optional>
#include <set>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "absl/container/flat_hash_set.h"
#include "map_store/view/island_view.h"
#include "map_store/view/metres.h"
#include "map_store/view/placement.h"
#include "slam/util/median.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

// A millisecond or two.
constexpr size_t kStepsInAPiece = 2000;
constexpr size_t kStepsOfDepths = 500;

// A scale is told from so many depths.
constexpr size_t kLeastDepths = 15;

using NewPoses = std::map<KeyframeId, Similarity3d>;

NewPoses Index(const std::vector<KeyframePose>& poses) {
  NewPoses indexed;
  for (const KeyframePose& pose : poses) indexed[pose.id] = pose.camera_from_map;
  return indexed;
}

// Puts the scale back: the worker saw cameras whose units were rescaled to the view's.
Similarity3d Rescale(const Similarity3d& pose, double scale) {
  return {pose.scale * scale, pose.rotation, pose.translation * scale};
}

bool HasMetres(const MissionState& state, IslandId id) {
  const auto it = state.global.islands.find(id);
  return it != state.global.islands.end() && IsInMetres(state, it->second);
}

// Points that were merged into each survivor, in the order of merging.
using MergedPoints = absl::flat_hash_map<MapPointId, std::vector<MapPointId>>;

MergedPoints GroupBySurvivor(const std::vector<FuseMapsResult::Merge>& merges) {
  MergedPoints members;
  for (const FuseMapsResult::Merge& merge : merges) {
    members[merge.survivor].push_back(merge.member);
  }
  return members;
}

using MergedInto = absl::flat_hash_map<MapPointId, MapPointId>;

MergedInto GroupByMember(const std::vector<FuseMapsResult::Merge>& merges) {
  MergedInto survivors;
  for (const FuseMapsResult::Merge& merge : merges) survivors[merge.member] = merge.survivor;
  return survivors;
}

// Returns the keypoint by which the keyframe saw the point, or a point that was merged into it, in
// the views.
std::optional<uint32_t> FindKeypoint(const std::vector<const Map*>& views,
                                     const MergedPoints& merged,
                                     const RejectedObservation& rejected) {
  std::vector<MapPointId> names = {rejected.point};
  if (const auto it = merged.find(rejected.point); it != merged.end()) {
    names.insert(names.end(), it->second.begin(), it->second.end());
  }
  for (const Map* view : views) {
    for (const MapPointId& name : names) {
      const MapPoint* point = view->FindPoint(name);
      if (point == nullptr) continue;
      const auto it = point->observations.find(rejected.keyframe);
      if (it != point->observations.end()) return it->second;
    }
  }
  return std::nullopt;
}

// Fills a plan in. Each function walks through what a worker or a snapshot says, which stays, and
// may pause between two items; all return ABORTED as the read does.
class Planner {
 public:
  // The plan has its revision and what it culls.
  Planner(const MissionState& state, LongRead& read, RevisionPlan& plan)
      : state_(state),
        steps_(read, kStepsInAPiece),
        plan_(plan),
        in_metres_(HasMetres(state, plan.target)),
        culled_(plan.culled.begin(), plan.culled.end()) {}

  absl::Status AddKeyframes(const IslandSnapshot& snapshot, const NewPoses& new_poses,
                            const Similarity3d& snapshot_from_target) {
    for (const auto& [id, pose] : snapshot.poses) {
      RETURN_IF_ERROR(steps_.Advance());
      if (!IsToBePlaced(id)) continue;
      const auto moved = new_poses.find(id);
      Similarity3d placed = moved == new_poses.end() ? pose * snapshot_from_target
                                                     : Rescale(moved->second, pose.scale);
      if (placed.scale != 1 && MeasuresMetres(id))
        placed = Similarity3d::FromRigid(placed.ToRigid());
      plan_.keyframes.emplace_hint(
          plan_.keyframes.end(), id,
          PlacedKeyframe{placed, snapshot.local_poses.at(id), plan_.revision});
    }
    return absl::OkStatus();
  }

  absl::Status AddPositions(const std::vector<PointPosition>& positions) {
    for (const auto& [id, position] : positions) {
      RETURN_IF_ERROR(steps_.Advance());
      if (const MapPoint* own = FindPlaceable(id)) Place(*own, position);
    }
    return absl::OkStatus();
  }

  // Adds also the points that the adjustment left alone: they move with their reference keyframes.
  absl::Status AddPointsOfView(const IslandSnapshot& snapshot, const Map& view) {
    absl::flat_hash_map<KeyframeId, Similarity3d> motions;
    for (const auto& [id, point] : view.points()) {
      RETURN_IF_ERROR(steps_.Advance());
      if (plan_.points.contains(id)) continue;
      const MapPoint* own = FindPlaceable(id);
      if (own == nullptr) continue;
      const KeyframeId reference = ReferenceOf(*own, state_.global);
      const auto [it, added] = motions.try_emplace(reference);
      if (added) {
        it->second = plan_.keyframes.at(reference).camera_from_island.Inverse() *
                     snapshot.poses.at(reference);
      }
      Place(*own, it->second * point.position_in_map);
    }
    return absl::OkStatus();
  }

  // Points that are anchored in a keyframe move with it. Those whose keyframe is derived anew from
  // its owner's poses are derived anew, too. This makes no pauses.
  void AddDerivedPoints(const IslandSnapshot& snapshot) {
    std::set<LocalMapId> derived;
    for (const KeyframeId& id : snapshot.unplaced) derived.insert(id.local_map);
    for (const LocalMapId& local_map : derived) AddDerivedPoints(snapshot, local_map);
  }

  // A bundle adjustment moves keyframes and points, and says no scale. One of a camera that
  // measures no metres is what its own map's depths are to the new ones: by it goes what follows
  // the keyframe, up to where its robot is now.
  absl::Status MeasureScales() {
    std::vector<KeyframeId> without_metres;
    for (const auto& [id, placed] : plan_.keyframes) {
      if (!IsInMetres(*state_.FindLocalMap(id.local_map))) without_metres.push_back(id);
    }
    if (without_metres.empty()) return absl::OkStatus();
    const MergedInto merged = GroupByMember(plan_.merges);
    for (const KeyframeId& id : without_metres) {
      RETURN_IF_ERROR(steps_.Advance(kStepsOfDepths));
      const Map& map = state_.FindLocalMap(id.local_map)->map;
      const Keyframe* keyframe = map.FindKeyframe(id);
      if (keyframe == nullptr) continue;
      MeasureScale(map, *keyframe, merged, plan_.keyframes.at(id).camera_from_island);
    }
    return absl::OkStatus();
  }

  absl::Status AddRejected(const std::vector<const Map*>& views,
                           const std::vector<RejectedObservation>& rejected) {
    const MergedPoints merged = GroupBySurvivor(plan_.merges);
    for (const RejectedObservation& observation : rejected) {
      RETURN_IF_ERROR(steps_.Advance());
      const LocalMapState* local_map = state_.FindLocalMap(observation.keyframe.local_map);
      if (local_map == nullptr) continue;
      const std::optional<uint32_t> keypoint = FindKeypoint(views, merged, observation);
      if (!keypoint.has_value()) continue;
      const MapPointId raw = RawObservation(*local_map, observation.keyframe, *keypoint);
      if (!raw.IsValid()) continue;
      plan_.rejected_raw[{observation.keyframe, *keypoint}] = raw;
    }
    return absl::OkStatus();
  }

 private:
  // Both the camera and the island have metres: beside maps that have none the worker leaves scales
  // free, of all.
  bool MeasuresMetres(KeyframeId id) const {
    return in_metres_ && IsInMetres(*state_.FindLocalMap(id.local_map));
  }

  // Leaves the scale as it is where the plan places too little of what the keyframe sees.
  void MeasureScale(const Map& map, const Keyframe& keyframe, const MergedInto& merged,
                    Similarity3d& camera_from_island) const {
    const Rigid3d rigid = camera_from_island.ToRigid();
    std::vector<double> ratios;
    for (const MapPointId& id : keyframe.points) {
      const MapPoint* own = id.IsValid() ? map.FindPoint(id) : nullptr;
      if (own == nullptr) continue;
      const MapPointId survivor = state_.global.landmarks.Survivor(id);
      const auto renamed = merged.find(survivor);
      const auto planned = plan_.points.find(renamed == merged.end() ? survivor : renamed->second);
      if (planned == plan_.points.end()) continue;
      const double before = (keyframe.camera_from_map * own->position_in_map).z();
      const double after = (rigid * planned->second.position_in_island).z();
      if (before > 0 && after > 0) ratios.push_back(before / after);
    }
    if (ratios.size() < kLeastDepths) return;
    const double scale = Median(std::move(ratios));
    camera_from_island = {scale, rigid.rotation, scale * rigid.translation};
  }

  bool IsToBePlaced(KeyframeId id) const {
    const LocalMapState& local_map = *state_.FindLocalMap(id.local_map);
    return local_map.IsSettled(id) && local_map.map.FindKeyframe(id) != nullptr &&
           !state_.global.culled.contains(id);
  }

  // Returns the point if it gets a position of its own: only survivors whose reference keyframe is
  // placed do.
  const MapPoint* FindPlaceable(MapPointId id) const {
    const MapPoint* own = state_.FindPoint(id);
    const bool placeable = own != nullptr &&
                           plan_.keyframes.contains(ReferenceOf(*own, state_.global)) &&
                           state_.global.landmarks.Survivor(id) == id;
    return placeable ? own : nullptr;
  }

  // Returns the keyframe that the point is to be anchored in: its reference keyframe, or where the
  // plan culls that, another one that sees it. Invalid: no placed one does.
  KeyframeId AnchorOf(const MapPoint& own) const {
    const auto stays = [this](KeyframeId id) {
      return plan_.keyframes.contains(id) && !culled_.contains(id);
    };
    const KeyframeId reference = ReferenceOf(own, state_.global);
    if (stays(reference)) return reference;
    for (const auto& [id, keypoint] : own.observations) {
      if (stays(id)) return id;
    }
    return KeyframeId();
  }

  void Place(const MapPoint& own, const Eigen::Vector3d& position_in_island) {
    plan_.points[own.id] = {position_in_island, plan_.revision, AnchorOf(own)};
  }

  void AddDerivedPoints(const IslandSnapshot& snapshot, LocalMapId local_map) {
    const Map& map = state_.FindLocalMap(local_map)->map;
    for (auto it = state_.global.points.lower_bound(MapPointId{local_map, 0});
         it != state_.global.points.end() && it->first.local_map == local_map; ++it) {
      const MapPoint* point = map.FindPoint(it->first);
      if (point == nullptr) continue;
      const KeyframeId reference = ReferenceOf(*point, state_.global);
      const auto planned = plan_.keyframes.find(reference);
      if (planned == plan_.keyframes.end() || !snapshot.unplaced.contains(reference)) continue;
      const Similarity3d local = Similarity3d::FromRigid(planned->second.camera_from_local);
      Place(*point, planned->second.camera_from_island.Inverse() * local * point->position_in_map);
    }
  }

  const MissionState& state_;
  StepsInPieces steps_;
  RevisionPlan& plan_;
  const bool in_metres_;
  const absl::flat_hash_set<KeyframeId> culled_;
};

}  // namespace

RevisionPlan PlanFuse(const MissionState& state, const FuseJob& job, const FuseMapsResult& result) {
  RevisionPlan plan;
  plan.revision = state.global.revision + 1;
  plan.target = job.action.target;
  plan.source = job.action.source;
  plan.merges = result.merges;
  plan.overlaps = job.new_overlaps;
  UnbrokenRead read;
  Planner planner(state, read, plan);
  const NewPoses poses = Index(result.poses);
  std::vector<const Map*> views = {&job.request.target};
  // A read in one piece has no errors.
  planner.AddKeyframes(job.target, poses, Similarity3d()).IgnoreError();
  if (job.source.has_value()) {
    planner.AddKeyframes(*job.source, poses, result.target_from_source.Inverse()).IgnoreError();
    planner.AddDerivedPoints(*job.source);
    views.push_back(&job.request.source);
  }
  planner.AddDerivedPoints(job.target);
  planner.AddPositions(result.positions).IgnoreError();
  planner.MeasureScales().IgnoreError();
  planner.AddRejected(views, result.rejected).IgnoreError();
  return plan;
}

absl::StatusOr<RevisionPlan> PlanAdjust(const MissionState& state, const AdjustJob& job,
                                        const AdjustBundleResult& result, LongRead& read) {
  RevisionPlan plan;
  plan.revision = state.global.revision + 1;
  plan.target = job.snapshot.island;
  for (const KeyframeId& id : result.redundant) {
    if (job.snapshot.poses.contains(id)) plan.culled.push_back(id);
  }
  Planner planner(state, read, plan);
  RETURN_IF_ERROR(planner.AddKeyframes(job.snapshot, Index(result.poses), Similarity3d()));
  RETURN_IF_ERROR(planner.AddPositions(result.positions));
  RETURN_IF_ERROR(planner.AddPointsOfView(job.snapshot, job.request.view));
  RETURN_IF_ERROR(planner.MeasureScales());
  RETURN_IF_ERROR(planner.AddRejected({&job.request.view}, result.rejected));
  for (const auto& [id, keyframe] : job.request.view.keyframes()) plan.decided_anew.insert(id);
  return plan;
}

}  // namespace corbslam::map_store
