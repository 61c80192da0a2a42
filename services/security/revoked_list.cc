#include "services/security/revoked_list.h"

#include <algorithm>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "services/security/token.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

// Other servers know the error by these words.
constexpr absl::string_view kIsRevoked = " is revoked";

bool Matches(const std::string& revoked, const std::string& name) {
  return revoked == kAll || revoked == name;
}

bool Matches(const Grant& revoked, const Grant& grant) {
  return revoked.role == grant.role && Matches(revoked.mission, grant.mission) &&
         Matches(revoked.name, grant.name);
}

absl::Status OfLine(size_t line, const absl::Status& status) {
  return absl::InvalidArgumentError(absl::StrCat("line ", line, ": ", status.message()));
}

}  // namespace

absl::StatusOr<RevokedList> RevokedList::Parse(absl::string_view text) {
  RevokedList list;
  size_t number = 0;
  for (absl::string_view line : absl::StrSplit(text, '\n')) {
    ++number;
    line = absl::StripAsciiWhitespace(line.substr(0, line.find('#')));
    if (line.empty()) continue;
    if (absl::StrContains(line, '/')) {
      const absl::StatusOr<Grant> grant = ParseGrant(line);
      if (!grant.ok()) return OfLine(number, grant.status());
      list.grants_.push_back(*grant);
    } else {
      const absl::Status word = CheckTokenWord("a token's id", line);
      if (!word.ok()) return OfLine(number, word);
      list.token_ids_.emplace(line);
    }
  }
  return list;
}

bool SaysRevoked(const absl::Status& status) {
  return absl::IsUnauthenticated(status) && absl::EndsWith(status.message(), kIsRevoked);
}

absl::Status RevokedList::Check(const Identity& identity) const {
  if (!identity.token_id.empty() && token_ids_.contains(identity.token_id)) {
    return absl::UnauthenticatedError(absl::StrCat("the caller's token ", identity.token_id, " (",
                                                   Describe(identity), ")", kIsRevoked));
  }
  for (const Grant& grant : identity.grants) {
    const auto matches = [&grant](const Grant& revoked) { return Matches(revoked, grant); };
    if (std::ranges::any_of(grants_, matches)) {
      return absl::UnauthenticatedError(absl::StrCat(FormatGrant(grant), kIsRevoked));
    }
  }
  return absl::OkStatus();
}

}  // namespace corbslam::services
