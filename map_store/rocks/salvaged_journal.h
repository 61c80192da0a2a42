// Reads of a damaged mission's database what can be had.
#ifndef CORBSLAM_MAP_STORE_ROCKS_SALVAGED_JOURNAL_H_
#define CORBSLAM_MAP_STORE_ROCKS_SALVAGED_JOURNAL_H_

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "map_store/rocks/read_only_journal.h"
#include "slam/features/keypoint.h"
#include "slam/util/ids.h"

namespace corbslam::map_store {
class RocksDatabase;

struct SalvageReport {
  // Why the database could not be opened as it is, so that files newer than the lost ones and the
  // log were left out; OK: it could.
  absl::Status not_opened;
  uint64_t snapshot = 0;  // The position of the snapshot that was read; 0: none.
  uint64_t records = 0;   // That were read and applied.
  uint64_t last = 0;      // The position of the last one.
  uint64_t durable = 0;   // The position of a record that was durable once; 0: not known.
  // Why reading ended; OK: there was nothing more.
  absl::Status ended;
  // Keyframes whose features can't be read, and why. They have stand-ins: as many keypoints, all
  // zero.
  std::map<KeyframeId, std::string> without_features;
};

// Replays the longest beginning of the mission that can be read and applied; an error of a
// replay's functions ends it as damage does. One thread uses it.
class SalvagedJournal : public ReadOnlyJournal {
 public:
  // kAsItIs turns to kBestEfforts by itself where nothing can be opened; where something can, and
  // still nothing be read, the caller does.
  enum class Way { kAsItIs, kBestEfforts };

  // Opens the mission's folder `path`, of which nothing is changed. Where that needs a copy it is
  // made in `scratch`, which must not be there, and is removed with the result. DATA_LOSS: nothing
  // can be opened.
  static absl::StatusOr<std::unique_ptr<SalvagedJournal>> Open(const std::string& mission,
                                                               const std::string& path,
                                                               const std::string& scratch, Way way);
  ~SalvagedJournal() override;

  // Returns the position of the last record that was applied; no error but that nothing at all is
  // there.
  absl::StatusOr<Position> Recover(absl::string_view mission, const Replay& replay) const override;
  const SalvageReport& report() const { return report_; }

 private:
  SalvagedJournal(const std::string& mission, std::string scratch);

  absl::Status OpenDatabase(const std::string& path);
  absl::Status OpenCopy(const std::string& path);
  // Returns the position that the header names, or else the newest one of which there are parts.
  absl::StatusOr<Position> FindSnapshot() const;
  absl::Status ReplaySnapshot(Position position, const Replay& replay) const;
  absl::Status ReplayRecords(Position after, const Replay& replay) const;
  absl::Status ReplayRecord(std::string_view bytes, const Replay& replay) const;
  absl::StatusOr<Features> FeaturesOrStandIn(KeyframeId id, size_t count) const;

  const std::string scratch_;
  bool has_scratch_ = false;
  std::unique_ptr<RocksDatabase> database_;
  // Replays find out what is there.
  mutable SalvageReport report_;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_ROCKS_SALVAGED_JOURNAL_H_
