// The map store writes into a journal what changes its missions, in order, so that they can be had
// again after a crash.
#ifndef CORBSLAM_MAP_STORE_RECORDS_JOURNAL_H_
#define CORBSLAM_MAP_STORE_RECORDS_JOURNAL_H_

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/synchronization/mutex.h"
#include "map_store/records/journal_records.h"
#include "map_store/records/picture_cache.h"
#include "slam/exchange/uplink.h"

namespace corbslam::map_store {

class MissionLeases;

// A mission's state after all records up to a position.
struct JournalSnapshot {
  uint64_t position = 0;
  std::string state;  // As EncodeState makes it.
  // Keyframes whose features are still needed, each once, in any order: a local map that others
  // became parts of has keyframes of several names.
  std::vector<KeyframeId> keyframes;
};

// One of the missions that had a name; an empty uid: nobody knows it.
struct MissionIdentity {
  std::string name;
  std::string uid;
  friend bool operator==(const MissionIdentity&, const MissionIdentity&) = default;
};

// What a journal remembers of missions besides what they are.
enum class MissionList {
  kDeleted,
  kPromised,  // A robot was told its uid, maybe before anything was written of it.
};

// Returns the keyframes that an owner's batch removes; none for other records.
std::vector<KeyframeId> RemovedBy(const JournalRecord& record);

// Keeps the records of missions; records of one mission are appended one at a time. Thread-safe.
class Journal {
 public:
  // Names an append; it grows with each of its mission.
  using Position = uint64_t;

  struct Replay {
    // Called once at most, before all records, with the state that a snapshot held.
    std::function<absl::Status(MissionState)> on_snapshot;
    // Called for each record since the snapshot, in order.
    std::function<absl::Status(const JournalRecord&)> on_record;
    // Records after this position are left out.
    Position until = std::numeric_limits<Position>::max();
    // False: a snapshot's keyframes come with empty features, a record's with as many as there are,
    // all zero. A replay that does not need features then costs a fraction.
    bool with_features = true;
  };

  virtual ~Journal() = default;

  // Makes of the batch's record what Append will write. That is most of the work and needs no order
  // among callers; Append does it where it was not done. The record is not changed afterwards.
  virtual void Prepare(BatchRecord& record) const = 0;
  // Makes of the record's plan what Append will write; the same holds. The rest of the record may
  // still change.
  virtual void Prepare(AdjustRecord& record) const = 0;
  // Puts the record behind the ones before it. An error means that nothing was written:
  // RESOURCE_EXHAUSTED (no room), UNAVAILABLE (the disk refuses), each naming the journal.
  virtual absl::StatusOr<Position> Append(absl::string_view mission,
                                          const JournalRecord& record) = 0;
  // Returns once everything of the mission up to the position would survive what this journal
  // promises to survive. An error means that it is not certain.
  virtual absl::Status Sync(absl::string_view mission, Position position) = 0;

  // Returns whether so much was appended to the mission since its last snapshot that another one is
  // worth while.
  virtual bool WantsSnapshot(absl::string_view mission) const = 0;
  // Writes a snapshot in the place of all the mission's records up to its position.
  virtual absl::Status WriteSnapshot(absl::string_view mission,
                                     const JournalSnapshot& snapshot) = 0;

  // Begins a mission with a state that was made elsewhere, as a snapshot and the features of its
  // keyframes. All of it or nothing is durable. The caller does this for one mission once at a
  // time, and never for a mission that has records.
  virtual absl::Status CreateMission(absl::string_view mission, const MissionState& state) = 0;

  virtual absl::StatusOr<std::vector<std::string>> ListMissions() const = 0;
  // Returns whether Recover replays what was appended.
  virtual bool KeepsRecords() const { return true; }
  // Replays a mission. Returns the position of the last record that was replayed; 0 for a mission
  // without records. DATA_LOSS, naming the mission and the place, for what can't be read.
  virtual absl::StatusOr<Position> Recover(absl::string_view mission,
                                           const Replay& replay) const = 0;
  // The deletion is durable when this returns.
  virtual absl::Status DeleteMission(absl::string_view mission) = 0;

  // So many missions of a list are remembered, the last ones.
  static constexpr size_t kMaxListed = 10'000;
  // Adds the mission to the list, durably as far as this journal is.
  virtual absl::Status NoteInList(MissionList, const MissionIdentity&) { return absl::OkStatus(); }
  // Returns what is remembered, the oldest first.
  virtual std::vector<MissionIdentity> ReadList(MissionList) const { return {}; }

  // A mission that is put aside takes no memory and no open files. Recover brings it back, and
  // nothing else does but DeleteMission: until then all that would write returns UNAVAILABLE. The
  // caller does these three for one mission one at a time.

