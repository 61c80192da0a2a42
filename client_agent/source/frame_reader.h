// One layout: what frames there are and how to read one.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_FRAME_READER_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_FRAME_READER_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "client_agent/source/source_spec.h"
#include "slam/sensor/sensor.h"

namespace corbslam {

// Immutable after it is made; Read may be called from any thread.
class FrameReader {
 public:
  virtual ~FrameReader() = default;
  virtual const SensorCalibration& calibration() const = 0;
  virtual size_t frame_count() const = 0;
  virtual int64_t timestamp_ns(size_t frame) const = 0;
  // NOT_FOUND or INVALID_ARGUMENT, naming the file.
  virtual absl::StatusOr<SensorImages> Read(size_t frame) const = 0;
};

// KITTI odometry: DIR/calib.txt (P0 and P1), times.txt, image_0 and image_1 with six digits a file.
absl::StatusOr<std::unique_ptr<FrameReader>> OpenKitti(const std::string& directory);

// EuRoC's ASL layout: DIR/mav0 (or DIR) with cam0 and cam1, each sensor.yaml, data.csv and data/.
// Frames are the times that both cameras list.
absl::StatusOr<std::unique_ptr<FrameReader>> OpenEuroc(const std::string& directory);

// TUM RGB-D: DIR/associated.txt (time, grey file, time, depth file), or else rgb.txt and depth.txt,
// each picture with the depth image nearest in time within 20 ms. DIR/calibration.yaml, when there,
// has lines "fx: 525" (fx fy cx cy k1 k2 p1 p2 k3 depth_units_per_m); without it the published
// values of freiburg 1, 2 or 3 are taken, as the directory's name says (else 1).
absl::StatusOr<std::unique_ptr<FrameReader>> OpenTum(const std::string& directory);

// Drawn, not read: Read's errors are those of SimulatedSequence::Render.
absl::StatusOr<std::unique_ptr<FrameReader>> OpenSimulation(const SimulationSpec& spec);

// The one that `spec` names; its selection and perturbation are not applied.
absl::StatusOr<std::unique_ptr<FrameReader>> OpenReader(const SourceSpec& spec);

// A frame as it is played: read, then perturbed.
absl::StatusOr<SensorImages> ReadPerturbed(const FrameReader& reader, size_t frame,
                                           const Perturbation& perturbation);

}  // namespace corbslam

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_FRAME_READER_H_
