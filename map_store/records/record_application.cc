#include "map_store/records/record_application.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "absl/strings/str_cat.h"
#include "map_store/fusion/fusion_job.h"
#include "map_store/fusion/overlap_query.h"
#include "map_store/fusion/rederivation.h"
#include "map_store/fusion/revision.h"
#include "map_store/ingest/batch_validation.h"
#include "map_store/ingest/gone_local_maps.h"
#include "map_store/ingest/parked_references.h"
#include "map_store/joining/forgetting.h"
#include "map_store/records/retraction.h"
#include "map_store/retiring/retirement.h"
#include "map_store/state/mission_uid.h"
#include "map_store/view/placement.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

bool IsSound(const Overlap& overlap, const QueryTask& task, const MissionState& state) {
  return overlap.query == task.query &&
         state.OwnerOf(overlap.candidate.local_map) == state.OwnerOf(task.against) &&
         overlap.candidate_from_query.scale > 0 &&
         overlap.candidate_from_query.rotation.coeffs().allFinite() &&
         overlap.candidate_from_query.translation.allFinite() && IsCovariance(overlap.covariance);
}

// A mission that nobody made ahead begins with its first batch.
void NoteUse(absl::Time time, MissionState& state) {
  MissionProfile& profile = state.profile;
  profile.last_used_ns = ToProfileTime(time);
  if (profile.created_ns == 0 && state.local_maps.empty()) {
    profile.created_ns = profile.last_used_ns;
  }
}

// Adds an item and drops the oldest beyond a limit: statistics travel whole, in a message of 4 MiB.
template <typename T>
void AddNewest(const T& item, std::vector<T>& items) {
  constexpr size_t kMaxItems = 10'000;
  if (items.size() >= kMaxItems) items.erase(items.begin());
  items.push_back(item);
}

}  // namespace

BatchWords ComputeWords(const MapUpdateBatch& batch, const Vocabulary* vocabulary) {
  BatchWords words;
  if (vocabulary == nullptr) return words;
  for (const FullKeyframe& keyframe : batch.full_keyframes) {
    words[keyframe.payload->id] = std::make_shared<const Words>(
        vocabulary->Transform(keyframe.payload->features.descriptors));
  }
  return words;
}

void Apply(const BatchRecord& record, const BatchWords& words, const MapStoreOptions& options,
           MissionState& state) {
  LocalMapState* local_map = state.FindLocalMap(record.batch->local_map);
  NoteUse(record.received_at, state);
  if (local_map == nullptr) {
    local_map = &AddLocalMap(state, record.batch->local_map, record.agent);
  }
  // Parked references expire also before the batch: what expired when the session opened stays so
  // in a replay, which has no sessions.
  ExpireParked(record.received_at, options, *local_map);
  ApplyBatch(*record.batch, words, options, state, *local_map);
  ExpireParked(record.received_at, options, *local_map);
}

void Apply(const QueryRecord& record, const MapStoreOptions& options, MissionState& state) {
  state.queries.TakeUntil(record.task);
  for (const Overlap& overlap : record.overlaps) {
    if (!IsSound(overlap, record.task, state)) continue;
    OverlapEntry entry;
    entry.id = state.next_overlap++;
    entry.overlap = overlap;
    if (overlap.IsAccepted() && IsTakenBack(overlap, state)) {
      entry.overlap.verdict = OverlapVerdict::kTakenBack;
    }
    entry.state = entry.overlap.IsAccepted() ? OverlapState::kWaiting : OverlapState::kRefused;
    entry.verified_at = record.verified_at;
    ++state.statistics.overlaps_verified;
    if (entry.overlap.IsAccepted()) {
      ++state.statistics.overlaps_accepted;
      const bool inside = state.global.island_of.at(overlap.query.local_map) ==
                          state.global.island_of.at(overlap.candidate.local_map);
      entry.urgent = inside && GraphResidualPx(state, overlap) > options.loop_residual_px;
    }
    state.global.overlaps.Add(std::move(entry));
  }
}

