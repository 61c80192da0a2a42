// What a robot finds in its spool folder: files of arbitrary bytes. The first byte: how many files;
// bits of the second: whose checksums are made right, so that what they protect is reached.
#include <algorithm>
#include <cstring>
#include <map>
#include <memory>
#include <string>

#include "absl/strings/str_format.h"
#include "client_agent/upload/upload_queue.h"
#include "services/convert/batch_bytes.h"
#include "slam/util/checksum.h"
#include "tests/fuzz/messages.h"

namespace corbslam::tests {

using client_agent::BatchCodec;
using client_agent::EncodeSegmentHeader;
using client_agent::EncodeSpoolRecord;
using client_agent::LostLocalMap;
using client_agent::Spool;
using client_agent::SpoolFiles;
using client_agent::SpoolRecord;
using client_agent::UploadQueue;
using services::DecodeBatch;
using services::EncodeBatch;

namespace {

class MemoryFiles : public SpoolFiles {
 public:
  absl::StatusOr<std::vector<std::string>> List() override {
    std::vector<std::string> names;
    for (const auto& [name, content] : files) names.push_back(name);
    return names;
  }
  absl::StatusOr<uint64_t> Size(const std::string& name) override { return files[name].size(); }
  absl::StatusOr<std::string> Read(const std::string& name, uint64_t offset,
                                   size_t bytes) override {
    const std::string& content = files[name];
    return offset >= content.size() ? "" : content.substr(offset, bytes);
  }
  absl::Status Append(const std::string& name, absl::string_view bytes) override {
    files[name].append(bytes.data(), bytes.size());
    return absl::OkStatus();
  }
  absl::Status Truncate(const std::string& name, uint64_t size) override {
    files[name].resize(size);
    return absl::OkStatus();
  }
  absl::Status Sync(const std::string&) override { return absl::OkStatus(); }
  absl::Status Remove(const std::string& name) override {
    files.erase(name);
    return absl::OkStatus();
  }

  std::map<std::string, std::string> files;
};

// Makes a segment that takes the content for the payload of one record.
std::string MakeRightSegment(absl::string_view content) {
  SpoolRecord record;
  record.local_map = {content.empty() ? 1u : 1u + static_cast<uint8_t>(content[0]) % 3u};
  record.number = content.size() < 2 ? 1u : 1u + static_cast<uint8_t>(content[1]) % 4u;
  return EncodeSegmentHeader("me") +
         EncodeSpoolRecord(record, content.substr(std::min<size_t>(2, content.size())));
}

}  // namespace
}  // namespace corbslam::tests

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace corbslam;         // NOLINT
  using namespace corbslam::tests;  // NOLINT
  if (size < 2) return 0;
  absl::string_view input = AsText(data + 2, size - 2);
  auto files = std::make_unique<MemoryFiles>();
  const int count = 1 + data[0] % 4;
  for (int i = 0; i < count; ++i) {
    const absl::string_view content = TakeMessage(input);
    files->files[absl::StrFormat("%012d.spool", i + 1)] =
        (data[1] >> i & 1) != 0 ? MakeRightSegment(content) : std::string(content);
  }
  auto spool =
      Spool::Open({.owner = "me"}, std::move(files), BatchCodec{&EncodeBatch, &DecodeBatch});
  if (!spool.ok()) return 0;
  UploadQueue queue(1000, *std::move(spool));
  queue.Begin({9});
  MapUpdateBatch batch;
  batch.local_map = {9};
  batch.lost_frames_ns.resize(200, 1);
  queue.Push(batch);
  queue.Spill();
  SessionGrant grant;
  for (const LocalMapId& id : queue.local_maps()) grant.acknowledged.push_back({id, size % 3});
  queue.Resume(grant);
  std::vector<LostLocalMap> lost;
  while (const auto next = queue.TakeUnsent(lost))
    queue.Acknowledge({next->local_map, next->number});
  queue.Spill();
  (void)queue.status();
  return 0;
}
