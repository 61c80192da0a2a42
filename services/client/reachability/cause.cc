#include "services/client/reachability/cause.h"

#include <array>
#include <utility>
#include <vector>

#include "absl/algorithm/container.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "services/client/reachability/proxy.h"
#include "services/client/reflection/generic_client.h"
#include "services/client/remote/channel.h"
#include "services/client/remote/health_client.h"
#include "services/runtime/address.h"
#include "services/server/server.h"

namespace corbslam::services {
namespace {

struct NamedService {
  absl::string_view service;
  absl::string_view name;
  absl::string_view advice;  // For somebody who wants this service and has met another.
};

constexpr std::array<NamedService, 3> kServices = {{
    {kMapStoreService, "map store",
     "give the address that map_store says it is \"listening on\" (its port is 50051, unless told; "
     "fusion workers are named to the map store, by --worker)"},
    {kFusionWorkerService, "fusion worker",
     "give the address that fusion_worker says it is \"listening on\" (its port is 50052, unless "
     "told)"},
    {"corbslam.v1.Agent", "robot", "give the robot's --listen address"},
}};

const NamedService* FindService(absl::string_view service) {
  const auto it = absl::c_find_if(
      kServices, [service](const NamedService& known) { return known.service == service; });
  return it == kServices.end() ? nullptr : it;
}

// Returns what people call the server that offers these services.
std::string NameOfAny(const std::vector<std::string>& services) {
  for (const std::string& service : services) {
    const NamedService* known = FindService(service);
    if (known != nullptr) return std::string(known->name);
  }
  return "gRPC server of another kind";
}

// Makes credentials without the warning of --insecure: causes are looked for again and again.
absl::StatusOr<std::shared_ptr<grpc::ChannelCredentials>> MakeQuietly(
    const SecurityOptions& security) {
  if (security.insecure) return grpc::InsecureChannelCredentials();
  return MakeChannelCredentials(security);
}

// Programs that run take a new file when it comes.
Cause CauseInOwnFiles(const absl::Status& status) {
  Cause cause{std::string(status.message()),
              "put a good one in its place: a program that runs takes it when it comes"};
  cause.is_own = true;
  return cause;
}

// Asks for the server's health, which every server of ours answers, and returns how the call ended.
absl::Status AskHow(const std::shared_ptr<grpc::Channel>& channel, absl::Duration patience) {
  const absl::Status status = CheckHealth(channel, kLiveness, patience);
  const bool is_answer = !absl::IsUnavailable(status) && !absl::IsDeadlineExceeded(status);
  return is_answer ? absl::OkStatus() : status;
}

// Returns the cause that gRPC's own message names, for when every probe went well and gRPC gets no
// answer.
Cause CauseThatGrpcNames(const ServerTarget& target, const absl::Status& status) {
  Cause cause{std::string(status.message()), "", /*is_certain=*/false};
  const bool has_identity = target.security.insecure || !target.security.certificate_file.empty();
  if (!has_identity) {
    cause.advice = "it may want a certificate of its callers: --tls-cert and --tls-key";
  }
  const absl::StatusOr<HostPort> address = ParseServerAddress(target.address);
  const std::optional<Proxy> proxy = address.ok() ? FindProxy(address->host) : std::nullopt;
  if (proxy.has_value()) {
    cause.advice = absl::StrCat(proxy->variable, " is ", proxy->url,
                                ": if the server is not to be "
                                "reached through that proxy, add its host to no_proxy");
  }
  return cause;
}

}  // namespace

std::string NameOfService(const std::string& service) {
  const NamedService* known = FindService(service);
  return known == nullptr ? service : std::string(known->name);
}

absl::Status ToStatus(const ServerTarget& target, const Cause& cause) {
  if (cause.is_bad_address) return absl::InvalidArgumentError(cause.text);
  if (cause.is_own) {
    return absl::UnavailableError(absl::StrCat("the ", NameOfService(target.service), " at ",
                                               target.address, " is not called: ", cause.text, "; ",
                                               cause.advice));
  }
  return absl::UnavailableError(absl::StrCat("no ", NameOfService(target.service), " answers at ",
                                             target.address, ": ", cause.text,
                                             cause.advice.empty() ? "" : "; ", cause.advice));
}

std::optional<Cause> FindCauseOfService(const ServerTarget& target,
                                        const std::shared_ptr<grpc::Channel>& channel,
                                        absl::Duration patience) {
  const absl::StatusOr<std::vector<std::string>> services =
      GenericClient(channel).ListServices(patience);
  if (!services.ok() || absl::c_linear_search(*services, target.service)) return std::nullopt;
  const NamedService* wanted = FindService(target.service);
  return Cause{
      absl::StrCat("a ", NameOfAny(*services), " does, which does not offer ", target.service),
      wanted == nullptr ? "" : std::string(wanted->advice)};
}

std::optional<Cause> FindCause(const ServerTarget& target, absl::Duration patience) {
  const auto credentials = MakeQuietly(target.security);
  if (!credentials.ok()) return CauseInOwnFiles(credentials.status());
  if (auto cause = FindCauseOfWay(target, patience); cause.has_value()) return cause;
  if (auto cause = FindCauseOfTransport(target, patience); cause.has_value()) return cause;
  const std::shared_ptr<grpc::Channel> channel = MakeChannel(target.address, *credentials);
  const absl::Status asked = AskHow(channel, patience);
  if (!asked.ok()) return CauseThatGrpcNames(target, asked);
  return FindCauseOfService(target, channel, patience);
}

absl::Status ExplainFailure(const ServerTarget& target, const absl::Status& seen) {
  switch (seen.code()) {
    // These codes come back where no server of the kind answers.
    case absl::StatusCode::kOk:
    case absl::StatusCode::kCancelled:
    case absl::StatusCode::kDeadlineExceeded:
    case absl::StatusCode::kInternal:
    case absl::StatusCode::kUnavailable:
    case absl::StatusCode::kUnimplemented:
    case absl::StatusCode::kUnknown: {
      std::optional<Cause> cause = FindCause(target);
      // gRPC ends what stands so when nobody answers its pings.
      if (cause.has_value() && absl::StrContains(seen.message(), "keepalive")) {
        cause->text = absl::StrCat("no answer to keepalives; ", cause->text);
      }
      return cause.has_value() ? ToStatus(target, *cause) : seen;
    }
    default:
      return seen;
  }
}

}  // namespace corbslam::services
