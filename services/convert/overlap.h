// Converts overlaps to and from the wire.
#ifndef CORBSLAM_SERVICES_CONVERT_OVERLAP_H_
#define CORBSLAM_SERVICES_CONVERT_OVERLAP_H_

#include "absl/status/statusor.h"
#include "corbslam/v1/fusion_worker_service.pb.h"
#include "corbslam/v1/overlap.pb.h"
#include "services/convert/ids.h"
#include "slam/exchange/overlap.h"

namespace corbslam::services {

v1::OverlapVerdict ToProto(OverlapVerdict verdict);
absl::StatusOr<OverlapVerdict> FromProto(v1::OverlapVerdict verdict);
void ToProto(const OverlapEvidence& evidence, v1::OverlapEvidence* proto);
absl::StatusOr<OverlapEvidence> FromProto(const v1::OverlapEvidence& proto);
void ToProto(const Overlap& overlap, SlotWriter& slots, v1::VerifiedOverlap* proto);
absl::StatusOr<Overlap> FromProto(const v1::VerifiedOverlap& proto, const SlotReader& slots);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_CONVERT_OVERLAP_H_
