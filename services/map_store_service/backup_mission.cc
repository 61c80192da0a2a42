#include <memory>
#include <utility>

#include "services/convert/resource_names.h"
#include "services/map_store_service/map_store_service.h"
#include "services/server/unary.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using map_store::MissionBackup;

namespace {

// A piece with one keyframe more is still shorter than a message may be.
constexpr size_t kPieceBytes = 1 << 20;

}  // namespace

grpc::ServerWriteReactor<v1::BackupMissionResponse>* MapStoreService::BackupMission(
    grpc::CallbackServerContext* context, const v1::BackupMissionRequest* request) {
  using Reactor = StreamReactor<v1::BackupMissionResponse>;
  absl::StatusOr<std::shared_ptr<const void>> ticket = EnterLongWork(*context, request->name());
  if (ticket.ok()) {
    absl::StatusOr<std::shared_ptr<const void>> stream = limits_.Enter(context->peer());
    if (stream.ok()) {
      using Both = std::pair<std::shared_ptr<const void>, std::shared_ptr<const void>>;
      ticket = std::make_shared<const Both>(*std::move(ticket), *std::move(stream));
    } else {
      ticket = stream.status();
    }
  }
  return Reactor::Start(long_pool_, std::move(ticket),
                        [this, name = request->name()]() -> absl::StatusOr<Reactor::Next> {
                          ASSIGN_OR_RETURN(const std::string mission, ParseMissionName(name));
                          ASSIGN_OR_RETURN(MissionBackup taken, store_.BackUpMission(mission));
                          const auto backup = std::make_shared<MissionBackup>(std::move(taken));
                          return [backup](v1::BackupMissionResponse& response) {
                            response.set_piece(backup->Next(kPieceBytes));
                            return !response.piece().empty();
                          };
                        });
}

}  // namespace corbslam::services
