// Keeps what a journal has of one mission in the tables of a database (schema.h). Records wait in
// memory until somebody syncs, and then go in one transaction, which finds the mission where this
// process left it or is refused.
#ifndef CORBSLAM_MAP_STORE_POSTGRES_POSTGRES_MISSION_H_
#define CORBSLAM_MAP_STORE_POSTGRES_POSTGRES_MISSION_H_

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "map_store/archive/feature_archive.h"
#include "map_store/postgres/mission_row.h"
#include "map_store/postgres/pieces.h"
#include "map_store/postgres/postgres_options.h"
#include "map_store/postgres/sql_pool.h"
#include "map_store/records/journal.h"
#include "map_store/records/mission_contents.h"
#include "map_store/records/picture_book.h"

namespace corbslam::map_store {

// Does for one mission what Journal says; all errors name the database and the mission. Besides
// Journal's errors, FAILED_PRECONDITION: another process writes into the mission, or has deleted
// it; this one does not any more, until it reads the mission anew. UNAVAILABLE: another process
// holds it (PostgresJournalOptions::lease). Both say where it is (FindElsewhere), as far as that is
// known. With a lease, nothing but Recover takes a mission that has records. Thread-safe.
class PostgresMission {
 public:
  using Position = Journal::Position;

  // Where the mission is when this process meets it.
  struct Known {
    int64_t id = 0;
    bool is_made = false;  // It has a row.
    bool is_aside = false;
    uint64_t bytes = 0;  // As the row has it.
  };

  // `pool` must outlive it.
  PostgresMission(std::string name, const PostgresJournalOptions& options, SqlPool* pool,
                  const MissionHolder& holder, const Known& known);

  absl::StatusOr<Position> Append(std::shared_ptr<const BatchBytes> bytes,
                                  const std::vector<KeyframeId>& removed)
      ABSL_LOCKS_EXCLUDED(mutex_);
  absl::Status Sync(Position position) ABSL_LOCKS_EXCLUDED(mutex_);
  // Writes what waits, if the first of it waits since then.
  absl::Status FlushOlderThan(absl::Time then) ABSL_LOCKS_EXCLUDED(mutex_);
  bool WantsSnapshot() const ABSL_LOCKS_EXCLUDED(mutex_);
  absl::Status WriteSnapshot(const JournalSnapshot& snapshot) ABSL_LOCKS_EXCLUDED(mutex_);
  absl::Status Create(const MissionState& state) ABSL_LOCKS_EXCLUDED(mutex_);
  absl::StatusOr<Position> Recover(const Journal::Replay& replay) ABSL_LOCKS_EXCLUDED(mutex_);
  absl::Status Delete() ABSL_LOCKS_EXCLUDED(mutex_);
  void TidyUp();
  absl::Status PutAside(absl::string_view summary) ABSL_LOCKS_EXCLUDED(mutex_);
  absl::StatusOr<std::string> ReadSummary() const ABSL_LOCKS_EXCLUDED(mutex_);

  // Returns whether this process writes into the mission, as far as it knows.
  int64_t id() const { return id_; }
  const std::string& name() const { return name_; }
  bool IsHeld() const ABSL_LOCKS_EXCLUDED(mutex_);
  // Asks the database whether it does; returns FAILED_PRECONDITION, and writes no more, if not.
  // UNAVAILABLE: the database does not answer.
  absl::Status CheckStillHeld() ABSL_LOCKS_EXCLUDED(mutex_);
  // Returns the error of the last write, or that this process does not have the mission any more.
  absl::Status Failure() const ABSL_LOCKS_EXCLUDED(mutex_);
  // Ends this process's lease; the store `wanted`, if it is not empty, is to have the mission.
  absl::Status Release(const std::string& wanted = "") ABSL_LOCKS_EXCLUDED(mutex_);

  absl::Status PutPicture(const KeyframePicture& picture, uint64_t max_bytes)
      ABSL_LOCKS_EXCLUDED(mutex_);
  absl::StatusOr<KeyframePicture> ReadPicture(KeyframeId keyframe) const;
  absl::Status ForEachPicture(
      const std::function<absl::Status(const KeyframePicture& picture)>& visit) const;

  // Tries again what failed; OK if nothing did.
  absl::Status CheckWritable() ABSL_LOCKS_EXCLUDED(mutex_);
  absl::Status Damage() const ABSL_LOCKS_EXCLUDED(mutex_);
  uint64_t DiskBytes() const ABSL_LOCKS_EXCLUDED(mutex_);

 private:
  // A record that is not known to be in the database.
  struct Waiting {
    Position position = 0;
    std::shared_ptr<const BatchBytes> bytes;
    std::vector<BookedPicture> gone;  // Pictures of keyframes that it removes.
    absl::Time since;
  };
  // The records of one transaction.
  struct Group {
    int64_t id = 0;
    Position last = 0;
    std::vector<Waiting> records;
    uint64_t mission_bytes = 0;
  };

