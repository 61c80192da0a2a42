// Keeps batches on disk that neither memory nor the map store holds: the outbox's oldest ones. They
// outlive the process.
#ifndef CORBSLAM_CLIENT_AGENT_SPOOL_SPOOL_H_
#define CORBSLAM_CLIENT_AGENT_SPOOL_SPOOL_H_

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "client_agent/spool/spool_files.h"
#include "client_agent/spool/spool_segment.h"
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
};

struct SpooledBatch {
  uint64_t segment = 0;
  SpoolRecord record;
};

// The spool is not thread-safe; every call may wait for the disk.
class Spool {
 public:
  // Finds what an earlier process left. Torn tails are left out, with a word in the log. Returns
  // FAILED_PRECONDITION where the folder is somebody else's, or of a newer version.
  static absl::StatusOr<std::unique_ptr<Spool>> Open(const SpoolOptions& options,
                                                     std::unique_ptr<SpoolFiles> files,
                                                     BatchCodec codec);

  // Returns what was found, once, in the order in which it was written.
  std::vector<SpooledBatch> TakeFound() { return std::exchange(found_, {}); }

  // Returns RESOURCE_EXHAUSTED where there is no room, by `max_bytes` or on the disk; the spool is
  // as it was before.
  absl::StatusOr<SpooledBatch> Append(const MapUpdateBatch& batch);
  // Makes what was appended survive a loss of power. After an error, what was appended since the
  // last call is to be appended again.
  absl::Status Sync();
  // Returns DATA_LOSS where the disk has not kept the batch.
  absl::StatusOr<MapUpdateBatch> Read(const SpooledBatch& batch);
  // Releases a batch that is not needed any more. The last one of a segment takes the segment with
  // it.
  void Release(const SpooledBatch& batch);

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
  absl::Status StartSegment();
  // Cuts off the end of the open segment that belongs to no whole record.
  void CutOpenSegment();
  void RemoveSegment(uint64_t number);

  const SpoolOptions options_;
  const std::unique_ptr<SpoolFiles> files_;
  const BatchCodec codec_;
  std::vector<SpooledBatch> found_;
  std::map<uint64_t, Segment> segments_;
  uint64_t next_segment_ = 1;
  uint64_t open_segment_ = 0;  // 0: no segment is open.
  bool unsynced_ = false;
  uint64_t bytes_ = 0;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SPOOL_SPOOL_H_
