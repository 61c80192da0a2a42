// Decides what a browser may see, by the token that it shows.
#ifndef CORBSLAM_SERVICES_VIEWER_BROWSER_ACCESS_H_
#define CORBSLAM_SERVICES_VIEWER_BROWSER_ACCESS_H_

#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "services/security/access_control.h"

namespace corbslam::services {

// Takes the tokens that a map store takes (docs/security.md); whoever may look at a mission there
// may look at it here. Immutable, thread-safe.
class BrowserAccess {
 public:
  // Null: everybody may see everything.
  explicit BrowserAccess(std::shared_ptr<const AccessControl> access)
      : access_(std::move(access)) {}

  // UNAUTHENTICATED for no or a bad token, PERMISSION_DENIED for one of other missions.
  absl::Status CheckMission(const std::string& token, const std::string& mission) const;
  // Returns the id of a good token, however it is written; empty for any other.
  std::string TokenId(const std::string& token) const;
  // Returns the names of the missions that the token speaks of; nullopt: it may see all.
  absl::StatusOr<std::optional<std::set<std::string>>> MissionsOf(const std::string& token) const;

 private:
  const std::shared_ptr<const AccessControl> access_;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_VIEWER_BROWSER_ACCESS_H_
