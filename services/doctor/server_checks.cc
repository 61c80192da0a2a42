#include "services/doctor/server_checks.h"

#include <google/protobuf/descriptor.h>

#include <algorithm>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/time/clock.h"
#include "corbslam/v1/fusion_worker_service.pb.h"
#include "corbslam/v1/map_store_service.pb.h"
#include "services/doctor/certificate_checks.h"
#include "services/doctor/tls_probe.h"
#include "services/reflection/generic_client.h"
#include "services/remote/channel.h"
#include "services/remote/health_client.h"
#include "services/security/pem_files.h"
#include "services/server/server.h"

namespace corbslam {
namespace {

constexpr absl::Duration kPatience = absl::Seconds(5);

// Of this program. The linker keeps what is named here.
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

Findings CheckCertificate(const std::string& name, const std::string& address,
                          const SecurityOptions& options, absl::Time now) {
  const auto pem = FetchCertificates(address, kPatience);
  if (!pem.ok()) {
    return {{Level::kFail, name, std::string(pem.status().message()),
             "start it with a certificate, or say --insecure here, too"}};
  }
  Findings findings = {CheckExpiry(name, *pem, now), CheckHost(name, *pem, HostOf(address))};
  const auto authorities = ReadAuthorities(options.ca_file);
  if (authorities.ok()) findings.push_back(CheckChain(name, *pem, *authorities));
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

Finding CheckInterface(const std::string& name, const std::string& service,
                       const std::shared_ptr<grpc::Channel>& channel) {
  GenericClient client(channel);
  const auto services = client.ListServices();
  if (!services.ok()) {
    return {Level::kWarn, name,
            absl::StrCat("does not say what it offers: ", services.status().message()),
            "with --reflection=on, and with an identity, versions can be compared"};
  }
  if (std::find(services->begin(), services->end(), service) == services->end()) {
    return {Level::kFail, name, absl::StrCat("does not offer ", service),
            "--server is for a map store, --worker for a fusion worker"};
  }
  const auto methods = client.ListMethods(service);
  if (!methods.ok()) return {Level::kWarn, name, std::string(methods.status().message()), ""};
  return CompareMethods(name, OwnMethods(service), {methods->begin(), methods->end()});
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
  const absl::Status reached = ProbeTcp(address, kPatience);
  if (!reached.ok()) {
    return {{Level::kFail, check, absl::StrCat("is not reached: ", reached.message()),
             "is it running, does it listen on this address, and does a firewall let it through?"}};
  }
  Findings findings = {{Level::kOk, check, "is reached", ""}};
  if (!options.insecure) {
    const Findings certificate = CheckCertificate(check, address, options, now);
    findings.insert(findings.end(), certificate.begin(), certificate.end());
  }
  const auto credentials = MakeChannelCredentials(options);
  if (!credentials.ok()) {
    findings.push_back({Level::kFail, check, std::string(credentials.status().message()),
                        "docs/security.md says which flags it needs"});
  }
  if (AnyFailed(findings)) return findings;
  const auto channel = MakeChannel(address, *credentials);
  if (!channel->WaitForConnected(absl::ToChronoTime(absl::Now() + kPatience))) {
    findings.push_back({Level::kFail, check, "is reached, but no connection stands",
                        "does one side use TLS and the other not, or does it want a certificate?"});
    return findings;
  }
  findings.push_back(CheckReady(check, channel));
  findings.push_back(CheckInterface(check, service, channel));
  return findings;
}

}  // namespace corbslam
