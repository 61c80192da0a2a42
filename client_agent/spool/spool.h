// Keeps batches on the robot's disk: those that the map store has not acknowledged, and those from
// which the robot's map can be made again. They outlive the process.
#ifndef CORBSLAM_CLIENT_AGENT_SPOOL_SPOOL_H_
#define CORBSLAM_CLIENT_AGENT_SPOOL_SPOOL_H_

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "client_agent/spool/spool_files.h"
#include "client_agent/spool/spool_segment.h"
#include "client_agent/spool/spool_syncer.h"
#include "slam/exchange/map_update.h"

namespace corbslam::client_agent {

// Turns batches into bytes that can be read by themselves, and back.
struct BatchCodec {
  std::function<std::string(const MapUpdateBatch&)> encode;
  std::function<absl::StatusOr<MapUpdateBatch>(absl::string_view)> decode;
};

struct SpoolOptions {
  // Mission and agent whose batches these are. A folder with another owner's is refused.
  std::string owner;
  uint64_t max_bytes = uint64_t{1} << 30;
  // Size at which a segment is followed by another one. Room is given back by whole segments.
  uint64_t segment_bytes = 8u << 20;
  // A thread makes what was appended survive a loss of power, within this time; none: Sync alone
  // does.
  std::optional<SyncPolicy> sync = std::nullopt;
};

struct SpooledBatch {
  uint64_t segment = 0;
  SpoolRecord record;
  // Counts the records that this process appended, from 1 on; 0: an earlier process did.
  uint64_t order = 0;
};

// One thread at a time may use the spool, but for Read, which may run beside all else; every call
// may wait for the disk.
class Spool {
 public:
  // Finds what an earlier process left. Torn tails are left out, with a word in the log. Returns
  // FAILED_PRECONDITION where the folder is somebody else's, or of a newer version.
  static absl::StatusOr<std::unique_ptr<Spool>> Open(const SpoolOptions& options,
                                                     std::unique_ptr<SpoolFiles> files,
                                                     BatchCodec codec);

  // Returns what was found, once, in the order in which it was written.
  std::vector<SpooledBatch> TakeFound() { return std::exchange(found_, {}); }
  // Returns the same without taking it.
  const std::vector<SpooledBatch>& found() const { return found_; }
  // Puts other records of the spool in its place.
  void SetFound(std::vector<SpooledBatch> found) { found_ = std::move(found); }

  // Returns RESOURCE_EXHAUSTED where there is no room, by `max_bytes` or on the disk; the spool is
  // as it was before.
  absl::StatusOr<SpooledBatch> Append(const MapUpdateBatch& batch,
                                      SpoolRecord::Kind kind = SpoolRecord::Kind::kBatch);
  // Makes what was appended survive a loss of power. After an error, what was appended after
  // `synced` is to be appended again.
  absl::Status Sync();
  // With SpoolOptions::sync: has its thread do so now, without waiting. Without: does what Sync
  // does, and leaves an error for TakeSyncError.
  void HurrySync();
  // Returns why that thread could not, once; it means what an error of Sync means.
  absl::Status TakeSyncError();
  // Returns up to which SpooledBatch::order a loss of power takes nothing.
  uint64_t synced() const;
  // Returns how often the disk was made to keep something.
  uint64_t syncs() const;
  // Returns DATA_LOSS where the disk has not kept the batch.
  absl::StatusOr<MapUpdateBatch> Read(const SpooledBatch& batch);
  // Releases a batch that is not needed any more. The last one of a segment takes the segment with
  // it.
  void Release(const SpooledBatch& batch);
  // Releases a batch for which something stands in that was appended by now: once a loss of power
  // takes nothing of that. Without SpoolOptions::sync nobody promises that, and it is done at once.
  void ReleaseOnceSynced(const SpooledBatch& batch);

  // Returns the bytes that this process appended.
  uint64_t appended_bytes() const { return appended_bytes_; }
  // Returns the bytes of all segments.
  uint64_t bytes() const { return bytes_; }

 private:
  struct Segment {
    uint64_t bytes = 0;
    size_t live = 0;
  };

  Spool(const SpoolOptions& options, std::unique_ptr<SpoolFiles> files, BatchCodec codec);

  absl::Status Recover();
  absl::Status RecoverSegment(const std::string& name);
  absl::Status SyncFound();
  absl::Status StartSegment();
  // Releases what was put off and may go by now.
  void ReleasePutOff();
  // What came after `synced` is to be appended again. Nothing may follow in the open segment, whose
  // end may be torn, and what was put off waits for what is appended in place of the lost.
  void NoteSyncError();
  // Cuts off the end of the open segment that belongs to no whole record.
  void CutOpenSegment();
  void RemoveSegment(uint64_t number);

  const SpoolOptions options_;
  const std::unique_ptr<SpoolFiles> files_;
  const BatchCodec codec_;
  // Null without SpoolOptions::sync.
  std::unique_ptr<SpoolSyncer> syncer_;
  std::vector<SpooledBatch> found_;
  std::map<uint64_t, Segment> segments_;
  // What is to be released, each with the order up to which all is to be synced before; ascending.
  std::deque<std::pair<uint64_t, SpooledBatch>> put_off_;
  uint64_t next_segment_ = 1;
  uint64_t open_segment_ = 0;  // 0: no segment is open.
  uint64_t appended_ = 0;      // SpooledBatch::order of the last one.
  uint64_t appended_bytes_ = 0;
  uint64_t synced_ = 0;  // Without a syncer.
  uint64_t syncs_ = 0;
  absl::Status error_;  // Of HurrySync, without a syncer.
  uint64_t bytes_ = 0;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SPOOL_SPOOL_H_