  // Reads the mission's row, makes this process the one who writes, and finds out what is there;
  // does nothing when that is done. With `wakes` false: UNAVAILABLE if it lies aside,
  // FAILED_PRECONDITION if it is to be shared and was not taken.
  absl::Status EnsureLoaded(bool wakes = false) ABSL_LOCKS_EXCLUDED(loading_, mutex_);
  absl::Status Load() ABSL_EXCLUSIVE_LOCKS_REQUIRED(loading_) ABSL_LOCKS_EXCLUDED(mutex_);
  absl::StatusOr<MissionRow> TakeOver() ABSL_LOCKS_EXCLUDED(mutex_);
  // Returns UNAVAILABLE while another process holds it.
  absl::Status CheckHeld(const MissionRow& row) const;
  absl::Status LoadContents(const MissionRow& row) ABSL_LOCKS_EXCLUDED(mutex_);
  absl::Status CheckOpen() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  // Writes all up to the position that waits. Several may call it at once: one works for all.
  absl::Status Flush(Position position) ABSL_LOCKS_EXCLUDED(mutex_);
  absl::Status FlushAll() ABSL_LOCKS_EXCLUDED(mutex_);
  SqlOutcome WriteGroup(SqlConnection& connection) ABSL_LOCKS_EXCLUDED(mutex_);
  // Compares the row with what this process knows, and finds out what became of a group whose
  // outcome was unknown.
  absl::Status Settle(const MissionRow& row) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void NoteCommitted(Position last, int64_t group) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  Group TakeGroup() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  SqlStatements StatementsOf(const Group& group) const;
  void AddFeatures(KeyframeId id, absl::string_view features, Position position,
                   SqlStatements& statements) const;
  void AddPictureRemovals(const std::vector<BookedPicture>& gone, SqlStatements& statements) const;
  absl::Status CheckTurn(const MissionRow& row) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  // Epoch 0 stands for any.
  absl::Status DeleteRow(int64_t epoch);
  absl::Status WritePieces(absl::string_view state, int64_t generation);
  // Removes the pieces of a snapshot that has no turn: the mission is another one's.
  void DropPieces(int64_t generation);
  absl::Status WriteFeatures(const MissionState& state);
  absl::Status WriteNewMission(const MissionState& state);
  // Puts a snapshot that is written in the place of the records.
  SqlOutcome Turn(SqlConnection& connection, const JournalSnapshot& snapshot, int64_t generation,
                  const SqlStatements& drops);
  absl::Status ReplaySnapshot(const MissionRow& row, const Journal::Replay& replay) const;
  // Replays the records after `position`, and sets it to the last one's.
  absl::Status ReplayRecords(const MissionRow& row, const Journal::Replay& replay,
                             Position& position) const;
  absl::Status ReplayAll(const Journal::Replay& replay, Position& position) const;
  // Takes the next piece of the record at `of`; `position` is the last one that was replayed.
  static absl::Status ReplayPiece(const Piece& piece, Position of, const Journal::Replay& replay,
                                  const FeatureLoader& load, PieceJoiner& joiner,
                                  Position& position);
  // Drops the payloads that no keyframe has.
  SqlStatement DropUnusedPayloads() const;

  // Adds the mission's name; remembers DATA_LOSS.
  absl::Status Note(const absl::Status& error) ABSL_LOCKS_EXCLUDED(mutex_);
  absl::Status Name(const absl::Status& error) const;
  SqlValue Id() const { return SqlValue::Number(id_); }

  const std::string name_;
  const PostgresJournalOptions options_;
  SqlPool& pool_;
  const MissionHolder holder_;
  const int64_t id_;

  // Held while the mission is read for the first time.
  absl::Mutex loading_ ABSL_ACQUIRED_BEFORE(mutex_);
  mutable absl::Mutex mutex_;
  absl::CondVar flushed_;
  bool is_loaded_ ABSL_GUARDED_BY(mutex_);
  bool is_made_ ABSL_GUARDED_BY(mutex_);
  bool is_aside_ ABSL_GUARDED_BY(mutex_);
  bool is_deleted_ ABSL_GUARDED_BY(mutex_) = false;
  absl::Status damage_ ABSL_GUARDED_BY(mutex_);
  // Of the last write, until one succeeds; FAILED_PRECONDITION stays until the mission is read
  // anew.
  absl::Status failure_ ABSL_GUARDED_BY(mutex_);
  absl::Time failed_at_ ABSL_GUARDED_BY(mutex_) = absl::InfinitePast();
  uint64_t failures_ ABSL_GUARDED_BY(mutex_) = 0;
  int64_t epoch_ ABSL_GUARDED_BY(mutex_) = 1;
  // What is known to be in the database, and what was there before that if it is durable.
  Position head_ ABSL_GUARDED_BY(mutex_) = 0;
  int64_t head_group_ ABSL_GUARDED_BY(mutex_) = 0;
  Position synced_ ABSL_GUARDED_BY(mutex_) = 0;
  Position last_ ABSL_GUARDED_BY(mutex_) = 0;
  std::deque<Waiting> waiting_ ABSL_GUARDED_BY(mutex_);
  uint64_t waiting_bytes_ ABSL_GUARDED_BY(mutex_) = 0;
  bool is_flushing_ ABSL_GUARDED_BY(mutex_) = false;
  // A group of which nobody knows whether it is in the database.
  std::optional<Group> unknown_ ABSL_GUARDED_BY(mutex_);
  MissionContents contents_ ABSL_GUARDED_BY(mutex_);
  PictureBook pictures_ ABSL_GUARDED_BY(mutex_);
  uint64_t bytes_aside_ ABSL_GUARDED_BY(mutex_);  // While it is not loaded.
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_POSTGRES_POSTGRES_MISSION_H_
