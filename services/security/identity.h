// Who a caller is: what its certificate or its token says it may be.
#ifndef CORBSLAM_SERVICES_SECURITY_IDENTITY_H_
#define CORBSLAM_SERVICES_SECURITY_IDENTITY_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace corbslam {

enum class Role {
  kAgent,     // Uploads as itself and looks up, in its mission.
  kViewer,    // Looks up.
  kOperator,  // Looks up, deletes, and inspects servers.
  kStore,     // A map store: asks fusion workers.
  kWorker,    // A fusion worker: asks nobody.
};

// Every mission, or every agent of one.
inline constexpr char kAll[] = "-";

// One thing that a caller may be.
struct Grant {
  Role role = Role::kViewer;
  std::string mission;  // Empty for a store and a worker.
  std::string name;

  bool operator==(const Grant&) const = default;
};

// "missions/lab/agents/alpha", ".../viewers/eve", ".../operators/olga", "stores/main",
// "workers/one". The mission may be "-", all; the agent, too. INVALID_ARGUMENT names the text.
absl::StatusOr<Grant> ParseGrant(absl::string_view text);
std::string FormatGrant(const Grant& grant);
// "agent", "viewer", "operator".
absl::StatusOr<Role> ParseMissionRole(absl::string_view text);

struct Identity {
  std::vector<Grant> grants;

  bool operator==(const Identity&) const = default;
};

// For messages: the grants, the first few of many.
std::string Describe(const Identity& identity);

// What a certificate's subject alternative names of type URI grant: "corbslam:" and a grant.
// Others are none of ours. UNAUTHENTICATED where there is none, or where one can't be read.
absl::StatusOr<Identity> IdentityFromUris(const std::vector<std::string>& uris);

}  // namespace corbslam

#endif  // CORBSLAM_SERVICES_SECURITY_IDENTITY_H_
