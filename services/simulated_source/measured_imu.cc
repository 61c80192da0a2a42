#include "services/simulated_source/measured_imu.h"

#include <memory>
#include <utility>

#include "client_agent/source/lists/imu_list.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

absl::StatusOr<SimulatedImu> ReadMeasuredImu(const std::string& path, SimulatedImu imu) {
  client_agent::SourceRemarks remarks;
  ASSIGN_OR_RETURN(ImuSamples samples, client_agent::ReadImuList(path, remarks));
  if (!remarks.findings.empty()) {
    return absl::InvalidArgumentError(remarks.findings.front().text);
  }
  imu.grade.reset();
  imu.file = path;
  imu.measured = std::make_shared<const ImuSamples>(std::move(samples));
  return imu;
}

}  // namespace corbslam::services
