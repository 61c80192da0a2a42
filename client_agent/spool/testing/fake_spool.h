// Simulates a disk and a codec in memory, for tests of the spool and of what uses it.
#ifndef CORBSLAM_CLIENT_AGENT_SPOOL_TESTING_FAKE_SPOOL_H_
#define CORBSLAM_CLIENT_AGENT_SPOOL_TESTING_FAKE_SPOOL_H_

#include <algorithm>
#include <iterator>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "client_agent/spool/batch_bytes.h"
#include "client_agent/spool/spool.h"
#include "client_agent/spool/spool_files.h"

namespace corbslam::client_agent {

// What a simulated disk keeps; it outlives a process.
struct FakeDisk {
  std::map<std::string, std::string> files;
  // Bytes that all files may have together; a write that finds less room writes as much as there
  // is.
  size_t capacity = std::numeric_limits<size_t>::max();
  int syncs = 0;
  bool sync_fails = false;
  // What of each file a loss of power does not take.
  std::map<std::string, size_t> synced;
  // Encoded batches; the bytes of each begin with its index here.
  std::vector<MapUpdateBatch> encoded;

  // Loses any part of what was not synced.
  template <typename Random>
  void CutPower(Random& random) {
    for (auto it = files.begin(); it != files.end();) {
      const size_t kept = synced.contains(it->first) ? synced[it->first] : 0;
      it->second.resize(kept + random() % (it->second.size() - kept + 1));
      it = it->second.empty() ? files.erase(it) : std::next(it);
    }
  }

  size_t Used() const {
    size_t used = 0;
    for (const auto& [name, content] : files) used += content.size();
    return used;
  }
};

class FakeSpoolFiles : public SpoolFiles {
 public:
  explicit FakeSpoolFiles(FakeDisk* disk) : disk_(*disk) {}

  absl::StatusOr<std::vector<std::string>> List() override {
    std::vector<std::string> names;
    for (const auto& [name, content] : disk_.files) names.push_back(name);
    return names;
  }
  absl::StatusOr<uint64_t> Size(const std::string& name) override {
    if (!disk_.files.contains(name)) return absl::UnavailableError(name);
    return disk_.files[name].size();
  }
  absl::StatusOr<std::string> Read(const std::string& name, uint64_t offset,
                                   size_t bytes) override {
    if (!disk_.files.contains(name)) return absl::UnavailableError(name);
    const std::string& content = disk_.files[name];
    return offset >= content.size() ? "" : content.substr(offset, bytes);
  }
  absl::Status Append(const std::string& name, absl::string_view bytes) override {
    const size_t used = disk_.Used();
    const size_t room = disk_.capacity > used ? disk_.capacity - used : 0;
    absl::StrAppend(&disk_.files[name], bytes.substr(0, room));
    return room >= bytes.size() ? absl::OkStatus() : absl::ResourceExhaustedError("disk full");
  }
  absl::Status Truncate(const std::string& name, uint64_t size) override {
    disk_.files[name].resize(size);
    return absl::OkStatus();
  }
  absl::Status Sync(const std::string& name) override {
    ++disk_.syncs;
    if (disk_.sync_fails) return absl::UnavailableError("sync failed");
    disk_.synced[name] = disk_.files[name].size();
    return absl::OkStatus();
  }
  absl::Status Remove(const std::string& name) override {
    disk_.synced.erase(name);
    return disk_.files.erase(name) == 1 ? absl::OkStatus() : absl::UnavailableError(name);
  }

 private:
  FakeDisk& disk_;
};

// Makes a codec that encodes a batch as its index in `disk`, padded to the batch's length.
inline BatchCodec FakeCodec(FakeDisk* disk) {
  BatchCodec codec;
  codec.encode = [disk](const MapUpdateBatch& batch) {
    disk->encoded.push_back(batch);
    return absl::StrCat(disk->encoded.size() - 1, " ", std::string(ApproximateBytes(batch), 'x'));
  };
  codec.decode = [disk](absl::string_view bytes) -> absl::StatusOr<MapUpdateBatch> {
    size_t index = 0;
    const bool good =
        absl::SimpleAtoi(bytes.substr(0, bytes.find(' ')), &index) && index < disk->encoded.size();
    if (!good) return absl::InvalidArgumentError("no batch");
    return disk->encoded[index];
  };
  return codec;
}

inline absl::StatusOr<std::unique_ptr<Spool>> OpenFakeSpool(FakeDisk* disk,
                                                            const SpoolOptions& options = {}) {
  return Spool::Open(options, std::make_unique<FakeSpoolFiles>(disk), FakeCodec(disk));
}

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SPOOL_TESTING_FAKE_SPOOL_H_
