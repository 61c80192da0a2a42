#include "services/tool/doctor/server_checks.h"

#include <google/protobuf/descriptor.h>

#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/time/clock.h"
#include "corbslam/v1/fusion_worker_service.pb.h"
#include "corbslam/v1/map_store_service.pb.h"
#include "services/client/reachability/cause.h"
#include "services/client/reachability/proxy.h"
#include "services/client/reachability/tls_probe.h"
#include "services/client/reflection/generic_client.h"
#include "services/client/remote/channel.h"
#include "services/client/remote/health_client.h"
#include "services/runtime/address.h"
#include "services/security/certificate_checks.h"
#include "services/security/pem_files.h"
#include "services/server/server.h"
#include "services/tool/doctor/fusion_check.h"

namespace corbslam::services {
namespace {

constexpr absl::Duration kPatience = absl::Seconds(5);

// Returns the methods that this program knows of `service`. The linker keeps the messages that are
// named here.
std::set<std::string> OwnMethods(const std::string& service) {
  v1::ListMissionsRequest::descriptor();
  v1::FuseMapsRequest::descriptor();
  const auto* descriptor =
      google::protobuf::DescriptorPool::generated_pool()->FindServiceByName(service);
  std::set<std::string> methods;
  for (int i = 0; descriptor != nullptr && i < descriptor->method_count(); ++i) {
    methods.insert(descriptor->method(i)->name());
  }
  return methods;
}

// Returns what the server's certificate shows, or why no TLS connection comes about. The server
// must be reached.
Findings CheckCertificate(const std::string& name, const ServerTarget& target,
                          const HostPort& address, absl::Time now) {
  const auto pem = FetchCertificates(address, kPatience);
  if (!pem.ok()) {
    const Cause cause = FindCauseOfTransport(target, kPatience)
                            .value_or(Cause{std::string(pem.status().message()), ""});
    return {{Level::kFail, name, cause.text, cause.advice}};
  }
  Findings findings = {CheckExpiry(name, *pem, now), CheckHost(name, *pem, address.host)};
  const auto authorities = ReadAuthorities(target.security.ca_file);
  if (authorities.ok()) findings.push_back(CheckChain(name, *pem, *authorities));
  return findings;
}

// Checks whether the server is where the address says, and speaks TLS or not as this side does.
Findings CheckWay(const std::string& name, const ServerTarget& target, absl::Time now) {
  if (const auto cause = FindCauseOfWay(target, kPatience); cause.has_value()) {
    return {{Level::kFail, name, "is not reached: " + cause->text, cause->advice}};
  }
  const HostPort address = *ParseServerAddress(target.address);
  if (const auto proxy = FindProxy(address.host); proxy.has_value()) {
    return {
        {Level::kWarn, name,
         absl::StrCat("is reached through ", proxy->url, ", because ", proxy->variable, " is set"),
         "add its host to no_proxy, unless a proxy is wanted"}};
  }
  Findings findings = {{Level::kOk, name, "is reached", ""}};
  if (!target.security.insecure) {
    const Findings certificate = CheckCertificate(name, target, address, now);
    findings.insert(findings.end(), certificate.begin(), certificate.end());
  } else if (const auto cause = FindCauseOfTransport(target, kPatience); cause.has_value()) {
    findings.push_back({Level::kFail, name, cause->text, cause->advice});
  }
  return findings;
}

Finding CheckReady(const std::string& name, const std::shared_ptr<grpc::Channel>& channel) {
  const absl::Status health = CheckHealth(channel, kReadiness);
  if (health.ok()) return {Level::kOk, name, "is ready", ""};
  if (absl::IsUnimplemented(health) || absl::IsUnauthenticated(health)) {
    return {Level::kWarn, name, absl::StrCat("does not say how it is: ", health.message()),
            "--health=open lets everybody ask; or give --tls-cert and --tls-key"};
  }
  return {Level::kFail, name, absl::StrCat("is not ready: ", health.message()),
          "its log says why; a full disk is the usual reason"};
}

Finding CheckInterface(const std::string& name, const ServerTarget& target,
                       const std::shared_ptr<grpc::Channel>& channel) {
  GenericClient client(channel);
  const auto services = client.ListServices();
  if (!services.ok()) {
    return {Level::kWarn, name,
            absl::StrCat("does not say what it offers: ", services.status().message()),
            "with --reflection=on, and with an identity, versions can be compared"};
  }
  if (const auto cause = FindCauseOfService(target, channel, kPatience); cause.has_value()) {
    return {Level::kFail, name, "is another server: " + cause->text, cause->advice};
  }
  const auto methods = client.ListMethods(target.service);
  if (!methods.ok()) return {Level::kWarn, name, std::string(methods.status().message()), ""};
  return CompareMethods(name, OwnMethods(target.service), {methods->begin(), methods->end()});
}

}  // namespace

Finding CompareMethods(const std::string& name, const std::set<std::string>& own,
                       const std::set<std::string>& theirs) {
  std::vector<std::string> differences;
  for (const std::string& method : own) {
    if (!theirs.contains(method)) differences.push_back("it lacks " + method);
  }
  for (const std::string& method : theirs) {
    if (!own.contains(method)) differences.push_back("this program lacks " + method);
  }
  if (differences.empty()) {
    return {Level::kOk, name, "speaks the same interface as this program", ""};
  }
  return {Level::kWarn, name,
          absl::StrCat("is of another version: ", absl::StrJoin(differences, ", ")),
          "install the same version on both"};
}

Findings CheckServer(const std::string& name, const std::string& address,
                     const std::string& service, const SecurityOptions& options, absl::Time now) {
  const std::string check = absl::StrCat(name, " ", address);
  const ServerTarget target = {address, service, options};
  Findings findings = CheckWay(check, target, now);
  const auto credentials = MakeChannelCredentials(options);
  if (!credentials.ok()) {
    findings.push_back({Level::kFail, check, std::string(credentials.status().message()),
                        "docs/security.md says which flags it needs"});
  }
  if (AnyFailed(findings)) return findings;
  const auto channel = MakeChannel(address, *credentials);
  if (!channel->WaitForConnected(absl::ToChronoTime(absl::Now() + kPatience))) {
    const Cause cause = FindCause(target).value_or(Cause{"no connection stands", ""});
    findings.push_back({Level::kFail, check, cause.text, cause.advice});
    return findings;
  }
  findings.push_back(CheckReady(check, channel));
  findings.push_back(CheckInterface(check, target, channel));
  if (AnyFailed(findings) || service != kMapStoreService) return findings;
  const Findings fusion = CheckFusion(check, channel, kPatience);
  findings.insert(findings.end(), fusion.begin(), fusion.end());
  return findings;
}

}  // namespace corbslam::services
