#include "client_agent/source/first_camera_reader.h"

#include <utility>

#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

class FirstCameraReader : public FrameReader {
 public:
  explicit FirstCameraReader(std::unique_ptr<FrameReader> reader)
      : reader_(std::move(reader)),
        calibration_(FirstCameraOf(reader_->calibration())),
        description_(reader_->description()) {
    DescribeCamera(calibration_, description_);
  }

  const SensorCalibration& calibration() const override { return calibration_; }
  const SourceDescription& description() const override { return description_; }
  size_t frame_count() const override { return reader_->frame_count(); }
  int64_t timestamp_ns(size_t frame) const override { return reader_->timestamp_ns(frame); }
  int drive(size_t frame) const override { return reader_->drive(frame); }
  absl::StatusOr<SensorImages> Read(size_t frame) const override {
    ASSIGN_OR_RETURN(SensorImages images, reader_->Read(frame));
    images.right = cv::Mat();
    images.depth = cv::Mat();
    return images;
  }
  ImuSamples Imu(int64_t after_ns, int64_t until_ns) const override {
    return reader_->Imu(after_ns, until_ns);
  }

 private:
  const std::unique_ptr<FrameReader> reader_;
  const SensorCalibration calibration_;
  SourceDescription description_;
};

}  // namespace

std::unique_ptr<FrameReader> FirstCameraAlone(std::unique_ptr<FrameReader> reader) {
  if (KindOf(reader->calibration()) == SensorKind::kMonocular) return reader;
  return std::make_unique<FirstCameraReader>(std::move(reader));
}

}  // namespace corbslam::client_agent
