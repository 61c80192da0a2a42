#include "services/tool/doctor/fusion_check.h"

#include <grpcpp/client_context.h>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "corbslam/v1/map_store_service.grpc.pb.h"

namespace corbslam::services {

Findings CheckFusionOf(const std::string& name, const std::vector<v1::Mission>& missions) {
  if (missions.empty()) return {};
  // Every mission says the same of the workers.
  const v1::Mission& any = missions.front();
  if (any.lacks_fusion_worker()) {
    return {{Level::kWarn, name, "has no fusion worker: maps are collected and never fused",
             "start it with --worker HOST:PORT or --in-process-worker"}};
  }
  if (any.worker_away_since_ns() == 0) {
    return {{Level::kOk, name, "has fusion workers that take its requests", ""}};
  }
  uint64_t waiting = 0;
  for (const v1::Mission& mission : missions) waiting += mission.waiting_queries();
  const std::string since = absl::FormatTime(
      "%Y-%m-%d %H:%M:%S", absl::FromUnixNanos(any.worker_away_since_ns()), absl::LocalTimeZone());
  return {{Level::kFail, name,
           absl::StrCat("no fusion worker takes its requests since ", since,
                        ", look-ups waiting: ", waiting, " (", any.worker_error(), ")"),
           "start fusion workers where the store's --worker says; what waits is worked off then"}};
}

Findings CheckDamageOf(const std::string& name, const std::vector<v1::Mission>& missions) {
  Findings findings;
  for (const v1::Mission& mission : missions) {
    if (mission.damage().empty()) continue;
    findings.push_back({Level::kFail, name, mission.damage(),
                        "docs/alerts.md#missiondamaged; the other missions go on"});
  }
  return findings;
}

Findings CheckFusion(const std::string& name, const std::shared_ptr<grpc::Channel>& channel,
                     absl::Duration patience) {
  grpc::ClientContext context;
  context.set_deadline(absl::ToChronoTime(absl::Now() + patience));
  v1::ListMissionsResponse response;
  const grpc::Status status =
      v1::MapStore::NewStub(channel)->ListMissions(&context, v1::ListMissionsRequest(), &response);
  if (!status.ok()) return {};
  const std::vector<v1::Mission> missions = {response.missions().begin(),
                                             response.missions().end()};
  Findings findings = CheckFusionOf(name, missions);
  const Findings damaged = CheckDamageOf(name, missions);
  findings.insert(findings.end(), damaged.begin(), damaged.end());
  return findings;
}

}  // namespace corbslam::services
