#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "services/convert/resource_names.h"
#include "services/map_store_service/map_changes_to_proto.h"
#include "services/map_store_service/map_store_service.h"
#include "services/map_store_service/streams/watch_reactor.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using map_store::MapChanges;
using map_store::MapStore;
using map_store::MapWatcher;

namespace {

// So many keyframes and points are read under one lock, which takes some two milliseconds.
constexpr size_t kItemsInAPiece = 5000;

// Sends what changed in the map.
class WatchMapReactor : public WatchReactor<v1::WatchMapResponse> {
 public:
  WatchMapReactor(MapStore& store, TaskPool& pool, const v1::WatchMapRequest& request,
                  absl::StatusOr<std::unique_ptr<StreamLimits::Ticket>> ticket)
      : WatchReactor(pool, std::move(ticket)),
        store_(store),
        name_(request.mission()),
        watcher_(request.from_version(), request.include_points()) {}

 private:
  absl::Status Subscribe(std::function<void()> listener) override {
    ASSIGN_OR_RETURN(mission_, ParseMissionName(name_));
    ASSIGN_OR_RETURN(token_, store_.AddMapListener(mission_, std::move(listener)));
    return absl::OkStatus();
  }

  absl::StatusOr<Found> Poll() override {
    ASSIGN_OR_RETURN(const std::optional<MapChanges> changes,
                     store_.NextChanges(mission_, kItemsInAPiece, watcher_));
    if (!changes.has_value()) return Found();
    return Found{ToProto(*changes), changes->continues};
  }

  void Unsubscribe() override { store_.RemoveMapListener(mission_, token_); }

  MapStore& store_;
  const std::string name_;
  MapWatcher watcher_;
  std::string mission_;
  uint64_t token_ = 0;
};

}  // namespace

grpc::ServerWriteReactor<v1::WatchMapResponse>* MapStoreService::WatchMap(
    grpc::CallbackServerContext* context, const v1::WatchMapRequest* request) {
  auto* reactor = new WatchMapReactor(store_, pool_, *request,
                                      limits_.Enter(context->peer(), MayStay(*context)));
  reactor->Start();
  return reactor;
}

}  // namespace corbslam::services