void PrepareToApply(const QueryRecord& record, const MissionState& state) {
  for (const Overlap& overlap : record.overlaps) {
    if (!overlap.IsAccepted()) continue;
    for (const KeyframeId& id : {overlap.query, overlap.candidate}) {
      if (const LocalMapState* local_map = state.FindLocalMap(id.local_map)) {
        FindPoses(state, *local_map);
      }
    }
  }
}

bool IsUrgent(const FuseRecord& record, const MissionState& state) {
  return record.plan.source.IsValid() || !record.relaxed.empty() ||
         std::ranges::any_of(record.plan.overlaps,
                             [&state](uint64_t id) { return state.global.overlaps.at(id).urgent; });
}

bool Apply(const FuseRecord& record, RevisionLayers& layers, MissionState& state) {
  const RevisionPlan& plan = record.plan;
  const bool merged = plan.source.IsValid();
  CommitRevision(plan, layers, state);
  Island& island = state.global.islands.at(plan.target);
  const bool urgent = IsUrgent(record, state);
  for (const LocalMapId& id : record.relaxed) island.relaxed.erase(id);
  island.overlaps_since_adjustment += plan.overlaps.size();
  if (merged) AddNewest(record.merge_ms, state.statistics.merge_ms);
  if (!urgent) return false;
  // An adjustment that runs now is not of this graph any more.
  ++island.generation;
  if (merged || !record.relaxed.empty()) island.needs_adjustment = true;
  return true;
}

void Apply(const FuseRefusedRecord& record, MissionState& state) {
  for (const uint64_t id : record.overlaps) {
    const bool is_to_blame = record.overlaps.size() == 1;
    state.global.overlaps.Change(id, [&](OverlapEntry& entry) {
      entry.alone = entry.alone || !is_to_blame;
      if (!is_to_blame) return;
      Refuse(absl::StrCat("bends the graph: worst edge chi2 ", record.worst_edge_chi2),
             OverlapState::kRefused, entry);
      entry.overlap.verdict = OverlapVerdict::kBendsGraph;
    });
    if (is_to_blame) --state.statistics.overlaps_accepted;
  }
  LeaveToAdjustment(record.relaxed, state, state.global.islands.at(record.target));
}

void Apply(const AdjustRecord& record, RevisionLayers& layers, MissionState& state) {
  CommitRevision(record.plan, layers, state);
  Island& island = state.global.islands.at(record.plan.target);
  island.needs_adjustment = false;
  island.dirty = record.dirty;
  island.overlaps_since_adjustment = 0;
  island.adjusted = layers.adjusted;
  island.moved.clear();
  AddNewest(record.statistics, state.statistics.global_adjustments);
}

void Apply(const RederiveRecord&, MissionState& state) { ForgetGlobalLayer(state); }

void Apply(const RetractRecord& record, const MapStoreOptions& options, MissionState& state) {
  Retract(record, options, state);
}

void Apply(const RetireRecord& record, MissionState& state) {
  ApplyRetirement(record.retirement, state);
}

void Apply(const JoinRecord& record, MissionState& state) { ApplyJoining(record.joining, state); }

void Apply(const ForgetRecord& record, MissionState& state) {
  ForgetLocalMaps(record.local_maps, state);
}

void Apply(const ProfileRecord& record, MissionState& state) { state.profile = record.profile; }

void Apply(const UidRecord& record, MissionState& state) { state.uid = record.uid; }

void Apply(const LocalisedRecord& record, const MapStoreOptions& options, MissionState& state) {
  NoteUse(record.received_at, state);
  AddPart(record.part, options.max_localised_frames_per_agent, state.agents[record.agent].track);
}

