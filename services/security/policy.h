// The one place that says who may do what.
#ifndef CORBSLAM_SERVICES_SECURITY_POLICY_H_
#define CORBSLAM_SERVICES_SECURITY_POLICY_H_

#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "services/security/identity.h"

namespace corbslam {

enum class Action {
  kCheckHealth,   // Everybody with an identity, or everybody.
  kReflect,       // Everybody with an identity.
  kLook,          // Agents, viewers and operators of the mission.
  kListMissions,  // Whoever has a grant for all missions.
  kUpload,        // The agent itself.
  kAdminister,    // Operators of the mission.
  kInspect,       // Operators of all missions, or of the server's only one: its connections.
  kCompute,       // Map stores.
};

// What a call wants.
struct Access {
  Action action = Action::kLook;
  std::optional<std::string> mission;  // None: not known yet; some mission of the caller's will do.
  std::optional<std::string> agent;    // Of kUpload, likewise.
};

// PERMISSION_DENIED says who, what, and of which mission.
absl::Status Authorise(const Identity& identity, const Access& access);

// What a method does, by its path as "/corbslam.v1.MapStore/Sync"; none for one that isn't known,
// which nobody may call.
std::optional<Action> ActionOf(absl::string_view path);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SECURITY_POLICY_H_
