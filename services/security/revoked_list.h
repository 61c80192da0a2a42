// Says whose tokens and certificates are not taken any more, though they are signed and have not
// expired.
#ifndef CORBSLAM_SERVICES_SECURITY_REVOKED_LIST_H_
#define CORBSLAM_SERVICES_SECURITY_REVOKED_LIST_H_

#include <set>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "services/security/identity.h"

namespace corbslam::services {

// Returns true for the error of a server whose list has the caller (RevokedList::Check).
bool SaysRevoked(const absl::Status& status);

// Holds ids of tokens, and grants: whoever shows a token or a certificate with such a grant is
// refused, whatever else it grants. Copyable; thread-safe while nobody assigns to it.
class RevokedList {
 public:
  // Parses a token's id or a grant (services/security/identity.h; "-" matches every mission or
  // agent) a line; what follows a '#' is a comment. INVALID_ARGUMENT names the line.
  static absl::StatusOr<RevokedList> Parse(absl::string_view text);

  // Returns UNAUTHENTICATED, naming the token or the grant, if the identity is revoked.
  absl::Status Check(const Identity& identity) const;

 private:
  std::set<std::string, std::less<>> token_ids_;
  std::vector<Grant> grants_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_SECURITY_REVOKED_LIST_H_