void LeaveToAdjustment(const std::vector<LocalMapId>& relaxed, MissionState& state,
                       Island& island) {
  // An adjustment that runs already does not know of the relaxed local maps.
  if (!relaxed.empty()) ++island.generation;
  for (const LocalMapId& id : relaxed) {
    island.displaced.merge(FindRelaxedKeyframes(state, island, id));
    island.relaxed.erase(id);
    island.needs_adjustment = true;
  }
}

void Refuse(const std::string& note, OverlapState to, OverlapEntry& entry) {
  entry.state = to;
  entry.note = note;
}

namespace {

absl::Status Missing(const std::string& what) {
  return absl::DataLossError(absl::StrCat("the journal lacks what made ", what));
}

absl::Status CheckOverlaps(const std::vector<uint64_t>& overlaps, const MissionState& state) {
  for (const uint64_t id : overlaps) {
    if (!state.global.overlaps.contains(id)) return Missing(absl::StrCat("overlap ", id));
  }
  return absl::OkStatus();
}

// Checks that all that the plan places or culls belongs to its islands.
absl::Status CheckPlaces(const RevisionPlan& plan, const MissionState& state) {
  const auto check = [&](const auto& id) {
    const Island* island = state.FindIslandOf(id.local_map);
    if (island != nullptr && (island->id == plan.target || island->id == plan.source)) {
      return absl::OkStatus();
    }
    return Missing(absl::StrCat(ToString(id), " a part of island ", ToString(plan.target)));
  };
  for (const auto& [id, placed] : plan.keyframes) RETURN_IF_ERROR(check(id));
  for (const auto& [id, placed] : plan.points) RETURN_IF_ERROR(check(id));
  for (const KeyframeId& id : plan.culled) RETURN_IF_ERROR(check(id));
  return absl::OkStatus();
}

absl::Status CheckPlan(const RevisionPlan& plan, const MissionState& state) {
  if (plan.revision != state.global.revision + 1) {
    return Missing(absl::StrCat("revision ", plan.revision - 1));
  }
  for (const IslandId& island : {plan.target, plan.source}) {
    const bool named = island == plan.target || island.IsValid();
    if (named && !state.global.islands.contains(island)) {
      return Missing(absl::StrCat("island ", ToString(island)));
    }
  }
  if (plan.source == plan.target) {
    return absl::DataLossError(absl::StrCat("revision ", plan.revision, " fuses island ",
                                            ToString(plan.target), " with itself"));
  }
  RETURN_IF_ERROR(CheckPlaces(plan, state));
  for (const auto& [observation, raw] : plan.rejected_raw) {
    if (!raw.IsValid()) return absl::DataLossError("a revision rejects what nobody sees");
  }
  return CheckOverlaps(plan.overlaps, state);
}

absl::Status CheckRefusal(const FuseRefusedRecord& record, const MissionState& state) {
  if (!state.global.islands.contains(record.target)) return Missing(ToString(record.target));
  for (const LocalMapId& id : record.relaxed) {
    if (state.FindLocalMap(id) == nullptr) return Missing(ToString(id));
  }
  return CheckOverlaps(record.overlaps, state);
}

absl::Status CheckQuery(const QueryRecord& record, const MissionState& state) {
  for (const LocalMapId& id : {record.task.query.local_map, record.task.against}) {
    if (state.FindLocalMap(id) == nullptr) return Missing(ToString(id));
  }
  return absl::OkStatus();
}

absl::Status CheckBatch(const BatchRecord& record, const MissionState& state) {
  const MapUpdateBatch& batch = *record.batch;
  const LocalMapState* local_map = state.FindLocalMap(batch.local_map);
  const uint64_t last = LastBatchOf(state, batch.local_map);
  if (batch.number != last + 1) {
    return Missing(absl::StrCat("batch ", last + 1, " of local map ", ToString(batch.local_map)));
  }
  absl::Status status = ValidateName("agent", record.agent);
  status.Update(CheckTakesBatches(state, batch.local_map));
  if (local_map != nullptr && local_map->agent != record.agent) {
    status.Update(absl::PermissionDeniedError("its local map is another agent's"));
  }
  status.Update(ValidateRecordedBatch(local_map, batch));
  if (status.ok()) return status;
  return absl::DataLossError(absl::StrCat("batch ", batch.number, " of local map ",
                                          ToString(batch.local_map), ": ", status.message()));
}

absl::Status CheckLocalised(const LocalisedRecord& record, const MissionState& state) {
  const LocalisedFrames& part = record.part;
  const auto agent = state.agents.find(record.agent);
  const LocalisedRun* run =
      agent == state.agents.end() ? nullptr : FindRun(agent->second.track, part.run);
  const uint64_t last = run == nullptr ? 0 : run->last_number;
  absl::Status status = ValidateName("agent", record.agent);
  status.Update(ValidateLocalised(part));
  if (!status.ok()) {
    return absl::DataLossError(
        absl::StrCat("what an agent that localises said: ", status.message()));
  }
  if (part.number == last + 1) return absl::OkStatus();
  return Missing(absl::StrCat("part ", last + 1, " of run ", part.run, " of agent ", record.agent));
}

}  // namespace

