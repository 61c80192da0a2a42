#include "client_agent/source/bag/files/chunk_store.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "client_agent/source/bag/files/unpack.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

// Left and right pictures may lie in two chunks each.
constexpr size_t kMostUnpackedChunks = 4;
constexpr uint64_t kMostUnpackedBytes = uint64_t{512} << 20;

uint64_t BytesOf(const std::deque<std::pair<uint32_t, std::shared_ptr<const BagBytes>>>& chunks) {
  uint64_t bytes = 0;
  for (const auto& [number, chunk] : chunks) bytes += chunk->size();
  return bytes;
}

}  // namespace

absl::StatusOr<std::shared_ptr<const BagBytes>> ChunkStore::UnpackChunk(uint32_t number) const {
  const PackedChunk& chunk = chunks_[number];
  ASSIGN_OR_RETURN(const std::string packed,
                   file_->Read(chunk.offset, chunk.packed_size, "a chunk"));
  absl::StatusOr<std::string> bytes = Unpack(chunk.compression, packed, chunk.size);
  if (!bytes.ok()) {
    return absl::Status(
        bytes.status().code(),
        file_->ErrorAt(chunk.offset, absl::StrCat("a chunk: ", bytes.status().message()))
            .message());
  }
  return std::make_shared<const BagBytes>(absl::StrCat(file_->name(), ": chunk at ", chunk.offset),
                                          *std::move(bytes));
}

absl::StatusOr<std::shared_ptr<const BagBytes>> ChunkStore::Chunk(uint32_t number) const {
  absl::MutexLock lock(&mutex_);
  const auto found = std::find_if(unpacked_.begin(), unpacked_.end(),
                                  [&](const auto& known) { return known.first == number; });
  if (found != unpacked_.end()) {
    std::rotate(unpacked_.begin(), found, found + 1);
    return unpacked_.front().second;
  }
  ASSIGN_OR_RETURN(std::shared_ptr<const BagBytes> chunk, UnpackChunk(number));
  unpacked_.emplace_front(number, chunk);
  while (unpacked_.size() > kMostUnpackedChunks ||
         (unpacked_.size() > 1 && BytesOf(unpacked_) > kMostUnpackedBytes)) {
    unpacked_.pop_back();
  }
  return chunk;
}

absl::StatusOr<std::string> ChunkStore::Read(const BagPlace& place) const {
  if (place.chunk == BagPlace::kNoChunk) return file_->Read(place.offset, place.size, "a message");
  ASSIGN_OR_RETURN(const std::shared_ptr<const BagBytes> chunk, Chunk(place.chunk));
  return chunk->Read(place.offset, place.size, "a message");
}

}  // namespace corbslam::client_agent
