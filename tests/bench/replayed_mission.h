// Streams a mission of recorded robots in one process: the same uploads again under other
// conditions. It says how far the fused map is from the truth.
#ifndef CORBSLAM_TESTS_BENCH_REPLAYED_MISSION_H_
#define CORBSLAM_TESTS_BENCH_REPLAYED_MISSION_H_

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "map_store/store/map_store.h"
#include "slam/evaluation/trajectory.h"
#include "tests/replay/recorded_uploads.h"

namespace corbslam::tests {

struct RecordedMission {
  std::shared_ptr<const Vocabulary> vocabulary;
  std::vector<RecordedUploads> robots;  // Uploads of each robot, which has a local map of its own.
  Trajectory truth;
};

// Records each of `robots` robots alone over its part of the source (`corbslam run`'s split with 20
// frames of overlap). NOT_FOUND: the sequence has no truth.
absl::StatusOr<RecordedMission> RecordMission(const std::string& source, size_t robots);

struct FusedMapError {
  size_t islands = 0;
  size_t frames = 0;  // Frames in the reference island.
  double ate_m = 0;   // Error of these under one rigid alignment.
};

// A deterministic mission: the same recording, options and worker give the same map to the bit.
class ReplayedMission {
 public:
  // `recorded` and `worker` must outlive it.
  ReplayedMission(const RecordedMission& recorded, map_store::MapStoreOptions options,
                  FusionWorker* worker);

  // Every robot sends a batch in turn, and all that is to be fused is fused. `note` is called after
  // each of both; what it returns ends the stream if it is an error.
  enum class Step { kSent, kFused };
  absl::Status Stream(absl::FunctionRef<absl::Status(Step)> note = [](Step) {
    return absl::OkStatus();
  });
  absl::Status Fuse() { return store_.RunFusionUntilIdle(name()); }
  absl::StatusOr<FusedMapError> Error() const;

  map_store::MapStore& store() { return store_; }
  static const std::string& name();

 private:
  const RecordedMission& recorded_;
  map_store::MapStore store_;
};

}  // namespace corbslam::tests

#endif  // CORBSLAM_TESTS_BENCH_REPLAYED_MISSION_H_
