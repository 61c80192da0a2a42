// Reads the features of keyframes, ahead of who asks: keyframes are asked for one after the other,
// and each question to a server takes a while.
#ifndef CORBSLAM_MAP_STORE_POSTGRES_FEATURE_READER_H_
#define CORBSLAM_MAP_STORE_POSTGRES_FEATURE_READER_H_

#include <cstdint>
#include <map>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "map_store/postgres/sql_pool.h"
#include "slam/features/keypoint.h"
#include "slam/util/ids.h"

namespace corbslam::map_store {

// Not thread-safe.
class FeatureReader {
 public:
  FeatureReader(SqlPool& pool, int64_t mission_id) : pool_(pool), mission_id_(mission_id) {}

  // DATA_LOSS: they are not there, or not what they were.
  absl::StatusOr<Features> Read(KeyframeId id);

 private:
  struct Stored {
    std::string hash;
    uint64_t size = 0;
    std::string bytes;
  };

  // Reads the keyframe's and those of the next ones, in the place of what was read before.
  absl::Status ReadAhead(KeyframeId id);

  SqlPool& pool_;
  const int64_t mission_id_;
  std::map<KeyframeId, Stored> ahead_;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_POSTGRES_FEATURE_READER_H_
