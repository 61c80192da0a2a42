// A whole mission is one file here: a backup makes it, and a restore is made from it. It is
//
//   "CORBMISN", format, then sections up to the one that says it is the last:
//   kind (1 byte), size (8), payload, CRC-32C of all that (4)
//
// Numbers are little-endian. Features come before the state that names them.
#ifndef CORBSLAM_MAP_STORE_ARCHIVE_MISSION_ARCHIVE_H_
#define CORBSLAM_MAP_STORE_ARCHIVE_MISSION_ARCHIVE_H_

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "map_store/state/mission_state.h"
#include "slam/features/keypoint.h"
#include "slam/map/keyframe.h"
#include "slam/util/ids.h"

namespace corbslam::map_store {

// Writes a mission as it was at one moment; what comes later does not change it. It shares what
// cameras saw with the mission, so that making one costs little memory and time.
class MissionBackup {
 public:
  explicit MissionBackup(const MissionState& state);
  // Takes a state that was encoded elsewhere (EncodeState), with all its keyframes.
  MissionBackup(std::string state, std::vector<std::shared_ptr<const KeyframePayload>> keyframes)
      : keyframes_(std::move(keyframes)), state_(std::move(state)) {}

  // Returns the file's next piece, of about `bytes` (a keyframe more at most); empty at the end.
  std::string Next(size_t bytes);

 private:
  enum class Stage { kBegin, kFeatures, kState, kEnd };

  std::string Section();

  Stage stage_ = Stage::kBegin;
  std::vector<std::shared_ptr<const KeyframePayload>> keyframes_;
  size_t next_keyframe_ = 0;
  std::string state_;
  size_t next_state_byte_ = 0;
};

// Makes a mission from such a file, piece by piece. Not thread-safe.
class MissionRestorer {
 public:
  // The file may have at most `max_bytes`. `check_room` is called for each piece, with the bytes
  // that it takes in memory, and Add returns its error. Null means that there is always room.
  explicit MissionRestorer(uint64_t max_bytes,
                           std::function<absl::Status(uint64_t)> check_room = nullptr)
      : max_bytes_(max_bytes), check_room_(std::move(check_room)) {}

  // Takes the next piece; none may follow an error. DATA_LOSS, naming the byte: the file is
  // damaged. FAILED_PRECONDITION: it has a newer format, or is no such file. RESOURCE_EXHAUSTED: it
  // is too long, or there is no room.
  absl::Status Add(std::string_view piece);
  // Returns the mission; called once, after the last piece. DATA_LOSS: the file was cut short or
  // its parts don't fit together.
  absl::StatusOr<MissionState> Finish();

 private:
  // Takes a whole part off the front of `rest`; returns false if more bytes are needed.
  absl::StatusOr<bool> TakeHeader(std::string_view& rest);
  absl::StatusOr<bool> TakeSection(std::string_view& rest);
  absl::Status Take(char kind, std::string_view payload);
  absl::Status Damaged(absl::string_view what) const;

  const uint64_t max_bytes_;
  const std::function<absl::Status(uint64_t)> check_room_;
  uint64_t received_ = 0;
  uint64_t taken_ = 0;
  bool has_header_ = false;
  bool is_complete_ = false;
  std::string pending_;  // The beginning of a part whose rest has not come yet.
  std::map<KeyframeId, Features> features_;
  std::string state_;
};

}  // namespace corbslam::map_store

#endif  // CORBSLAM_MAP_STORE_ARCHIVE_MISSION_ARCHIVE_H_
