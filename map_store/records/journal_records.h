// Records are what changes a mission's state, as values: whoever applies a mission's records in
// their order to an empty state gets its state. Live changes and replays after a crash go through
// the same functions (record_application.h).
#ifndef CORBSLAM_MAP_STORE_RECORDS_JOURNAL_RECORDS_H_
#define CORBSLAM_MAP_STORE_RECORDS_JOURNAL_RECORDS_H_

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "absl/time/time.h"
#include "map_store/fusion/revision_plan.h"
#include "map_store/joining/local_map_joining.h"
#include "map_store/retiring/retirement.h"
#include "map_store/state/mission_state.h"
#include "slam/exchange/map_update.h"
#include "slam/exchange/overlap.h"
#include "slam/exchange/uplink.h"

namespace corbslam::map_store {

// What a journal writes of a batch: the record, and the features of each full keyframe.
struct BatchBytes {
  std::string record;
  std::vector<std::pair<KeyframeId, std::string>> features;
};

// A batch passed validation.
struct BatchRecord {
  std::string agent;
  std::shared_ptr<const MapUpdateBatch> batch;
  absl::Time received_at;
  // What Journal::Prepare made of the rest; null until then.
  std::shared_ptr<const BatchBytes> bytes = nullptr;
};

// The first query of the queue was answered.
struct QueryRecord {
  QueryTask task;
  std::vector<Overlap> overlaps;
  absl::Time verified_at;
};

// Two islands became one, or (where the plan has no source) overlaps were welded into one.
struct FuseRecord {
  RevisionPlan plan;
  std::vector<LocalMapId> relaxed;
  double merge_ms = 0;  // Milliseconds since the first of its overlaps was verified.
};

// The worker found that the overlaps bend the graph.
struct FuseRefusedRecord {
  IslandId target;
  std::vector<uint64_t> overlaps;
  std::vector<LocalMapId> relaxed;
  double worst_edge_chi2 = 0;
};

// What a journal writes of a plan.
struct PlanBytes {
  std::string fields;
  std::string anchors;
};

struct AdjustRecord {
  RevisionPlan plan;
  bool dirty = false;  // True: owners said more while the worker was busy.
  GlobalAdjustmentStatistics statistics;
  // What Journal::Prepare made of the plan; null until then.
  std::shared_ptr<const PlanBytes> plan_bytes = nullptr;
};

// The global layer was forgotten, to be derived again.
struct RederiveRecord {};

// Somebody took back an overlap; or, with `keep_apart`, all overlaps between its two local maps,
// for ever.
struct RetractRecord {
  uint64_t overlap = 0;
  bool keep_apart = false;
};

// Somebody made the mission, or changed what is set of it; or it was used. The whole profile as it
// is from here on.
struct ProfileRecord {
  MissionProfile profile;
};

// The mission was named apart from earlier and later ones of its name.
struct UidRecord {
  std::string uid;
};

// The store let go of keyframes and points of closed local maps.
struct RetireRecord {
  Retirement retirement;
};

// Two local maps of an agent became one.
struct JoinRecord {
  LocalMapJoining joining;
};

// Somebody deleted these closed local maps.
struct ForgetRecord {
  std::vector<LocalMapId> local_maps;
};

// A part of the trajectory of an agent that only localises came.
struct LocalisedRecord {
  std::string agent;
  LocalisedFrames part;  // Without `frames`, which are not kept.
  absl::Time received_at;
};

// Events that are no records (queries without candidates, workers' failures) are decided again
// after a restart.
using JournalRecord =
    std::variant<BatchRecord, QueryRecord, FuseRecord, FuseRefusedRecord, AdjustRecord,
                 RederiveRecord, RetractRecord, ProfileRecord, RetireRecord, JoinRecord,
                 ForgetRecord, LocalisedRecord, UidRecord>;

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_RECORDS_JOURNAL_RECORDS_H_
