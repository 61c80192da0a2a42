#include "services/security/identity.h"

#include <algorithm>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "services/convert/resource_names.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

constexpr absl::string_view kScheme = "corbslam:";
constexpr size_t kShownGrants = 4;

struct RoleName {
  Role role;
  absl::string_view singular;
  absl::string_view collection;
  bool in_mission;
};
constexpr RoleName kRoleNames[] = {{Role::kAgent, "agent", "agents", true},
                                   {Role::kViewer, "viewer", "viewers", true},
                                   {Role::kOperator, "operator", "operators", true},
                                   {Role::kStore, "store", "stores", false},
                                   {Role::kWorker, "worker", "workers", false}};

const RoleName& NameOf(Role role) { return *std::ranges::find(kRoleNames, role, &RoleName::role); }

absl::Status BadGrant(absl::string_view text) {
  return absl::InvalidArgumentError(
      absl::StrCat("grant is \"", absl::CHexEscape(text.substr(0, 200)),
                   "\", must be missions/{mission}/{agents|viewers|operators}/{name} or "
                   "{stores|workers}/{name}"));
}

absl::Status CheckSegment(absl::string_view field, absl::string_view segment, bool may_be_all) {
  if (may_be_all && segment == kAll) return absl::OkStatus();
  return CheckNameSegment(field, segment);
}

}  // namespace

absl::StatusOr<Grant> ParseGrant(absl::string_view text) {
  const std::vector<absl::string_view> parts = absl::StrSplit(text, '/');
  const bool in_mission = parts.size() == 4 && parts[0] == "missions";
  if (!in_mission && parts.size() != 2) return BadGrant(text);
  const absl::string_view collection = parts[parts.size() - 2];
  const auto* found = std::ranges::find(kRoleNames, collection, &RoleName::collection);
  if (found == std::end(kRoleNames) || found->in_mission != in_mission) return BadGrant(text);
  Grant grant = {found->role, {}, std::string(parts.back())};
  if (in_mission) grant.mission = std::string(parts[1]);
  if (in_mission) RETURN_IF_ERROR(CheckSegment("mission", grant.mission, /*may_be_all=*/true));
  RETURN_IF_ERROR(CheckSegment(found->singular, grant.name, grant.role == Role::kAgent));
  return grant;
}

std::string FormatGrant(const Grant& grant) {
  const std::string leaf = absl::StrCat(NameOf(grant.role).collection, "/", grant.name);
  if (!NameOf(grant.role).in_mission) return leaf;
  return absl::StrCat(MissionName(grant.mission), "/", leaf);
}

absl::StatusOr<Role> ParseMissionRole(absl::string_view text) {
  const auto* found = std::ranges::find(kRoleNames, text, &RoleName::singular);
  if (found != std::end(kRoleNames) && found->in_mission) return found->role;
  return absl::InvalidArgumentError(
      absl::StrCat("role is \"", text, "\", must be agent, viewer or operator"));
}

std::string Describe(const Identity& identity) {
  std::vector<std::string> names;
  for (const Grant& grant : identity.grants) {
    if (names.size() == kShownGrants) {
      names.push_back("...");
      break;
    }
    names.push_back(FormatGrant(grant));
  }
  return absl::StrJoin(names, " ");
}

absl::StatusOr<Identity> IdentityFromUris(const std::vector<std::string>& uris) {
  Identity identity;
  for (const std::string& uri : uris) {
    absl::string_view text = uri;
    if (!absl::ConsumePrefix(&text, kScheme)) continue;
    absl::StatusOr<Grant> grant = ParseGrant(text);
    if (!grant.ok()) {
      return absl::UnauthenticatedError(
          absl::StrCat("the caller's certificate: ", grant.status().message()));
    }
    identity.grants.push_back(*std::move(grant));
  }
  if (!identity.grants.empty()) return identity;
  return absl::UnauthenticatedError(
      absl::StrCat("the caller's certificate names nobody: it has no URI that begins with ",
                   kScheme, " (docs/security.md)"));
}

}  // namespace corbslam::services
