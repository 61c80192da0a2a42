// Says who may do what; no other place does. What a call does stands at it in the proto
// (corbslam/v1/access.proto).
#ifndef CORBSLAM_SERVICES_SECURITY_POLICY_H_
#define CORBSLAM_SERVICES_SECURITY_POLICY_H_

#include <google/protobuf/descriptor.h>

#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "services/security/identity.h"

namespace corbslam::services {

// What a call does; each comment says who may do it.
enum class Action {
  kCheckHealth,   // Everybody with an identity, or everybody.
  kReflect,       // Everybody with an identity.
  kLook,          // Agents, viewers and operators of the mission.
  kListMissions,  // As kLook; the list has the missions that the caller may look into.
  kUpload,        // The agent itself.
  kCommand,       // The agent itself, and operators of the mission.
  kAdminister,    // Operators of the mission.
  kInspect,       // Operators of all missions, or of the server's only one (its connections).
  kCompute,       // Map stores.
};

// Says what a call wants.
struct Access {
  Action action = Action::kLook;
  std::optional<std::string> mission;  // Nullopt: not known yet; one of the caller's will do.
  std::optional<std::string> agent;    // Set for kUpload and kCommand only; nullopt likewise.
};

// Returns OK, or PERMISSION_DENIED, which says who, what, and of which mission.
absl::Status Authorise(const Identity& identity, const Access& access);

// Returns what a method does; nullopt for one that doesn't say it, which nobody may call.
std::optional<Action> ActionOf(const google::protobuf::MethodDescriptor& method);
// Likewise of a path such as "/corbslam.v1.MapStore/Sync", of gRPC's own services too; nullopt for
// a method that isn't known.
std::optional<Action> ActionOf(absl::string_view path);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_SECURITY_POLICY_H_
