// Where the map store writes what it has acknowledged and committed, in order, so that it can be
// read again after a crash. The durable implementation is another one; this one only counts.
#ifndef CORBSLAM_MAP_STORE_JOURNAL_H_
#define CORBSLAM_MAP_STORE_JOURNAL_H_

#include <cstdint>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "slam/exchange/fusion_worker.h"
#include "slam/exchange/map_update.h"
#include "slam/exchange/overlap.h"

namespace corbslam {

// A batch that passed validation.
struct BatchRecord {
  std::string mission;
  std::string agent;
  std::shared_ptr<const MapUpdateBatch> batch;
};
// The verdicts of one query.
struct OverlapRecordSet {
  std::string mission;
  KeyframeId query;
  std::vector<Overlap> overlaps;
};
// What one committed revision set, in the frame of the island that `anchor` belongs to.
struct RevisionRecord {
  std::string mission;
  uint64_t revision = 0;
  LocalMapId anchor;
  std::vector<LocalMapId> local_maps;
  std::vector<KeyframePose> poses;
  std::vector<PointPosition> positions;
  std::vector<FuseMapsResult::Merge> merges;
  std::vector<RejectedObservation> rejected;
};
struct MissionDeletedRecord {
  std::string mission;
};
using JournalRecord =
    std::variant<BatchRecord, OverlapRecordSet, RevisionRecord, MissionDeletedRecord>;

// Thread-safe.
class Journal {
 public:
  virtual ~Journal() = default;
  // Returns once the record would survive what this journal promises to survive. Records of one
  // mission are appended one at a time. An error means that nothing was written.
  virtual absl::Status Append(const JournalRecord& record) = 0;
};

// Survives nothing; counts.
class InMemoryJournal : public Journal {
 public:
  absl::Status Append(const JournalRecord& record) override;
  uint64_t records() const;

 private:
  mutable absl::Mutex mutex_;
  uint64_t records_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace corbslam

#endif  // CORBSLAM_MAP_STORE_JOURNAL_H_
