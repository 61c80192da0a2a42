// Knows which parts of a mission are still to be looked at for what may retire.
#ifndef CORBSLAM_MAP_STORE_RETIRING_RETIRING_PASS_H_
#define CORBSLAM_MAP_STORE_RETIRING_RETIRING_PASS_H_

#include <cstddef>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "map_store/options/options.h"
#include "map_store/retiring/keyframe_choice.h"
#include "map_store/retiring/retirement.h"
#include "map_store/retiring/retiring_view.h"

namespace corbslam::map_store {

// Some keyframes of one closed local map, one after the other.
struct RetiringStretch {
  LocalMapId local_map;
  IslandId island;
  std::set<KeyframeId> keyframes;
  size_t end = 0;  // Index in the order of arrival of the first keyframe after them.
};

// Names stretches of local maps that are closed and in an island with another closed one, each
// once for each island that the local map comes into: what came before is looked at again where it
// lies around the stretch. Not stored: after a restart everything is looked at once more, unless
// the mission slept when nothing was due. A value; not thread-safe.
class RetiringPasses {
 public:
  // Returns the next stretch; nullopt if there is none. It costs a look at each local map.
  std::optional<RetiringStretch> Next(const MissionState& state) const;
  bool IsDue(const MissionState& state) const;
  // The caller says that the stretch was looked at.
  void NoteDone(const RetiringStretch& stretch);
  // The caller says that nothing was due of this very state when it was put away.
  void NoteAllDone(const MissionState& state);

 private:
  struct Progress {
    IslandId island;
    size_t next = 0;  // Index in the order of arrival.
  };

  // Returns where the next stretch of the local map begins; nullopt if it is not due.
  std::optional<size_t> BeginOf(const LocalMapState& local_map, const Island& island) const;

  std::map<LocalMapId, Progress> progress_;
};

// Decides what retires of a view, and counts in `stays`, if given, why the rest stays. Pure.
Retirement PlanRetirement(const RetiringView& view, const MapStoreOptions& options,
                          StayCounts* stays = nullptr);

// Cuts a retirement into parts that each take some milliseconds to apply. What stays in one of them
// stays in all, so that any first ones may be applied without the others.
std::vector<Retirement> CutIntoParts(const Retirement& retirement);

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_RETIRING_RETIRING_PASS_H_
