// Reads and writes one file of the spool: its owner, then batches, each with its length and
// checksum.
//
//   header: "CORBSPL" and the version '3', u32 bytes of the owner, u32 CRC-32C of the owner, owner
//   record: u32 CRC-32C of all that follows in the record, u32 bytes of the payload, u32 flags
//           (1: closes its local map; 2: a part of what its local map is after batch `number`;
//           4: the last part of it; 8: a keyframe that is in no batch yet; 16: what else is in
//           none), u64 local map, u64 number, payload
//
// All numbers are little-endian. Versions '1', in which no features are coded, and '2', in which
// all records are batches, are read, too.
#ifndef CORBSLAM_CLIENT_AGENT_SPOOL_SPOOL_SEGMENT_H_
#define CORBSLAM_CLIENT_AGENT_SPOOL_SPOOL_SEGMENT_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "client_agent/spool/spool_files.h"
#include "slam/util/ids.h"

namespace corbslam::client_agent {

// Bytes of one record's payload at most; a record that claims to be longer is torn.
inline constexpr uint32_t kMaxSpoolPayloadBytes = 128u << 20;

struct SpoolRecord {
  // A snapshot of a local map stands in place of all its batches up to `number`: in one or more
  // parts, one after the other. What is in no batch yet after batch
  // `number` (HeldBackItems) lies in a record of its own, its keyframes in others, whose `number`
  // is the keyframe's index and 1.
  enum class Kind { kBatch, kSnapshotPart, kSnapshotEnd, kHeldBackKeyframe, kHeldBackRest };
  Kind kind = Kind::kBatch;
  LocalMapId local_map;
  uint64_t number = 0;
  bool closes_local_map = false;
  // Where the whole record lies within its segment.
  uint64_t offset = 0;
  uint32_t bytes = 0;
};

struct SegmentContents {
  std::vector<SpoolRecord> records;
  // Bytes at the end that belong to no whole record.
  uint64_t torn_bytes = 0;
};

std::string EncodeSegmentHeader(absl::string_view owner);
std::string EncodeSpoolRecord(const SpoolRecord& record, absl::string_view payload);

// Returns all whole records from the beginning to the first that is not. Returns
// FAILED_PRECONDITION where the segment is somebody else's, of a newer version, or no segment.
absl::StatusOr<SegmentContents> ScanSegment(SpoolFiles& files, const std::string& name,
                                            absl::string_view owner);

// Returns the payload of a record. Returns DATA_LOSS where its bytes are not what was written.
absl::StatusOr<std::string> ReadSpoolPayload(SpoolFiles& files, const std::string& name,
                                             const SpoolRecord& record);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SPOOL_SPOOL_SEGMENT_H_