absl::Status CheckReplay(const JournalRecord& record, const MissionState& state) {
  if (const auto* batch = std::get_if<BatchRecord>(&record)) return CheckBatch(*batch, state);
  if (const auto* query = std::get_if<QueryRecord>(&record)) return CheckQuery(*query, state);
  if (const auto* fuse = std::get_if<FuseRecord>(&record)) return CheckPlan(fuse->plan, state);
  if (const auto* adjust = std::get_if<AdjustRecord>(&record)) {
    return CheckPlan(adjust->plan, state);
  }
  if (std::holds_alternative<RederiveRecord>(record)) return absl::OkStatus();
  if (const auto* retract = std::get_if<RetractRecord>(&record)) {
    const absl::Status retractable = CheckRetractable(state, retract->overlap);
    return retractable.ok() ? retractable : absl::DataLossError(retractable.message());
  }
  if (const auto* retire = std::get_if<RetireRecord>(&record)) {
    return CheckRetirement(retire->retirement, state);
  }
  if (const auto* join = std::get_if<JoinRecord>(&record)) {
    const absl::Status sound = CheckJoining(join->joining, state);
    return sound.ok() ? sound : absl::DataLossError(sound.message());
  }
  if (const auto* forget = std::get_if<ForgetRecord>(&record)) {
    return CheckForgetting(forget->local_maps, state);
  }
  if (const auto* profile = std::get_if<ProfileRecord>(&record)) {
    const absl::Status valid = ValidateProfile(profile->profile);
    return valid.ok() ? valid : absl::DataLossError(valid.message());
  }
  if (const auto* uid = std::get_if<UidRecord>(&record)) {
    if (IsMissionUid(uid->uid)) return absl::OkStatus();
    return absl::DataLossError("a mission's uid is none");
  }
  if (const auto* localised = std::get_if<LocalisedRecord>(&record)) {
    return CheckLocalised(*localised, state);
  }
  return CheckRefusal(std::get<FuseRefusedRecord>(record), state);
}

void RestoreWords(const Vocabulary* vocabulary, MissionState& state) {
  if (vocabulary == nullptr) return;
  for (auto& [id, local_map] : state.local_maps) {
    for (const KeyframeId& keyframe_id : local_map.arrived) {
      const Keyframe* keyframe = local_map.map.FindKeyframe(keyframe_id);
      if (keyframe == nullptr) continue;
      const auto words =
          std::make_shared<const Words>(vocabulary->Transform(keyframe->descriptors()));
      local_map.map.SetWords(keyframe_id, words);
      local_map.database.Add(keyframe_id, words);
    }
  }
}

}  // namespace corbslam::map_store
