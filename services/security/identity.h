// Says who a caller is: what its certificate or its token says it may be.
#ifndef CORBSLAM_SERVICES_SECURITY_IDENTITY_H_
#define CORBSLAM_SERVICES_SECURITY_IDENTITY_H_

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace corbslam::services {

enum class Role {
  kAgent,     // Uploads as itself and reads, in its mission.
  kViewer,    // Reads.
  kOperator,  // Reads, deletes, and inspects servers.
  kStore,     // Is a map store: asks fusion workers.
  kWorker,    // Is a fusion worker: asks nobody.
};

// Stands for every mission, or for every agent of one.
inline constexpr char kAll[] = "-";

// Holds one thing that a caller may be.
struct Grant {
  Role role = Role::kViewer;
  std::string mission;  // Empty for a store and a worker.
  std::string name;

  bool operator==(const Grant&) const = default;
};

// Parses "missions/lab/agents/alpha", ".../viewers/eve", ".../operators/olga", "stores/main" or
// "workers/one". "-" may stand for all missions, and for all agents. INVALID_ARGUMENT names the
// text.
absl::StatusOr<Grant> ParseGrant(absl::string_view text);
std::string FormatGrant(const Grant& grant);
// Parses "agent", "viewer" or "operator".
absl::StatusOr<Role> ParseMissionRole(absl::string_view text);

struct Identity {
  std::vector<Grant> grants;
  std::string token_id = {};  // Of the token that was shown; empty for a certificate.

  bool operator==(const Identity&) const = default;
};

// Writes the grants for messages; only the first few if there are many.
std::string Describe(const Identity& identity);

// Returns what a certificate's subject alternative names of type URI grant: "corbslam:" and a
// grant. Other names are none of ours. UNAUTHENTICATED if there is none of ours, or if one can't be
// read.
absl::StatusOr<Identity> IdentityFromUris(const std::vector<std::string>& uris);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_SECURITY_IDENTITY_H_
