// A robot that uploads a chain of keyframes, with features that no coding makes shorter.
#ifndef CORBSLAM_TESTS_BENCH_CHAIN_UPLOADER_H_
#define CORBSLAM_TESTS_BENCH_CHAIN_UPLOADER_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "map_store/store/map_store.h"

namespace corbslam::tests {

// Has one session. Not thread-safe.
class ChainUploader {
 public:
  // `store` must outlive it.
  ChainUploader(map_store::MapStore& store, std::string mission, size_t features);
  ~ChainUploader() { Close(); }
  ChainUploader(const ChainUploader&) = delete;
  ChainUploader& operator=(const ChainUploader&) = delete;

  absl::Status Open();
  // Uploads so many more keyframes as one batch; waits a little where the store has no room.
  absl::Status Upload(uint32_t keyframes);
  void Close();

 private:
  static constexpr LocalMapId kLocalMap{1};

  std::shared_ptr<const KeyframePayload> MakePayload(uint32_t index);

  map_store::MapStore& store_;
  const std::string mission_;
  const std::shared_ptr<const Camera> camera_;
  // Keyframes have these in turn: making others would take longer than storing them.
  std::vector<Features> features_;
  uint64_t session_ = 0;
  uint64_t number_ = 0;
  uint32_t next_ = 0;
};

}  // namespace corbslam::tests

#endif  // CORBSLAM_TESTS_BENCH_CHAIN_UPLOADER_H_
