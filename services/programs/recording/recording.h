// Reads a recording back: what FrameRecorder wrote.
#ifndef CORBSLAM_SERVICES_PROGRAMS_RECORDING_RECORDING_H_
#define CORBSLAM_SERVICES_PROGRAMS_RECORDING_RECORDING_H_

#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client_agent/tracking/tracking_result.h"
#include "services/programs/recording/recorded_lines.h"
#include "services/programs/recording/recording_head.h"
#include "slam/sensor/sensor.h"

namespace corbslam::services {

// A frame that was given to tracking.
struct RecordedFrame {
  FrameLine line;
  std::optional<OrdersLine> orders = std::nullopt;  // What was ordered before it, if anything.
  // What tracking said of it; nullopt where the robot ended before it had.
  std::optional<client_agent::TrackingResult> result = std::nullopt;
  uint64_t dropped = 0;     // Frames that had come too fast by then.
  size_t first_sample = 0;  // In Recording::imu: of those that came with it.
};

struct Recording {
  std::string folder;
  // With the mask. Counts of a run that has no end are those of its lines.
  RecordingHead head;
  std::vector<RecordedFrame> frames;
  ImuSamples imu;  // In the order in which they came.
  // What is odd: a last line that is cut short, a run that has no end.
  std::vector<std::string> notes;

  SensorKind kind() const { return KindOf(head.calibration); }
};

// NOT_FOUND where the folder holds no recording; DATA_LOSS names the file and the line.
absl::StatusOr<Recording> ReadRecording(const std::string& folder);

// Returns what an IMU measured before a frame, whether its pictures are there or not.
ImuSamples ImuOf(const Recording& recording, const RecordedFrame& frame);

// Returns the mask that was ordered before a frame, empty for none any more. Errors name the file.
absl::StatusOr<PictureMask> ReadOrderedMask(const Recording& recording, const OrdersLine& orders);

// Returns the pictures of a frame that has some, as they were given to tracking, without what an
// IMU measured. Errors name the
// file: DATA_LOSS, too, where it holds another picture than was recorded.
absl::StatusOr<SensorImages> ReadPictures(const Recording& recording, const FrameLine& frame);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_RECORDING_RECORDING_H_
