// A journal for tests that keeps one mission's records as bytes, good or bad.
#ifndef CORBSLAM_MAP_STORE_TESTING_BYTE_JOURNAL_H_
#define CORBSLAM_MAP_STORE_TESTING_BYTE_JOURNAL_H_

#include <cstddef>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "map_store/archive/feature_archive.h"
#include "map_store/archive/record_archive.h"
#include "map_store/archive/state_archive.h"
#include "map_store/records/journal.h"
#include "slam/util/status_macros.h"

namespace corbslam::testing {

// What is on the disk. It outlives the stores that are opened on it.
struct JournalBytes {
  std::string mission = "m";
  std::string snapshot;  // As EncodeState makes it; empty: none.
  map_store::Journal::Position snapshot_position = 0;
  std::vector<std::string> records;  // Those since the snapshot.
  std::map<KeyframeId, std::string> features;
  std::string other_features;  // The features of all other keyframes.
  bool wants_snapshot = false;
};

class ByteJournal : public map_store::Journal {
 public:
  explicit ByteJournal(std::shared_ptr<JournalBytes> bytes) : bytes_(std::move(bytes)) {}

  void Prepare(map_store::BatchRecord&) const override {}
  void Prepare(map_store::AdjustRecord& record) const override {
    record.plan_bytes =
        std::make_shared<const map_store::PlanBytes>(map_store::EncodePlan(record.plan));
  }
  absl::StatusOr<Position> Append(absl::string_view,
                                  const map_store::JournalRecord& record) override {
    if (const auto* update = std::get_if<map_store::BatchRecord>(&record)) {
      for (const FullKeyframe& keyframe : update->batch->full_keyframes) {
        const KeyframePayload& payload = *keyframe.payload;
        bytes_->features[payload.id] = map_store::EncodeFeatures(payload);
      }
    }
    bytes_->records.push_back(map_store::EncodeRecord(record));
    return bytes_->snapshot_position + bytes_->records.size();
  }
  absl::Status Sync(absl::string_view, Position) override { return absl::OkStatus(); }
  bool WantsSnapshot(absl::string_view) const override { return bytes_->wants_snapshot; }
  absl::Status WriteSnapshot(absl::string_view,
                             const map_store::JournalSnapshot& snapshot) override {
    bytes_->snapshot = snapshot.state;
    const auto begin = bytes_->records.begin();
    bytes_->records.erase(
        begin, begin + static_cast<ptrdiff_t>(snapshot.position - bytes_->snapshot_position));
    bytes_->snapshot_position = snapshot.position;
    return absl::OkStatus();
  }
  absl::Status CreateMission(absl::string_view mission,
                             const map_store::MissionState& state) override {
    bytes_->mission = std::string(mission);
    bytes_->snapshot = map_store::EncodeState(state);
    for (const auto& [id, local_map] : state.local_maps) {
      for (const auto& [keyframe, item] : local_map.map.keyframes()) {
        bytes_->features[keyframe] = map_store::EncodeFeatures(*item.payload);
      }
    }
    return absl::OkStatus();
  }
  absl::StatusOr<std::vector<std::string>> ListMissions() const override {
    return std::vector<std::string>{bytes_->mission};
  }
  absl::StatusOr<Position> Recover(absl::string_view, const Replay& replay) const override {
    map_store::FeatureLoader load;
    if (replay.with_features) {
      load = [this](KeyframeId id) {
        const auto it = bytes_->features.find(id);
        return map_store::DecodeFeatures(it == bytes_->features.end() ? bytes_->other_features
                                                                      : it->second);
      };
    }
    Position position = bytes_->snapshot_position;
    if (!bytes_->snapshot.empty()) {
      ASSIGN_OR_RETURN(map_store::MissionState state,
                       map_store::DecodeState(bytes_->snapshot, load));
      RETURN_IF_ERROR(replay.on_snapshot(std::move(state)));
    }
    for (const std::string& bytes : bytes_->records) {
      if (position == replay.until) break;
      ++position;
      ASSIGN_OR_RETURN(const map_store::JournalRecord record, map_store::DecodeRecord(bytes, load));
      RETURN_IF_ERROR(replay.on_record(record));
    }
    return position;
  }
  absl::Status DeleteMission(absl::string_view) override { return absl::OkStatus(); }
  absl::Status CheckWritable() override { return absl::OkStatus(); }

 private:
  const std::shared_ptr<JournalBytes> bytes_;
};

}  // namespace corbslam::testing

#endif  // CORBSLAM_MAP_STORE_TESTING_BYTE_JOURNAL_H_