  // Gives back to the disk what the mission needs no more, so that it lies aside without.
  virtual void TidyUp(absl::string_view) {}
  // Puts the mission aside, and keeps `summary`, bytes of the caller's, durably beside it, for as
  // long as nothing opens the mission again. An error: it is aside, and no summary is kept.
  virtual absl::Status PutAside(absl::string_view, absl::string_view summary) {
    (void)summary;
    return absl::OkStatus();
  }
  // Returns the summary of a mission that is aside. NOT_FOUND: the mission is not aside.
  virtual absl::StatusOr<std::string> ReadSummary(absl::string_view mission) const {
    return absl::NotFoundError(std::string(mission));
  }

  // Pictures of keyframes are for people: they are kept as far as there is room, and nothing of a
  // map needs one.

  // Keeps the picture, unless its keyframe has one; beyond `max_bytes` of them the mission's oldest
  // go. It outlives the process sometime, as the next records do. An error: it is not kept.
  virtual absl::Status PutPicture(absl::string_view, const KeyframePicture&, uint64_t max_bytes) {
    (void)max_bytes;
    return absl::UnimplementedError("this journal keeps no pictures");
  }
  // Returns what is kept of the keyframe. NOT_FOUND: nothing.
  virtual absl::StatusOr<KeyframePicture> ReadPicture(absl::string_view,
                                                      KeyframeId keyframe) const {
    return absl::NotFoundError("there is no picture of keyframe " + ToString(keyframe));
  }
  // Calls `visit` with each of the mission's pictures, the oldest first, until it returns an error.
  virtual absl::Status ForEachPicture(
      absl::string_view,
      const std::function<absl::Status(const KeyframePicture& picture)>& visit) const {
    (void)visit;
    return absl::OkStatus();
  }

  // Returns OK if the journal takes records now, else the error that Append would give. After a
  // failed write the journal finds out by trying, so that somebody should call this now and then.
  virtual absl::Status CheckWritable() = 0;

  // Returns DATA_LOSS, naming the file and the place, once something of the mission was found
  // damaged: nothing is appended to it any more. Other missions are none the worse for it.
  virtual absl::Status Damage(absl::string_view) const { return absl::OkStatus(); }
  // Returns how many bytes the mission takes of the disk.
  virtual uint64_t DiskBytes(absl::string_view) const { return 0; }

  // Returns who decides which process has a mission (mission_leases.h); null: this one has all.
  virtual MissionLeases* leases() { return nullptr; }
  // Reads a mission's part of a list again, where other processes add to it, the oldest first.
  virtual absl::StatusOr<std::vector<MissionIdentity>> ReadListOf(MissionList list,
                                                                  absl::string_view) const {
    return ReadList(list);
  }
};

// Keeps nothing but some pictures, and only counts: a journal for tests and for stores without a
// disk. Thread-safe.
class InMemoryJournal : public Journal {
 public:
  void Prepare(BatchRecord&) const override {}
  void Prepare(AdjustRecord&) const override {}
  absl::StatusOr<Position> Append(absl::string_view mission, const JournalRecord& record) override;
  absl::Status Sync(absl::string_view, Position) override { return absl::OkStatus(); }
  bool WantsSnapshot(absl::string_view) const override { return false; }
  absl::Status WriteSnapshot(absl::string_view, const JournalSnapshot&) override {
    return absl::OkStatus();
  }
  absl::Status CreateMission(absl::string_view, const MissionState&) override {
    return absl::OkStatus();
  }
  absl::StatusOr<std::vector<std::string>> ListMissions() const override {
    return std::vector<std::string>();
  }
  absl::StatusOr<Position> Recover(absl::string_view, const Replay&) const override { return 0; }
  bool KeepsRecords() const override { return false; }
  absl::Status DeleteMission(absl::string_view mission) override {
    pictures_.RemoveMission(mission);
    return absl::OkStatus();
  }
  absl::Status PutPicture(absl::string_view mission, const KeyframePicture& picture,
                          uint64_t max_bytes) override {
    pictures_.Put(mission, picture, max_bytes);
    return absl::OkStatus();
  }
  absl::StatusOr<KeyframePicture> ReadPicture(absl::string_view mission,
                                              KeyframeId keyframe) const override {
    return pictures_.Read(mission, keyframe);
  }
  absl::Status CheckWritable() override { return absl::OkStatus(); }

  uint64_t records() const;

 private:
  PictureCache pictures_;
  mutable absl::Mutex mutex_;
  uint64_t records_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_RECORDS_JOURNAL_H_
