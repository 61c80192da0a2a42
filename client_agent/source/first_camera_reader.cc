#include "client_agent/source/first_camera_reader.h"

#include <utility>

#include "client_agent/source/altered_reader.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

class FirstCameraReader : public AlteredReader {
 public:
  explicit FirstCameraReader(std::unique_ptr<FrameReader> reader)
      : AlteredReader(std::move(reader)) {
    calibration_ = FirstCameraOf(calibration_);
    DescribeCamera(calibration_, description_);
  }

  absl::StatusOr<SensorImages> Read(size_t frame) const override {
    ASSIGN_OR_RETURN(SensorImages images, reader().Read(frame));
    images.right = cv::Mat();
    images.depth = cv::Mat();
    return images;
  }
};

}  // namespace

std::unique_ptr<FrameReader> FirstCameraAlone(std::unique_ptr<FrameReader> reader) {
  if (KindOf(reader->calibration()) == SensorKind::kMonocular) return reader;
  return std::make_unique<FirstCameraReader>(std::move(reader));
}

}  // namespace corbslam::client_agent
