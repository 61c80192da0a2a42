#include <glog/logging.h>

#include <string>
#include <utility>

#include "services/convert/resource_names.h"
#include "services/convert/status.h"
#include "services/logging/log_fields.h"
#include "services/map_store_service/lookups_to_proto.h"
#include "services/map_store_service/map_store_service.h"
#include "slam/util/status_macros.h"

namespace corbslam {
namespace {

// Reads the next piece when the one before was taken. Owns itself.
class RestoreReactor : public grpc::ServerReadReactor<v1::RestoreMissionRequest> {
 public:
  using Check = std::function<absl::Status(const std::string& mission)>;

  RestoreReactor(MapStore& store, TaskPool& pool, Check may_restore, v1::Mission* response)
      : store_(store),
        pool_(pool),
        may_restore_(std::move(may_restore)),
        response_(*response),
        restorer_(store.StartRestoring()) {
    StartRead(&request_);
  }

  void OnReadDone(bool ok) override {
    pool_.Schedule([this, ok] {
      const absl::Status status = ok ? Take() : Restore();
      if (ok && status.ok()) return StartRead(&request_);
      Finish(ToGrpcStatus(status));
    });
  }
  void OnDone() override { delete this; }

 private:
  absl::Status Take() {
    if (mission_.empty()) {
      ASSIGN_OR_RETURN(const std::string mission, ParseMissionName(request_.name()));
      RETURN_IF_ERROR(may_restore_(mission));
      mission_ = mission;
    }
    return restorer_.Add(request_.piece());
  }

  absl::Status Restore() {
    if (mission_.empty()) return absl::InvalidArgumentError("no message came");
    ASSIGN_OR_RETURN(map_store::MissionState state, restorer_.Finish());
    RETURN_IF_ERROR(store_.RestoreMission(mission_, std::move(state)));
    LOG(INFO) << LogFields{.mission = mission_} << "mission restored";
    ASSIGN_OR_RETURN(const MissionInfo info, store_.GetMission(mission_));
    ToProto(info, &response_);
    return absl::OkStatus();
  }

  MapStore& store_;
  TaskPool& pool_;
  const Check may_restore_;
  v1::Mission& response_;
  v1::RestoreMissionRequest request_;
  std::string mission_;
  MissionRestorer restorer_;
};

}  // namespace

grpc::ServerReadReactor<v1::RestoreMissionRequest>* MapStoreService::RestoreMission(
    grpc::CallbackServerContext* context, v1::Mission* response) {
  const auto may_restore = [this, context](const std::string& mission) {
    if (options_.may_restore == nullptr) return absl::OkStatus();
    return options_.may_restore(*context, mission);
  };
  return new RestoreReactor(store_, pool_, may_restore, response);
}

}  // namespace corbslam
