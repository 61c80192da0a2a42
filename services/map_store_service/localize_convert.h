// Converts questions where a picture was taken, and their answers, to and from the wire.
#ifndef CORBSLAM_SERVICES_MAP_STORE_SERVICE_LOCALIZE_CONVERT_H_
#define CORBSLAM_SERVICES_MAP_STORE_SERVICE_LOCALIZE_CONVERT_H_

#include <string>

#include "absl/status/statusor.h"
#include "corbslam/v1/localize.pb.h"
#include "map_store/locating/localize_query.h"

namespace corbslam::services {

// INVALID_ARGUMENT names the field.
absl::StatusOr<map_store::LocalizeQuery> LocalizeQueryFromProto(const v1::LocalizeRequest& request);
void ToProto(const std::string& mission, const map_store::LocalizeAnswer& answer,
             v1::LocalizeResponse* response);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_MAP_STORE_SERVICE_LOCALIZE_CONVERT_H_
