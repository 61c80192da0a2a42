// A whole mission in one file: what a backup is made of and a restore is made from.
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

namespace corbslam {

// A mission as it was at one moment; what comes later does not change it. Shares what cameras saw
// with the mission, so that taking it costs little memory and time.
class MissionBackup {
 public:
  explicit MissionBackup(const map_store::MissionState& state);
  // Likewise of a state that was encoded elsewhere (EncodeState), with all its keyframes.
  MissionBackup(std::string state, std::vector<std::shared_ptr<const KeyframePayload>> keyframes)
      : keyframes_(std::move(keyframes)), state_(std::move(state)) {}

  // The file's next piece, of about `bytes` (a keyframe more at most); empty: that was all.
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

// Reads such a file piece by piece.
class MissionRestorer {
 public:
  // The file may have at most so many bytes. `check_room` is asked for each piece, with the bytes
  // that it takes in memory: an error is Add's. Null: there is room.
  explicit MissionRestorer(uint64_t max_bytes,
                           std::function<absl::Status(uint64_t)> check_room = nullptr)
      : max_bytes_(max_bytes), check_room_(std::move(check_room)) {}

  // DATA_LOSS, naming the byte: damaged. FAILED_PRECONDITION: a newer format, or not such a file.
  // RESOURCE_EXHAUSTED: too long, or there is no room. No piece may follow an error.
  absl::Status Add(std::string_view piece);
  // After the last piece. DATA_LOSS: the file was cut short or its parts don't fit together. Once.
  absl::StatusOr<map_store::MissionState> Finish();

 private:
  // Takes a whole part off the front of `rest`; false: more bytes are needed.
  absl::StatusOr<bool> TakeHeader(std::string_view& rest);
  absl::StatusOr<bool> TakeSection(std::string_view& rest);
  absl::Status Take(char kind, std::string_view payload);
  absl::Status Damaged(absl::string_view what) const;

  const uint64_t max_bytes_;
  const std::function<absl::Status(uint64_t)> check_room_;
  uint64_t received_ = 0;
  uint64_t taken_ = 0;
  bool has_header_ = false;
  bool is_whole_ = false;
  std::string pending_;  // The beginning of a part.
  std::map<KeyframeId, Features> features_;
  std::string state_;
};

}  // namespace corbslam

#endif  // CORBSLAM_MAP_STORE_ARCHIVE_MISSION_ARCHIVE_H_
