// Says who may do what; no other place does.
#ifndef CORBSLAM_SERVICES_SECURITY_POLICY_H_
#define CORBSLAM_SERVICES_SECURITY_POLICY_H_

#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "services/security/identity.h"

namespace corbslam {

enum class Action {
  kCheckHealth,   // Allowed to everybody with an identity, or to everybody.
  kReflect,       // Allowed to everybody with an identity.
  kLook,          // Allowed to agents, viewers and operators of the mission.
  kListMissions,  // Allowed to callers with a grant for all missions.
  kUpload,        // Allowed to the agent itself.
  kAdminister,    // Allowed to operators of the mission.
  // Looks at a server's connections; allowed to operators of all missions, or of the server's only
  // one.
  kInspect,
  kCompute,  // Allowed to map stores.
};

// Says what a call wants.
struct Access {
  Action action = Action::kLook;
  // Nullopt: not known yet; some mission of the caller's will do.
  std::optional<std::string> mission;
  std::optional<std::string> agent;  // Set for kUpload only; nullopt likewise.
};

// Returns PERMISSION_DENIED, which says who, what, and of which mission, if the caller may not do
// this.
absl::Status Authorise(const Identity& identity, const Access& access);

// Returns what a method does, by its path such as "/corbslam.v1.MapStore/Sync"; nullopt for a
// method that isn't known, which nobody may call.
std::optional<Action> ActionOf(absl::string_view path);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SECURITY_POLICY_H_
