// Finds what a call is about, by what stands at the call in the contract
// (corbslam/v1/access.proto).
#ifndef CORBSLAM_SERVICES_CONVERT_ASKED_RESOURCE_H_
#define CORBSLAM_SERVICES_CONVERT_ASKED_RESOURCE_H_

#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include <string>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace corbslam::services {

// Returns the call of our contract with a path such as "/corbslam.v1.MapStore/Sync"; null where
// there is none.
const google::protobuf::MethodDescriptor* FindMethod(absl::string_view path);

// Returns the text of a field such as "name" or "mission.name"; INTERNAL where there is none.
absl::StatusOr<std::string> ReadText(const google::protobuf::Message& message,
                                     absl::string_view field);

// Returns the first of the fields that name what the call with this request is about; empty where
// the call names nothing.
std::string ResourceOf(const google::protobuf::MethodDescriptor& method,
                       const google::protobuf::Message& request);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_CONVERT_ASKED_RESOURCE_H_
