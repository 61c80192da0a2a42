#include "services/convert/status.h"

#include <utility>

#include "corbslam/v1/fleet.pb.h"
#include "slam/exchange/mission_elsewhere.h"

namespace corbslam::services {

std::string DetailsOf(const absl::Status& status) {
  const auto elsewhere = FindElsewhere(status);
  if (!elsewhere.has_value()) return "";
  v1::StatusDetails details;
  details.set_code(static_cast<int>(status.code()));
  details.set_message(std::string(status.message()));
  v1::MissionElsewhere said;
  said.set_address(elsewhere->address);
  details.add_details()->PackFrom(said);
  return details.SerializeAsString();
}

absl::Status WithDetails(absl::Status status, const std::string& bytes) {
  v1::StatusDetails details;
  if (bytes.empty() || !details.ParseFromString(bytes)) return status;
  for (const google::protobuf::Any& detail : details.details()) {
    v1::MissionElsewhere said;
    if (detail.UnpackTo(&said)) return WithElsewhere(std::move(status), said.address());
  }
  return status;
}

}  // namespace corbslam::services
