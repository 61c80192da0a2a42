#include "services/viewer/browser_access.h"

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

Evidence EvidenceOf(const std::string& token) {
  Evidence evidence;
  if (!token.empty()) evidence.authorization = absl::StrCat("Bearer ", token);
  return evidence;
}

}  // namespace

absl::Status BrowserAccess::CheckMission(const std::string& token,
                                         const std::string& mission) const {
  if (access_ == nullptr) return absl::OkStatus();
  return access_->Check({Action::kLook, mission, std::nullopt}, EvidenceOf(token), absl::Now());
}

std::string BrowserAccess::TokenId(const std::string& token) const {
  if (access_ == nullptr || token.empty()) return "";
  const absl::StatusOr<Identity> identity = access_->Identify(EvidenceOf(token), absl::Now());
  return identity.ok() ? identity->token_id : "";
}

absl::StatusOr<std::optional<std::set<std::string>>> BrowserAccess::MissionsOf(
    const std::string& token) const {
  if (access_ == nullptr) return std::nullopt;
  ASSIGN_OR_RETURN(const Identity identity, access_->Identify(EvidenceOf(token), absl::Now()));
  std::set<std::string> missions;
  for (const Grant& grant : identity.grants) {
    if (!Authorise({{grant}}, {Action::kLook, std::nullopt, std::nullopt}).ok()) continue;
    if (grant.mission == kAll) return std::nullopt;
    missions.insert(grant.mission);
  }
  return missions;
}

}  // namespace corbslam::services
