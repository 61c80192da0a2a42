// Reads every layout whose frames are files: a left picture with a right one, a picture with a
// depth image, or a picture alone.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_LISTED_READER_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_LISTED_READER_H_

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client_agent/source/calibration/stated_imu.h"
#include "client_agent/source/frame_reader.h"
#include "client_agent/source/rig/rig_depth.h"

namespace corbslam::client_agent {

struct ListedFrame {
  int64_t timestamp_ns = 0;
  int drive = 0;  // Number of the drive (Timeline::drive).
  std::string first;
  std::string second;  // Empty where one camera is played alone.
};

// A layout's part of opening a sequence; the rest is alike for all.
struct ListedSequence {
  SensorCalibration calibration;
  DepthPreparation depth;  // RGB-D only.
  std::vector<ListedFrame> frames;
  std::optional<StatedImu> imu;  // As a rig or the recording's own file states it.
  ImuSamples imu_samples;        // By the clock of the frames.
  // Which two pictures are a frame was found out by their times.
  bool paired_by_time = false;
  std::string times_file;  // Named in messages about times.
  SourceDescription description;
};

// Measures times and completes the description. Returns INVALID_ARGUMENT or NOT_FOUND, naming the
// file, where nothing is left or the times can't be a camera's.
absl::StatusOr<std::unique_ptr<FrameReader>> MakeListedReader(ListedSequence sequence);

// Notes for how many frames a picture is not there; they keep their numbers and are left out when
// they are played. Returns NOT_FOUND, naming a file, where it is more than half of them.
absl::Status TellMissing(const std::vector<ListedFrame>& frames, SourceDescription& description);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_LISTED_READER_H_
