#include "map_store/process/mission.h"

#include "absl/strings/str_cat.h"
#include "map_store/view/answers.h"
#include "map_store/view/memory_estimate.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

MissionLoad MeasureLoad(const MissionState& state) {
  MissionLoad load;
  load.revision = state.global.revision;
  load.agents = state.agents.size();
  for (const auto& [name, agent] : state.agents) load.connected_agents += agent.session != 0;
  load.local_maps = state.local_maps.size();
  load.joined_local_maps = state.joined_into.size();
  load.forgotten_local_maps = state.forgotten.size();
  load.islands = state.global.islands.size();
  for (const auto& [id, local_map] : state.local_maps) {
    load.keyframes += local_map.map.keyframes().size();
    load.map_points += local_map.map.points().size();
    load.retired_keyframes += local_map.retired_keyframes;
    load.faded_points += local_map.faded_points;
  }
  load.memory_bytes = EstimateMemory(state);
  load.overlaps_queried = state.statistics.overlaps_queried;
  load.overlaps_verified = state.statistics.overlaps_verified;
  load.overlaps_accepted = state.statistics.overlaps_accepted;
  load.failed_requests = state.statistics.failed_requests;
  return load;
}

}  // namespace

Mission::Mission(std::string name, MissionEnvironment environment)
    : strand_(std::move(name), std::move(environment)),
      profile_(strand_),
      events_(strand_.environment().clock, strand_.name()),
      sessions_(strand_, events_),
      batches_(strand_, sessions_.listeners(), events_),
      localised_(strand_),
      pictures_(strand_),
      fusion_(strand_, events_, [this] { sessions_.listeners().CallAllBut(0); }),
      retiring_(strand_, fusion_, [this] { sessions_.listeners().CallAllBut(0); }),
      joining_(strand_, fusion_, retiring_, [this] { sessions_.listeners().CallAllBut(0); }),
      snapshots_(strand_) {}

MissionInfo Mission::Info() const {
  MissionInfo info = WithState(DescribeMission);
  info.fusion_idle = fusion_.IsIdle() && !retiring_.IsDue() && !joining_.IsDue();
  info.profile = profile_.Get();
  return info;
}

MissionLoad Mission::Load() const {
  MissionLoad load = WithState(&MeasureLoad);
  load.mission = strand_.name();
  load.disk_bytes = strand_.environment().journal->DiskBytes(strand_.name());
  load.waiting = fusion_.CountWaiting();
  const MissionStrand::WriteTimes writes = strand_.write_times();
  load.written_s = absl::ToDoubleSeconds(writes.total);
  load.longest_write_s = absl::ToDoubleSeconds(writes.longest);
  return load;
}

bool Mission::IsWatched() const {
  return sessions_.listeners().has_of_map() || events_.listeners().has_of_map();
}

bool Mission::IsVacant() const {
  return strand_.appended() == 0 && !IsWatched() &&
         WithState([](const MissionState& state) { return state.local_maps.empty(); });
}

absl::Status Mission::CheckMaySleep() const {
  const Journal& journal = *strand_.environment().journal;
  const auto refuse = [this](absl::string_view why) {
    return absl::FailedPreconditionError(
        absl::StrCat("mission ", strand_.name(), " stays in memory: ", why));
  };
  if (!journal.KeepsRecords()) return refuse("the store has no journal (--data-dir)");
  if (strand_.IsDeleted()) return refuse("it is being deleted");
  if (!journal.Damage(strand_.name()).ok()) {
    return refuse("its journal is damaged, and only memory has all of it");
  }
  if (IsWatched()) return refuse("somebody watches it (WatchMap, WatchEvents)");
  if (!fusion_.IsIdle() || retiring_.IsDue() || joining_.IsDue())
    return refuse("fusion has work to do");
  return absl::OkStatus();
}

bool Mission::Retire(uint64_t changes) {
  absl::MutexLock turn(&strand_.turn());
  if (!CheckMaySleep().ok()) return false;
  const auto unchanged = [&] {
    absl::ReaderMutexLock lock(&strand_.mutex());
    return strand_.changes() == changes;
  };
  if (!unchanged()) return false;
  strand_.MarkDeleted();
  return true;
}

MissionSummary Mission::Summarise() const {
  return {.info = Info(),
          .load = Load(),
          .work_left = fusion_.HasWork(),
          .retired = retiring_.IsDone()};
}

void Mission::RefuseRobots(const absl::Status& why) {
  strand_.Refuse(why);
  CallListeners();
}

void Mission::Lose(const absl::Status& why) {
  // Robots hear of it at once, whoever has the turn.
  RefuseRobots(why);
  Delete();
}

void Mission::Close(const absl::Status& why) {
  strand_.Refuse(why);
  EndWriting([] { return absl::OkStatus(); }).IgnoreError();
}

void Mission::Delete() {
  DeleteIf([] { return absl::OkStatus(); }).IgnoreError();
}

absl::Status Mission::DeleteIf(const std::function<absl::Status()>& may) {
  RETURN_IF_ERROR(EndWriting(may));
  CallListeners();
  return absl::OkStatus();
}

absl::Status Mission::EndWriting(const std::function<absl::Status()>& may) {
  {
    absl::MutexLock turn(&strand_.turn());
    RETURN_IF_ERROR(may());
    strand_.MarkDeleted();
    fusion_.Stop();
  }
  // A snapshot that has begun must not be written after the deletion.
  snapshots_.WaitForEnd();
  return absl::OkStatus();
}

void Mission::CallListeners() {
  listeners().CallAllBut(0);
  events_.listeners().CallAllBut(0);
}

}  // namespace corbslam::map_store
