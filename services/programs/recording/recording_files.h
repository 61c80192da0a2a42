// Writes a recording's files: the pictures in EuRoC's layout (stereo) or TUM's (RGB-D), the rig,
// recording.json and frames.jsonl (docs/recording.md).
#ifndef CORBSLAM_SERVICES_PROGRAMS_RECORDING_RECORDING_FILES_H_
#define CORBSLAM_SERVICES_PROGRAMS_RECORDING_RECORDING_FILES_H_

#include <cstdint>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "services/programs/recording/recorded_lines.h"
#include "services/programs/recording/recording_head.h"
#include "slam/sensor/sensor.h"

namespace corbslam::services {

// Where a recording's files are.
std::string HeadPath(const std::string& folder);
std::string LinesPath(const std::string& folder);
std::string MaskPath(const std::string& folder);
// Of the mask that was ordered before a frame.
std::string MaskPath(const std::string& folder, uint64_t frame);
// Returns the paths of a frame's pictures: left and right, grey and depth, or the only one.
std::vector<std::string> PicturePaths(const std::string& folder, SensorKind kind,
                                      const std::string& pictures);
// Returns the path of the list of what an IMU measured, which a recording with one has.
std::string ImuListPath(const std::string& folder, SensorKind kind);
// Returns a number of a picture's size, type and pixels, whichever file holds them (CRC-32C).
uint32_t PictureChecksum(const cv::Mat& picture);
// Returns how client_agent names the recording as a source: "euroc:DIR?rig=DIR/rig.yaml", or "tum:"
// of RGB-D.
std::string SourceOfRecording(const std::string& folder, SensorKind kind);

// Returns FAILED_PRECONDITION where the folder is there and holds something. Changes nothing.
absl::Status CheckRecordingFolder(const std::string& folder);

// One thread uses it. Whatever was written is with the operating system when a call returns, so
// that it outlives the process. Errors name the file and the cause.
class RecordingFiles {
 public:
  // Makes the folder, which must be new or empty, and all files but the pictures. `rate_hz` goes
  // into the rig.
  static absl::StatusOr<std::unique_ptr<RecordingFiles>> Create(const std::string& folder,
                                                                const RecordingHead& head,
                                                                std::optional<double> rate_hz);

  // Writes the pictures, the layout's lines and then `line`, whose `pictures` and `checksums` it
  // fills in.
  // RESOURCE_EXHAUSTED where less than `least_free_bytes` would stay free on the disk.
  absl::Status WriteFrame(const SensorImages& images, uint64_t least_free_bytes, FrameLine line);
  absl::Status WriteLine(const RecordedLine& line);
  // Writes what came with the next frame; does nothing where the calibration has no IMU.
  absl::Status WriteImu(const ImuSamples& samples);
  // Writes the mask, if there is one, and then the line, whose `mask_checksum` it fills in.
  absl::Status WriteOrders(OrdersLine line, const PictureMask& mask);
  // Puts `head` in the place of recording.json as a whole, with the mask's checksum.
  absl::Status WriteHead(RecordingHead head);

 private:
  struct List {
    std::string path;
    std::ofstream file;
  };
  RecordingFiles(std::string folder, SensorKind kind) : folder_(std::move(folder)), kind_(kind) {}
  absl::Status MakeLists();
  absl::Status MakeImuFiles(const SensorCalibration& calibration);
  absl::Status WriteRig(const RecordingHead& head, std::optional<double> rate_hz);
  absl::Status AppendToLists(int64_t timestamp_ns, const std::string& pictures);
  std::string NameOf(const FrameLine& line);

  const std::string folder_;
  const SensorKind kind_;
  std::vector<List> lists_;  // The layout's, then frames.jsonl.
  std::optional<List> imu_list_;
  std::optional<int64_t> latest_ns_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_PROGRAMS_RECORDING_RECORDING_FILES_H_
