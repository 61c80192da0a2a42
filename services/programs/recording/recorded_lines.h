// The lines of a recording's frames.jsonl: what the robot was given and what came of it, in order.
#ifndef CORBSLAM_SERVICES_PROGRAMS_RECORDING_RECORDED_LINES_H_
#define CORBSLAM_SERVICES_PROGRAMS_RECORDING_RECORDED_LINES_H_

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "client_agent/tracking/tracking_result.h"

namespace corbslam::services {

// A frame that tracking was given; written before its result.
struct FrameLine {
  uint64_t frame = 0;  // Counts the frames given to tracking, from 0.
  int64_t timestamp_ns = 0;
  bool begins_local_map = false;  // The robot was told to begin a new local map before it.
  // Name of the two pictures' files, each in its folder. Empty: they are not in the recording.
  std::string pictures;
  // Of their pixels (PictureChecksum), in the same order; empty in older recordings.
  std::vector<uint32_t> checksums = {};
  // How many of the IMU's samples, in the order of its list, came with it.
  uint64_t imu_samples = 0;

  bool operator==(const FrameLine&) const = default;
};

// What other programs had ordered before a frame (PauseMapping and the others); written behind its
// line where it differs from the frame before.
struct OrdersLine {
  uint64_t frame = 0;
  bool mapping_paused = false;
  bool opens_local_map = false;
  // True: another mask, in MaskPath of this frame. False: none any more. Nullopt: as before.
  std::optional<bool> has_mask = std::nullopt;
  std::optional<uint32_t> mask_checksum = std::nullopt;  // Nullopt in older recordings, too.

  bool operator==(const OrdersLine&) const = default;
};

// What tracking said of a frame.
struct ResultLine {
  uint64_t frame = 0;
  uint64_t dropped = 0;                 // Frames so far that came too fast.
  client_agent::TrackingResult result;  // `reference` and what is relative to it are not kept.
};

using RecordedLine = std::variant<FrameLine, OrdersLine, ResultLine>;

// Returns one line of JSON without its end. Numbers are read back to the bit.
std::string FormatLine(const RecordedLine& line);
// DATA_LOSS says what is missing or of another kind.
absl::StatusOr<RecordedLine> ParseLine(absl::string_view text);

// Returns true where the two results agree in all that is recorded, to the bit.
bool AreEqual(const client_agent::TrackingResult& a, const client_agent::TrackingResult& b);

// Returns "not-initialised", "tracking" or "lost".
absl::string_view WordOf(client_agent::TrackingState state);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_RECORDING_RECORDED_LINES_H_
