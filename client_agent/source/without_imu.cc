#include "client_agent/source/without_imu.h"

#include <optional>
#include <utility>
#include <variant>

#include "absl/strings/str_cat.h"
#include "client_agent/source/altered_reader.h"
#include "client_agent/source/imu_opening.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

class ReaderWithoutImu : public AlteredReader {
 public:
  ReaderWithoutImu(std::unique_ptr<FrameReader> reader, const std::string& why)
      : AlteredReader(std::move(reader)) {
    SetImu(std::nullopt, calibration_);
    description_.imu.clear();
    description_.remarks.left_out.push_back(absl::StrCat("what the IMU measured: ", why));
  }

  absl::StatusOr<SensorImages> Read(size_t frame) const override {
    ASSIGN_OR_RETURN(SensorImages images, reader().Read(frame));
    images.imu.clear();
    return images;
  }
  ImuSamples Imu(int64_t /*after_ns*/, int64_t /*until_ns*/) const override { return {}; }
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
