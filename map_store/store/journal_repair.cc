#include "map_store/store/journal_repair.h"

#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "map_store/archive/mission_archive.h"
#include "map_store/ingest/batch_application.h"
#include "map_store/ingest/batch_validation.h"
#include "map_store/mission/mission_strand.h"
#include "map_store/rocks/folder_lock.h"
#include "map_store/rocks/journal_folder.h"
#include "slam/util/atomic_file.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

constexpr size_t kRepairedPieceBytes = 1 << 20;

// Returns the keyframe whose place the removed one's is known by: its parent, else one that hangs
// on it, else any other. Null: it is the only one.
const Keyframe* FindHeir(const Map& map, const Keyframe& removed) {
  if (const Keyframe* parent = map.FindKeyframe(removed.parent)) return parent;
  if (!removed.children.empty()) return map.FindKeyframe(*removed.children.begin());
  for (const auto& [id, keyframe] : map.keyframes()) {
    if (id != removed.id()) return &keyframe;
  }
  return nullptr;
}

// Removes the keyframe as its owner would, but for the number of the owner's last batch.
void RemoveFrom(MissionState& state, LocalMapState& local_map, const Keyframe& keyframe) {
  MapUpdateBatch batch;
  batch.local_map = local_map.id;
  batch.number = local_map.last_batch;
  KeyframeRemoval removal;
  removal.id = keyframe.id();
  if (const Keyframe* heir = FindHeir(local_map.map, keyframe)) {
    removal.parent = heir->id();
    removal.parent_from_removed = heir->camera_from_map * keyframe.camera_from_map.Inverse();
  }
  batch.removed_keyframes.push_back(removal);
  const uint64_t bytes = local_map.stored_bytes;
  map_store::ApplyBatch(batch, {}, MapStoreOptions::WithoutBatchLimits(), state, local_map);
  local_map.stored_bytes = bytes;
}

// Returns how many keyframes were left out.
size_t LeaveOut(const std::map<KeyframeId, std::string>& keyframes, MissionState& state) {
  size_t left_out = 0;
  for (const auto& [id, why] : keyframes) {
    LocalMapState* local_map = state.FindLocalMap(id.local_map);
    const Keyframe* keyframe = local_map == nullptr ? nullptr : local_map->map.FindKeyframe(id);
    if (keyframe == nullptr) continue;
    RemoveFrom(state, *local_map, *keyframe);
    ++left_out;
  }
  return left_out;
}

absl::StatusOr<MissionState> ReadState(SalvagedJournal& journal, const std::string& mission) {
  const MapStoreOptions options = MapStoreOptions::WithoutBatchLimits();
  MissionEnvironment environment;
  environment.options = &options;
  environment.journal = &journal;
  environment.clock = &absl::Now;
  environment.wake_fusion = [] {};
  MissionStrand strand(mission, std::move(environment));
  RETURN_IF_ERROR(strand.Recover());
  StateWriteLock lock(strand);
  return std::move(strand.mutable_state());
}

// Reads what there is; where nothing can be read, what files hold that are older than the lost
// ones.
absl::StatusOr<MissionState> Salvage(const std::string& path, const std::string& mission,
                                     const std::string& scratch, SalvageReport& report) {
  using Way = SalvagedJournal::Way;
  MissionState state;
  for (const Way way : {Way::kAsItIs, Way::kBestEfforts}) {
    ASSIGN_OR_RETURN(const std::unique_ptr<SalvagedJournal> journal,
                     SalvagedJournal::Open(mission, path, scratch, way));
    ASSIGN_OR_RETURN(state, ReadState(*journal, mission));
    report = journal->report();
    if (!state.local_maps.empty() || !report.not_opened.ok()) break;
  }
  return state;
}

absl::StatusOr<uint64_t> WriteBackup(const MissionState& state, const std::string& path) {
  MissionBackup backup(state);
  // What can't be read back is no backup.
  MissionRestorer again(std::numeric_limits<uint64_t>::max());
  ASSIGN_OR_RETURN(AtomicFile file, AtomicFile::Create(path));
  uint64_t bytes = 0;
  for (std::string piece = backup.Next(kRepairedPieceBytes); !piece.empty();
       piece = backup.Next(kRepairedPieceBytes)) {
    RETURN_IF_ERROR(again.Add(piece));
    RETURN_IF_ERROR(file.Append(piece));
    bytes += piece.size();
  }
  const absl::Status whole = again.Finish().status();
  if (!whole.ok()) {
    return absl::DataLossError(absl::StrCat(
        "what can be had of the mission does not fit together, and no file was written: ",
        whole.message()));
  }
  RETURN_IF_ERROR(file.Finish());
  return bytes;
}

absl::Status CheckPaths(const std::string& directory, const std::string& mission,
                        const std::string& file) {
  RETURN_IF_ERROR(map_store::ValidateName("mission", mission));
  if (IsWithin(directory, file)) {
    return absl::InvalidArgumentError(
        absl::StrCat("--to is ", file, ", within ", directory, ", of which nothing is changed"));
  }
  std::error_code error;
  if (std::filesystem::exists(file, error)) {
    return absl::AlreadyExistsError(absl::StrCat("there is a file ", file, " already"));
  }
  const std::string path = JournalFolder(directory).PathOf(mission);
  if (std::filesystem::is_directory(path, error)) return absl::OkStatus();
  return absl::NotFoundError(
      absl::StrCat("there is no folder ", path, ": the store has no such mission"));
}

}  // namespace

absl::StatusOr<RepairReport> RepairMission(const std::string& directory, const std::string& mission,
                                           const std::string& file) {
  ASSIGN_OR_RETURN(const std::unique_ptr<FolderLock> lock, FolderLock::Take(directory));
  RETURN_IF_ERROR(CheckPaths(directory, mission, file));
  RepairReport report;
  ASSIGN_OR_RETURN(MissionState state, Salvage(JournalFolder(directory).PathOf(mission), mission,
                                               file + ".scratch", report.salvage));
  if (state.local_maps.empty()) {
    return absl::DataLossError(absl::StrCat(
        "nothing of mission ", mission, " can be had: ",
        report.salvage.ended.ok() ? "there is no record" : report.salvage.ended.message()));
  }
  report.left_out = LeaveOut(report.salvage.without_features, state);
  report.agents = state.agents.size();
  report.local_maps = state.local_maps.size();
  for (const auto& [id, local_map] : state.local_maps) {
    report.keyframes += local_map.map.keyframes().size();
  }
  ASSIGN_OR_RETURN(report.bytes, WriteBackup(state, file));
  return report;
}

}  // namespace corbslam::map_store
