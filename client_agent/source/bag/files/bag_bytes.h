// Reads parts of a file that may be larger than memory, or of a chunk that was unpacked.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_BAG_FILES_BAG_BYTES_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_BAG_FILES_BAG_BYTES_H_

#include <cstdint>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace corbslam::client_agent {

// More is read at once, or unpacked, for nobody: no picture and no chunk is larger.
inline constexpr uint64_t kMostBagBytes = uint64_t{256} << 20;

// Immutable: any thread.
class BagBytes {
 public:
  // NOT_FOUND or INVALID_ARGUMENT, naming the file.
  static absl::StatusOr<std::unique_ptr<const BagBytes>> Open(const std::string& path) {
    return Open(path, path);
  }
  // `name` stands for the file in messages.
  static absl::StatusOr<std::unique_ptr<const BagBytes>> Open(const std::string& path,
                                                              const std::string& name);
  // The bytes of a chunk; `name` says for people which.
  BagBytes(std::string name, std::string bytes);
  ~BagBytes();
  BagBytes(const BagBytes&) = delete;
  BagBytes& operator=(const BagBytes&) = delete;

  const std::string& name() const { return name_; }
  uint64_t size() const { return size_; }

  // Returns `count` bytes. INVALID_ARGUMENT names the file, the offset and `what` was to be there,
  // where they are not all there or more than kMostBagBytes.
  absl::StatusOr<std::string> Read(uint64_t offset, uint64_t count, absl::string_view what) const;
  // Returns up to `count` bytes: fewer where they end.
  absl::StatusOr<std::string> ReadUpTo(uint64_t offset, uint64_t count) const;
  // INVALID_ARGUMENT: "FILE: at OFFSET: WHAT".
  absl::Status ErrorAt(uint64_t offset, absl::string_view what) const;

 private:
  BagBytes(std::string name, int file, uint64_t size);

  const std::string name_;
  const int file_ = -1;  // Of no file: -1.
  const std::string memory_;
  const uint64_t size_ = 0;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_BAG_FILES_BAG_BYTES_H_
