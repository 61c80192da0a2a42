// Says how a mission's state and journal records are archived (archive.h).
#ifndef CORBSLAM_MAP_STORE_ARCHIVE_STATE_FIELDS_H_
#define CORBSLAM_MAP_STORE_ARCHIVE_STATE_FIELDS_H_

#include <cstdint>
#include <deque>
#include <limits>
#include <map>
#include <utility>

#include "absl/time/time.h"
#include "map_store/archive/value_fields.h"
#include "map_store/records/journal_records.h"
#include "map_store/state/mission_state.h"

namespace corbslam::map_store {

template <typename Archive, MayBeConst<FuseMapsResult::Merge> T>
void Fields(Archive& archive, T& merge) {
  archive(merge.survivor, merge.member);
}
template <typename Archive, MayBeConst<TransferStatistics> T>
void Fields(Archive& archive, T& statistics) {
  archive(statistics.count, statistics.bytes, statistics.ms);
}
template <typename Archive, MayBeConst<GlobalAdjustmentStatistics> T>
void Fields(Archive& archive, T& statistics) {
  archive(statistics.keyframes, statistics.map_points, statistics.iterations, statistics.ms);
}
// Only what is counted is archived; the rest is derived from the state when somebody asks.
template <typename Archive, MayBeConst<MissionStatistics> T>
void Fields(Archive& archive, T& statistics) {
  archive(statistics.full_keyframes, statistics.full_map_points, statistics.light_keyframes,
          statistics.light_map_points, statistics.overlaps_queried, statistics.overlaps_verified,
          statistics.overlaps_accepted, statistics.merge_ms, statistics.global_adjustments,
          statistics.failed_requests);
}

constexpr OverlapState LastValue(OverlapState) { return OverlapState::kFailed; }

template <typename Archive, MayBeConst<absl::Time> T>
void Time(Archive& archive, T& time) {
  int64_t unix_ns = absl::ToUnixNanos(time);
  archive(unix_ns);
  if constexpr (Archive::kReads) {
    constexpr int64_t kNever = std::numeric_limits<int64_t>::max();
    time = unix_ns == kNever ? absl::InfiniteFuture() : absl::FromUnixNanos(unix_ns);
  }
}

template <typename Archive, MayBeConst<Tombstone> T>
void Fields(Archive& archive, T& tombstone) {
  archive(tombstone.parent, tombstone.parent_from_removed);
}
template <typename Archive, MayBeConst<ParkedReference> T>
void Fields(Archive& archive, T& parked) {
  archive(parked.reference);
  Time(archive, parked.since);
}
template <typename Archive, MayBeConst<ParkedParent> T>
void Fields(Archive& archive, T& parked) {
  archive(parked.parent);
  Time(archive, parked.since);
}
// Archives the references as a list without what each of them waits for, which the table derives:
// the format is older than the table.
template <typename Archive, MayBeConst<WaitingTable<uint64_t, ParkedReference>> T>
void Fields(Archive& archive, T& parked) {
  std::deque<ParkedReference> list;
  for (const auto& [order, reference] : parked.Values()) list.push_back(reference);
  archive(list);
  if constexpr (Archive::kReads) {
    std::map<uint64_t, ParkedReference> values;
    for (const ParkedReference& reference : list) values.emplace(values.size(), reference);
    parked = T(std::move(values));
  }
}
template <typename Archive, MayBeConst<WaitingTable<KeyframeId, ParkedParent>> T>
void Fields(Archive& archive, T& parked) {
  std::map<KeyframeId, ParkedParent> values = parked.Values();
  archive(values);
  if constexpr (Archive::kReads) parked = T(std::move(values));
}
template <typename Archive, MayBeConst<PlacedKeyframe> T>
void Fields(Archive& archive, T& placed) {
  archive(placed.camera_from_island, placed.camera_from_local, placed.revision);
}
// The anchors of all placed points stand apart, behind everything else: the format is older.
template <typename Archive, MayBeConst<PlacedPoint> T>
void Fields(Archive& archive, T& placed) {
  archive(placed.position_in_anchor, placed.revision);
}
// The anchors of a plan's points stand apart, at the end of the record: the format is older.
template <typename Archive, MayBeConst<PlannedPoint> T>
void Fields(Archive& archive, T& planned) {
  archive(planned.position_in_island, planned.revision);
}
template <typename Archive, MayBeConst<Island> T>
void Fields(Archive& archive, T& island) {
  archive(island.id, island.local_maps, island.fused, island.generation, island.dirty,
          island.needs_adjustment, island.overlaps_since_adjustment, island.displaced,
          island.relaxed, island.version, island.version_of_owners, island.shared_version);
}
template <typename Archive, MayBeConst<OverlapEntry> T>
void Fields(Archive& archive, T& entry) {
  archive(entry.id, entry.overlap, entry.state, entry.urgent, entry.alone, entry.attempts,
          entry.revision, entry.note);
  Time(archive, entry.verified_at);
}
template <typename Archive, MayBeConst<QueryTask> T>
void Fields(Archive& archive, T& task) {
  archive(task.query, task.against, task.attempts);
}
template <typename Archive, MayBeConst<RevisionPlan> T>
void Fields(Archive& archive, T& plan) {
  archive(plan.revision, plan.target, plan.source, plan.keyframes, plan.points, plan.merges,
          plan.rejected_raw, plan.decided_anew, plan.culled, plan.overlaps);
}

template <typename Archive, MayBeConst<OverlapLedger> T>
void Fields(Archive& archive, T& ledger) {
  if constexpr (Archive::kReads) {
    OverlapLedger::Entries entries;
    archive(entries);
    ledger = OverlapLedger(std::move(entries));
  } else {
    archive(ledger.entries());
  }
}
template <typename Archive, MayBeConst<QueryQueue> T>
void Fields(Archive& archive, T& queue) {
  if constexpr (Archive::kReads) {
    std::vector<QueryTask> tasks;
    archive(tasks);
    queue = QueryQueue(tasks);
  } else {
    archive(queue.ToTasks());
  }
}

template <typename Archive, MayBeConst<BatchRecord> T>
void Fields(Archive& archive, T& record) {
  archive(record.agent);
  Pointed(archive, record.batch);
  Time(archive, record.received_at);
}
template <typename Archive, MayBeConst<QueryRecord> T>
void Fields(Archive& archive, T& record) {
  archive(record.task, record.overlaps);
  Time(archive, record.verified_at);
}
template <typename Archive, MayBeConst<FuseRecord> T>
void Fields(Archive& archive, T& record) {
  archive(record.plan, record.relaxed, record.merge_ms);
}
template <typename Archive, MayBeConst<FuseRefusedRecord> T>
void Fields(Archive& archive, T& record) {
  archive(record.target, record.overlaps, record.relaxed, record.worst_edge_chi2);
}
template <typename Archive, MayBeConst<RederiveRecord> T>
void Fields(Archive&, T&) {}
template <typename Archive, MayBeConst<RetractRecord> T>
void Fields(Archive& archive, T& record) {
  archive(record.overlap, record.keep_apart);
}
template <typename Archive, MayBeConst<StandIn> T>
void Fields(Archive& archive, T& stand_in) {
  archive(stand_in.keyframe, stand_in.keyframe_from_retired);
}
template <typename Archive, MayBeConst<RetiredKeyframe> T>
void Fields(Archive& archive, T& retired) {
  archive(retired.id, retired.parent, retired.parent_from_removed, retired.stand_in);
}
template <typename Archive, MayBeConst<RetireRecord> T>
void Fields(Archive& archive, T& record) {
  archive(record.retirement.keyframes, record.retirement.faded);
}
template <typename Archive, MayBeConst<JoinedLocalMap> T>
void Fields(Archive& archive, T& part) {
  archive(part.id, part.last_batch, part.first_frame, part.first_lost_frame);
}
template <typename Archive, MayBeConst<JoinRecord> T>
void Fields(Archive& archive, T& record) {
  archive(record.joining.part, record.joining.whole, record.joining.whole_from_part);
}
template <typename Archive, MayBeConst<ForgetRecord> T>
void Fields(Archive& archive, T& record) {
  archive(record.local_maps);
}
template <typename Archive, MayBeConst<GeoOrigin> T>
void Fields(Archive& archive, T& origin) {
  archive(origin.latitude_deg, origin.longitude_deg, origin.altitude_m, origin.heading_deg);
}
template <typename Archive, MayBeConst<MissionLimits> T>
void Fields(Archive& archive, T& limits) {
  archive(limits.keyframes, limits.memory_bytes, limits.disk_bytes, limits.uplink_bytes_per_second);
}
template <typename Archive, MayBeConst<MissionProfile> T>
void Fields(Archive& archive, T& profile) {
  archive(profile.description, profile.labels, profile.limits, profile.agent_limits,
          profile.retention_s, profile.created_ns, profile.last_used_ns);
  bool has_origin = profile.origin.has_value();
  archive(has_origin);
  if constexpr (Archive::kReads) {
    profile.origin.reset();
    if (has_origin) profile.origin.emplace();
  }
  if (has_origin) archive(*profile.origin);
}
template <typename Archive, MayBeConst<SignedSettings> T>
void Fields(Archive& archive, T& settings) {
  archive(settings.version, settings.bytes, settings.signature);
}
// These stand apart, behind what the store let go of: the format is older.
template <typename Archive, MayBeConst<MissionProfile> T>
void SettingsFields(Archive& archive, T& profile) {
  archive(profile.revision, profile.robot_settings);
}
template <typename Archive, MayBeConst<ProfileRecord> T>
void Fields(Archive& archive, T& record) {
  archive(record.profile);
  SettingsFields(archive, record.profile);
}
template <typename Archive, MayBeConst<UidRecord> T>
void Fields(Archive& archive, T& record) {
  archive(record.uid);
}
template <typename Archive, MayBeConst<LocalisedRecord> T>
void Fields(Archive& archive, T& record) {
  archive(record.agent, record.part.run, record.part.number, record.part.recorded_camera,
          record.part.tracked_frames, record.part.lost_frames_ns);
  Time(archive, record.received_at);
}
template <typename Archive, MayBeConst<LocalisedRun> T>
void Fields(Archive& archive, T& run) {
  archive(run.id, run.last_number, run.recorded_camera, run.frames, run.lost_frames_ns);
}
template <typename Archive, MayBeConst<LocalisedTrack> T>
void Fields(Archive& archive, T& track) {
  archive(track.runs, track.dropped);
}
template <typename Archive, MayBeConst<AdjustRecord> T>
void Fields(Archive& archive, T& record) {
  if constexpr (Archive::kReads) {
    archive(record.plan);
  } else if (record.plan_bytes != nullptr) {
    archive.Raw(record.plan_bytes->fields.data(), record.plan_bytes->fields.size());
  } else {
    archive(record.plan);
  }
  archive(record.dirty, record.statistics);
}

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_ARCHIVE_STATE_FIELDS_H_
