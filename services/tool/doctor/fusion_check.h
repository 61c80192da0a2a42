// Checks whether a map store gets its maps fused.
#ifndef CORBSLAM_SERVICES_TOOL_DOCTOR_FUSION_CHECK_H_
#define CORBSLAM_SERVICES_TOOL_DOCTOR_FUSION_CHECK_H_

#include <grpcpp/channel.h>

#include <memory>
#include <string>
#include <vector>

#include "absl/time/time.h"
#include "corbslam/v1/resources.pb.h"
#include "services/security/finding.h"

namespace corbslam::services {

// Judges the fusion workers by what the missions of a store say of them: they are away if any of
// those that are not damaged says so. Returns no finding if there is no such mission.
Findings CheckFusionOf(const std::string& name, const std::vector<v1::Mission>& missions);

// Returns a failure for each mission that is damaged.
Findings CheckDamageOf(const std::string& name, const std::vector<v1::Mission>& missions);

// Asks the store for all of its missions and judges both. Returns no finding if this caller may not
// ask, and a failure if not all of them come. `patience` is that for each page.
Findings CheckFusion(const std::string& name, const std::shared_ptr<grpc::Channel>& channel,
                     absl::Duration patience);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_DOCTOR_FUSION_CHECK_H_
