// Says what a recording is of: recording.json in its folder (docs/recording.md).
#ifndef CORBSLAM_SERVICES_PROGRAMS_RECORDING_RECORDING_HEAD_H_
#define CORBSLAM_SERVICES_PROGRAMS_RECORDING_RECORDING_HEAD_H_

#include <cstdint>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "slam/sensor/sensor.h"

namespace corbslam::services {

// The flags of the robot that matter to the estimate. They, the frames and the program decide it.
struct RecordedFlags {
  std::string mission;
  std::string agent;
  uint64_t seed = 0;  // The one that was used, also where it was drawn.
  int features = 0;
  int solver_threads = 1;
  std::string pace;         // "max", "sensor" or "step".
  bool joined = false;      // A map store's other robots may have had a part in the map.
  uint64_t vocabulary = 0;  // Vocabulary::fingerprint.
  // The robot made no map: it was tracked in what others shared.
  bool localise_only = false;
  bool resumes = false;        // It may have gone on with the map of an earlier process.
  uint64_t max_map_bytes = 0;  // AgentOptions::max_map_bytes; 0: no bound.

  bool operator==(const RecordedFlags&) const = default;
};

// What was counted, final where `finished`.
struct RecordedCounts {
  uint64_t frames = 0;    // Given to tracking.
  uint64_t left_out = 0;  // Of these, not in the recording: the disk was slower than the camera.
  uint64_t dropped = 0;   // Never given to tracking: they came too fast.
  uint64_t tracked = 0;

  bool operator==(const RecordedCounts&) const = default;
};

struct RecordingHead {
  std::string version;  // Of the program.
  std::string source;   // As the user named it.
  std::string started;  // UTC.
  RecordedFlags flags;
  SensorCalibration calibration;
  bool has_mask = false;  // FrameRecorder sets it.
  // Of the mask's pixels (PictureChecksum), set by RecordingFiles; nullopt in older recordings.
  std::optional<uint32_t> mask_checksum = std::nullopt;
  RecordedCounts counts;
  bool finished = false;  // False: the program crashed, or is still at it.
  std::string ended;      // Why the recording ended before the run; empty: it did not.
};

std::string FormatHead(const RecordingHead& head);
// DATA_LOSS names the field that is missing or of another kind. The calibration is without its
// mask.
absl::StatusOr<RecordingHead> ParseHead(const std::string& text);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_RECORDING_RECORDING_HEAD_H_
