#include "services/security/access_control.h"

#include <grpc/grpc_security_constants.h>

#include <algorithm>
#include <utility>

#include "absl/strings/escaping.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "absl/time/clock.h"
#include "corbslam/v1/access.pb.h"
#include "services/convert/asked_resource.h"
#include "services/convert/resource_names.h"
#include "services/convert/status.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using google::protobuf::Message;

namespace {

using Metadata = std::multimap<grpc::string_ref, grpc::string_ref>;

absl::string_view ToView(grpc::string_ref text) { return {text.data(), text.size()}; }

Evidence ReadEvidence(const grpc::AuthContext* context, const Metadata& metadata) {
  Evidence evidence;
  if (context != nullptr) {
    for (const grpc::string_ref& uri : context->FindPropertyValues(GRPC_PEER_URI_PROPERTY_NAME)) {
      evidence.uris.emplace_back(ToView(uri));
    }
  }
  // Two headers are joined to one that no verifier takes.
  const auto [begin, end] = metadata.equal_range("authorization");
  for (auto entry = begin; entry != end; ++entry) {
    evidence.authorization =
        absl::StrCat(evidence.authorization.value_or(""), ToView(entry->second));
  }
  return evidence;
}

class CallGate : public grpc::AuthMetadataProcessor {
 public:
  CallGate(std::shared_ptr<const AccessControl> access, TurnedAwayListener on_turned_away)
      : access_(std::move(access)), on_turned_away_(std::move(on_turned_away)) {}

  // Verifying a signature takes a fraction of a millisecond.
  bool IsBlocking() const override { return false; }

  grpc::Status Process(const InputMetadata& metadata, grpc::AuthContext* context, OutputMetadata*,
                       OutputMetadata*) override {
    const absl::string_view path = Find(metadata, ":path");
    const Evidence evidence = ReadEvidence(context, metadata);
    const absl::Status status = access_->CheckMethod(path, evidence, absl::Now());
    if (!status.ok() && on_turned_away_ != nullptr) {
      on_turned_away_(absl::StripPrefix(path, "/"), evidence, Find(metadata, "user-agent"), status);
    }
    return ToGrpcStatus(status);
  }

 private:
  static absl::string_view Find(const InputMetadata& metadata, const char* key) {
    const auto entry = metadata.find(key);
    return entry != metadata.end() ? ToView(entry->second) : absl::string_view();
  }

  const std::shared_ptr<const AccessControl> access_;
  const TurnedAwayListener on_turned_away_;
};

absl::StatusOr<std::string> MissionOf(absl::string_view name) {
  const std::vector<absl::string_view> parts = absl::StrSplit(name, '/');
  if (parts.size() < 2 || parts[0] != "missions") {
    return absl::InvalidArgumentError(absl::StrCat("name is \"",
                                                   absl::CHexEscape(name.substr(0, 200)),
                                                   "\", must begin with missions/{mission}"));
  }
  RETURN_IF_ERROR(CheckNameSegment("mission", parts[1]));
  return std::string(parts[1]);
}

// Returns whether a call says whatever the action is about, if it names these.
bool SaysEnough(Action action, bool names_mission, bool names_agent) {
  switch (action) {
    case Action::kListMissions:
    case Action::kCompute:
      return true;
    case Action::kUpload:
    case Action::kCommand:
      return names_mission && names_agent;
    default:
      return names_mission;
  }
}

class IdentifiedCaller : public KnownCaller {
 public:
  IdentifiedCaller(const AccessControl& access, absl::StatusOr<Identity> identity)
      : access_(access), identity_(std::move(identity)) {}

  std::string name() const override {
    if (!identity_.ok()) return "";
    const std::string token =
        identity_->token_id.empty() ? "" : absl::StrCat(" (token ", identity_->token_id, ")");
    return absl::StrCat(Describe(*identity_), token);
  }
  absl::Status MayStay() const override {
    return identity_.ok() ? access_.CheckNotRevoked(*identity_) : identity_.status();
  }
  bool MayLook(const std::string& mission) const override {
    return identity_.ok() && Authorise(*identity_, {Action::kLook, mission, std::nullopt}).ok();
  }

 private:
  const AccessControl& access_;
  const absl::StatusOr<Identity> identity_;
};

}  // namespace

Evidence EvidenceOf(const grpc::ServerContextBase& context) {
  return ReadEvidence(context.auth_context().get(), context.client_metadata());
}

absl::Status AccessControl::CheckClaims(const TokenClaims& claims, absl::Time now) const {
  RETURN_IF_ERROR(CheckExpiry(claims, now));
  if (!claims.audience.empty() && claims.audience != options_.audience) {
    return absl::UnauthenticatedError(
        absl::StrCat("the caller's token ", claims.id, " is for servers called ", claims.audience,
                     options_.audience.empty() ? "; this one has no name (--token-audience)"
                                               : absl::StrCat(", not for ", options_.audience)));
  }
  // A token says itself when it was issued, so that a time to come counts for nothing.
  const absl::Duration lifetime = claims.expires - std::min(claims.issued.value_or(now), now);
  if (lifetime <= options_.max_token_lifetime) return absl::OkStatus();
  return absl::UnauthenticatedError(
      absl::StrCat("the caller's token ", claims.id, " is good for ",
                   absl::FormatDuration(absl::Trunc(lifetime, absl::Seconds(1))),
                   "; this server takes none of over ",
                   absl::FormatDuration(options_.max_token_lifetime), " (--max-token-lifetime)"));
}

