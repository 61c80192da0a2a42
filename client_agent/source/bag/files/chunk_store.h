// The chunks of a file, unpacked when a message in them is wanted; the last few stay.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_BAG_FILES_CHUNK_STORE_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_BAG_FILES_CHUNK_STORE_H_

#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "client_agent/source/bag/files/bag_bytes.h"
#include "client_agent/source/bag/files/bag_file.h"

namespace corbslam::client_agent {

struct PackedChunk {
  uint64_t offset = 0;  // Where its packed bytes begin.
  uint64_t packed_size = 0;
  uint64_t size = 0;
  std::string compression;
};

// Add is called by one thread, before others read.
class ChunkStore {
 public:
  explicit ChunkStore(std::unique_ptr<const BagBytes> file) : file_(std::move(file)) {}

  const BagBytes& file() const { return *file_; }
  // Returns the chunk's number.
  uint32_t Add(PackedChunk chunk) {
    chunks_.push_back(std::move(chunk));
    return static_cast<uint32_t>(chunks_.size() - 1);
  }
  // Returns what is in the chunk. Errors name the file and the offset.
  absl::StatusOr<std::shared_ptr<const BagBytes>> Chunk(uint32_t number) const;
  absl::StatusOr<std::string> Read(const BagPlace& place) const;

 private:
  absl::StatusOr<std::shared_ptr<const BagBytes>> UnpackChunk(uint32_t number) const;

  const std::unique_ptr<const BagBytes> file_;
  std::vector<PackedChunk> chunks_;
  mutable absl::Mutex mutex_;
  // Newest first.
  mutable std::deque<std::pair<uint32_t, std::shared_ptr<const BagBytes>>> unpacked_
      ABSL_GUARDED_BY(mutex_);
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_BAG_FILES_CHUNK_STORE_H_
