#include "services/tool/doctor/fusion_check.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "corbslam/v1/map_store_service.grpc.pb.h"

namespace corbslam::services {
namespace {

// Asks for page after page. Returns an error if a page does not come.
grpc::Status ReadMissions(const std::shared_ptr<grpc::Channel>& channel, absl::Duration patience,
                          std::vector<v1::Mission>& missions) {
  const auto stub = v1::MapStore::NewStub(channel);
  v1::ListMissionsRequest request;
  do {
    grpc::ClientContext context;
    context.set_deadline(absl::ToChronoTime(absl::Now() + patience));
    v1::ListMissionsResponse response;
    const grpc::Status status = stub->ListMissions(&context, request, &response);
    if (!status.ok()) return status;
    missions.insert(missions.end(), response.missions().begin(), response.missions().end());
    request.set_page_token(response.next_page_token());
  } while (!request.page_token().empty());
  return grpc::Status::OK;
}

// Who may not look into missions is told nothing; any other error leaves some of them unseen.
Findings JudgeReading(const std::string& name, const grpc::Status& status, size_t seen) {
  if (status.ok() || status.error_code() == grpc::StatusCode::PERMISSION_DENIED ||
      status.error_code() == grpc::StatusCode::UNAUTHENTICATED) {
    return {};
  }
  return {{Level::kFail, name,
           absl::StrCat("does not list all of its missions (", seen,
                        " came): ", status.error_message()),
           "what is wrong with the others is not known; its log says more"}};
}

}  // namespace

Findings CheckFusionOf(const std::string& name, const std::vector<v1::Mission>& missions) {
  // A damaged mission is fused no more, and says nothing of the workers.
  std::vector<const v1::Mission*> whole;
  for (const v1::Mission& mission : missions) {
    if (mission.damage().empty()) whole.push_back(&mission);
  }
  if (whole.empty()) return {};
  if (std::ranges::any_of(whole, [](const auto* any) { return any->lacks_fusion_worker(); })) {
    return {{Level::kWarn, name, "has no fusion worker: maps are collected and never fused",
             "start it with --worker HOST:PORT or --in-process-worker"}};
  }
  uint64_t waiting = 0;
  for (const v1::Mission* mission : whole) waiting += mission->waiting_queries();
  const auto away =
      std::ranges::find_if(whole, [](const auto* any) { return any->worker_away_since_ns() != 0; });
  if (away == whole.end()) {
    return {{Level::kOk, name,
             absl::StrCat("has fusion workers, and no request to them has failed since the last "
                          "that was taken; look-ups waiting: ",
                          waiting),
             ""}};
  }
  const std::string since =
      absl::FormatTime("%Y-%m-%d %H:%M:%S", absl::FromUnixNanos((*away)->worker_away_since_ns()),
                       absl::LocalTimeZone());
  return {{Level::kFail, name,
           absl::StrCat("no fusion worker takes its requests since ", since,
                        ", look-ups waiting: ", waiting, " (", (*away)->worker_error(), ")"),
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
  std::vector<v1::Mission> missions;
  const grpc::Status status = ReadMissions(channel, patience, missions);
  Findings findings = JudgeReading(name, status, missions.size());
  for (const Findings& more : {CheckFusionOf(name, missions), CheckDamageOf(name, missions)}) {
    findings.insert(findings.end(), more.begin(), more.end());
  }
  return findings;
}

}  // namespace corbslam::services
