#include "services/security/access_control.h"

#include <grpc/grpc_security_constants.h>

#include <utility>

#include "absl/strings/escaping.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "services/convert/status.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
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
  explicit CallGate(std::shared_ptr<const AccessControl> access) : access_(std::move(access)) {}

  // Verifying a signature takes a fraction of a millisecond.
  bool IsBlocking() const override { return false; }

  grpc::Status Process(const InputMetadata& metadata, grpc::AuthContext* context, OutputMetadata*,
                       OutputMetadata*) override {
    const auto path = metadata.find(":path");
    return ToGrpcStatus(
        access_->CheckMethod(path != metadata.end() ? ToView(path->second) : absl::string_view(),
                             ReadEvidence(context, metadata), absl::Now()));
  }

 private:
  const std::shared_ptr<const AccessControl> access_;
};

}  // namespace

Evidence EvidenceOf(const grpc::CallbackServerContext& context) {
  return ReadEvidence(context.auth_context().get(), context.client_metadata());
}

absl::StatusOr<Identity> AccessControl::Identify(const Evidence& evidence, absl::Time now) const {
  if (evidence.authorization) {
    absl::string_view token = *evidence.authorization;
    if (!absl::StartsWithIgnoreCase(token, "bearer ")) {
      return absl::UnauthenticatedError("authorization must be: Bearer TOKEN");
    }
    if (!options_.tokens) {
      return absl::UnauthenticatedError("this server takes no tokens (it has no --token-key)");
    }
    token.remove_prefix(sizeof("bearer ") - 1);
    return options_.tokens->Verify(token, now);
  }
  if (!evidence.uris.empty()) return IdentityFromUris(evidence.uris);
  return absl::UnauthenticatedError(
      "the caller showed neither a certificate with a corbslam: URI nor a token "
      "(docs/security.md)");
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

std::shared_ptr<grpc::AuthMetadataProcessor> MakeCallGate(
    std::shared_ptr<const AccessControl> access) {
  return std::make_shared<CallGate>(std::move(access));
}

}  // namespace corbslam::services
