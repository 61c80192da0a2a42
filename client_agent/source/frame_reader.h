// Reads the frames of one layout: what frames there are and how to read one.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_FRAME_READER_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_FRAME_READER_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "client_agent/source/source_description.h"
#include "client_agent/source/source_spec.h"
#include "slam/sensor/sensor.h"

namespace corbslam::client_agent {

// The frames of one sequence. Immutable after it is made; Read may be called from any thread.
class FrameReader {
 public:
  virtual ~FrameReader() = default;
  virtual const SensorCalibration& calibration() const = 0;
  // Says what is known of the sequence, and what looks wrong in it.
  virtual const SourceDescription& description() const = 0;
  virtual size_t frame_count() const = 0;
  virtual int64_t timestamp_ns(size_t frame) const = 0;
  // Frames of one drive have growing times; a sequence whose times jump back holds several drives.
  virtual int drive(size_t frame) const = 0;
  // Returns NOT_FOUND or INVALID_ARGUMENT, naming the file: one that is not there, can't be read,
  // is cut short or has another size than the calibration.
  virtual absl::StatusOr<SensorImages> Read(size_t frame) const = 0;
  // Returns what the IMU measured later than `after_ns`, up to the first sample at or after
  // `until_ns` (ImuBetween), by the clock of timestamp_ns: what is played need not be all frames,
  // and each sample comes with one. Read gives none then. Empty where there is no IMU.
  virtual ImuSamples Imu(int64_t /*after_ns*/, int64_t /*until_ns*/) const { return {}; }
};

// Each of these opens `spec.directory`; docs/sources.md lists the files of each layout and the
// messages. The first opens KITTI odometry and KITTI raw.
absl::StatusOr<std::unique_ptr<FrameReader>> OpenKitti(const SourceSpec& spec);
// Opens EuRoC's ASL layout: DIR/mav0 (or DIR) with cam0 and cam1, each with sensor.yaml, data.csv
// and data/.
absl::StatusOr<std::unique_ptr<FrameReader>> OpenEuroc(const SourceSpec& spec);
// Opens TUM RGB-D's layout, which ICL-NUIM and ETH3D use too: associated.txt (or associations.txt),
// else rgb.txt and depth.txt, each picture with the depth image nearest in time within 20 ms.
absl::StatusOr<std::unique_ptr<FrameReader>> OpenTum(const SourceSpec& spec);
// Opens 7-Scenes: DIR/frame-000000.color.png and frame-000000.depth.png; the times come from ?fps.
absl::StatusOr<std::unique_ptr<FrameReader>> OpenSevenScenes(const SourceSpec& spec);

// Opens the sequence that `spec` names; the selection and perturbation of `spec` are not applied.
absl::StatusOr<std::unique_ptr<FrameReader>> OpenReader(const SourceSpec& spec);

// Returns a frame as it is played: read, then perturbed.
absl::StatusOr<SensorImages> ReadPerturbed(const FrameReader& reader, size_t frame,
                                           const Perturbation& perturbation);

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_FRAME_READER_H_