absl::StatusOr<Identity> AccessControl::IdentifyToken(absl::string_view token, const Rules& rules,
                                                      absl::Time now) const {
  constexpr absl::string_view kBearer = "bearer ";
  if (!absl::StartsWithIgnoreCase(token, kBearer)) {
    return absl::UnauthenticatedError("authorization must be: Bearer TOKEN");
  }
  if (!rules.tokens) {
    return absl::UnauthenticatedError("this server takes no tokens (it has no --token-key)");
  }
  token.remove_prefix(kBearer.size());
  ASSIGN_OR_RETURN(TokenClaims claims, rules.tokens->Read(token));
  RETURN_IF_ERROR(CheckClaims(claims, now));
  return Identity{std::move(claims.grants), std::move(claims.id)};
}

absl::StatusOr<Identity> AccessControl::Identify(const Evidence& evidence, absl::Time now) const {
  const std::shared_ptr<const Rules> current = rules();
  absl::StatusOr<Identity> identity;
  if (evidence.authorization) {
    identity = IdentifyToken(*evidence.authorization, *current, now);
  } else if (!evidence.uris.empty()) {
    identity = IdentityFromUris(evidence.uris);
  } else {
    identity = absl::UnauthenticatedError(
        "the caller showed neither a certificate with a corbslam: URI nor a token "
        "(docs/security.md)");
  }
  if (identity.ok()) RETURN_IF_ERROR(current->revoked.Check(*identity));
  return identity;
}

absl::Status AccessControl::CheckNotRevoked(const Identity& identity) const {
  return rules()->revoked.Check(identity);
}

std::shared_ptr<const AccessControl::Rules> AccessControl::rules() const {
  absl::MutexLock lock(&mutex_);
  return rules_;
}

void AccessControl::SetTokens(TokenVerifier tokens) {
  absl::MutexLock lock(&mutex_);
  rules_ = std::make_shared<const Rules>(Rules{std::move(tokens), rules_->revoked});
}

void AccessControl::SetRevoked(RevokedList revoked) {
  std::vector<std::function<void()>> listeners;
  {
    absl::MutexLock lock(&mutex_);
    rules_ = std::make_shared<const Rules>(Rules{rules_->tokens, std::move(revoked)});
    listeners = listeners_;
  }
  for (const std::function<void()>& listener : listeners) listener();
}

void AccessControl::OnRevoked(std::function<void()> listener) const {
  absl::MutexLock lock(&mutex_);
  listeners_.push_back(std::move(listener));
}

absl::Status AccessControl::CheckMethod(absl::string_view path, const Evidence& evidence,
                                        absl::Time now) const {
  const std::optional<Action> action = ActionOf(path);
  if (action == Action::kCheckHealth && options_.health_is_open) return absl::OkStatus();
  ASSIGN_OR_RETURN(const Identity identity, Identify(evidence, now));
  if (!action) {
    return absl::PermissionDeniedError(absl::StrCat(Describe(identity), " may not call ",
                                                    absl::CHexEscape(path.substr(0, 200)),
                                                    ", which has no rule"));
  }
  return Authorise(identity, {*action, options_.mission, options_.agent});
}

absl::Status AccessControl::Check(const Access& access, const Evidence& evidence,
                                  absl::Time now) const {
  ASSIGN_OR_RETURN(const Identity identity, Identify(evidence, now));
  return Authorise(identity, access);
}

absl::Status AccessControl::Check(const google::protobuf::MethodDescriptor& method,
                                  const grpc::ServerContextBase& context,
                                  const Message& message) const {
  const v1::Access& asked = method.options().GetExtension(v1::access);
  const std::optional<Action> action = ActionOf(method);
  if (!action || !SaysEnough(*action, asked.mission_size() > 0 || options_.mission,
                             !asked.agent().empty() || options_.agent)) {
    return absl::PermissionDeniedError(
        absl::StrCat(method.full_name(), " does not say what it does, and of which mission"));
  }
  std::optional<std::string> agent = options_.agent;
  if (!asked.agent().empty()) {
    ASSIGN_OR_RETURN(agent, ReadText(message, asked.agent()));
  }
  const Evidence evidence = EvidenceOf(context);
  if (asked.mission_size() == 0) {
    return Check({*action, options_.mission, agent}, evidence, absl::Now());
  }
  for (int i = 0; i < asked.mission_size(); ++i) {
    ASSIGN_OR_RETURN(const std::string name, ReadText(message, asked.mission(i)));
    if (i > 0 && name.empty()) continue;
    // That the caller may do it in some mission was checked with the call.
    if (asked.or_all_missions() && name == kAllMissions) continue;
    Access access{*action, std::nullopt, agent};
    ASSIGN_OR_RETURN(access.mission, MissionOf(name));
    RETURN_IF_ERROR(Check(access, evidence, absl::Now()));
  }
  return absl::OkStatus();
}

std::shared_ptr<const KnownCaller> AccessControl::Meet(
    const grpc::ServerContextBase& context) const {
  return std::make_shared<const IdentifiedCaller>(*this,
                                                  Identify(EvidenceOf(context), absl::Now()));
}

std::shared_ptr<grpc::AuthMetadataProcessor> MakeCallGate(
    std::shared_ptr<const AccessControl> access, TurnedAwayListener on_turned_away) {
  return std::make_shared<CallGate>(std::move(access), std::move(on_turned_away));
}

}  // namespace corbslam::services
