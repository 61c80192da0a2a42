#include "client_agent/source/without_imu.h"

#include <optional>
#include <utility>
#include <variant>

#include "absl/strings/str_cat.h"
#include "client_agent/source/imu_opening.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

class ReaderWithoutImu : public FrameReader {
 public:
  ReaderWithoutImu(std::unique_ptr<FrameReader> reader, const std::string& why)
      : reader_(std::move(reader)),
        calibration_(reader_->calibration()),
        description_(reader_->description()) {
    SetImu(std::nullopt, calibration_);
    description_.imu.clear();
    description_.remarks.left_out.push_back(absl::StrCat("what the IMU measured: ", why));
  }

  const SensorCalibration& calibration() const override { return calibration_; }
  const SourceDescription& description() const override { return description_; }
  size_t frame_count() const override { return reader_->frame_count(); }
  int64_t timestamp_ns(size_t frame) const override { return reader_->timestamp_ns(frame); }
  int drive(size_t frame) const override { return reader_->drive(frame); }
  absl::StatusOr<SensorImages> Read(size_t frame) const override {
    ASSIGN_OR_RETURN(SensorImages images, reader_->Read(frame));
    images.imu.clear();
    return images;
  }

 private:
  const std::unique_ptr<FrameReader> reader_;
  SensorCalibration calibration_;
  SourceDescription description_;
};

}  // namespace

std::unique_ptr<FrameReader> WithoutImu(std::unique_ptr<FrameReader> reader,
                                        const std::string& why) {
  const bool has_imu =
      std::visit([](const auto& kind) { return kind.imu.has_value(); }, reader->calibration());
  if (!has_imu) return reader;
  return std::make_unique<ReaderWithoutImu>(std::move(reader), why);
}

}  // namespace corbslam::client_agent
