// Converts shared updates and the opening of a session, to and from the wire.
#ifndef CORBSLAM_SERVICES_CONVERT_SHARED_UPDATE_H_
#define CORBSLAM_SERVICES_CONVERT_SHARED_UPDATE_H_

#include <cstddef>
#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "corbslam/v1/map_store_service.pb.h"
#include "corbslam/v1/shared_update.pb.h"
#include "services/convert/features.h"
#include "slam/exchange/shared_update.h"
#include "slam/exchange/uplink.h"

namespace corbslam::services {

// Returns one or more messages of about `part_bytes` at most. `sent` has the cameras named on this
// stream and learns those of the update.
std::vector<v1::SharedUpdate> ToProto(const SharedUpdate& update, CameraBook& sent,
                                      size_t part_bytes, FeatureForm form = FeatureForm::kPlain);
// Reads one message. INVALID_ARGUMENT names the item.
absl::StatusOr<SharedUpdate> FromProto(const v1::SharedUpdate& proto, CameraBook& cameras);

// Puts the parts of a shared update together. Not thread-safe.
class SharedUpdateAssembler {
 public:
  // Returns the update once its last part is there. RESOURCE_EXHAUSTED: there are more than
  // kMaxUpdateBytes, uncoded.
  absl::StatusOr<std::optional<SharedUpdate>> Add(const v1::SharedUpdate& part,
                                                  CameraBook& cameras);

 private:
  std::optional<SharedUpdate> started_;
  size_t bytes_ = 0;
};

void ToProto(const SessionRequest& request, v1::OpenSession* proto);
absl::StatusOr<SessionRequest> FromProto(const v1::OpenSession& proto);
void ToProto(const Acknowledgement& acknowledgement, v1::Acknowledgement* proto);
absl::StatusOr<Acknowledgement> FromProto(const v1::Acknowledgement& proto);
void ToProto(const SessionGrant& grant, v1::SessionGrant* proto);
absl::StatusOr<SessionGrant> FromProto(const v1::SessionGrant& proto);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_CONVERT_SHARED_UPDATE_H_
