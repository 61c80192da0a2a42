#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "services/convert/resource_names.h"
#include "services/map_store_service/events_to_proto.h"
#include "services/map_store_service/map_store_service.h"
#include "services/map_store_service/streams/watch_reactor.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using map_store::MapStore;

namespace {

// Sends one event after the other. It holds one at a time: what is forgotten while a slow reader
// reads that is counted in the next one.
class WatchEventsReactor : public WatchReactor<v1::MissionEvent> {
 public:
  WatchEventsReactor(MapStore& store, TaskPool& pool, const v1::WatchEventsRequest& request,
                     absl::StatusOr<std::unique_ptr<StreamLimits::Ticket>> ticket)
      : WatchReactor(pool, std::move(ticket)),
        store_(store),
        name_(request.mission()),
        known_(request.after_number()) {}

 private:
  absl::Status Subscribe(std::function<void()> listener) override {
    ASSIGN_OR_RETURN(mission_, ParseMissionName(name_));
    ASSIGN_OR_RETURN(token_, store_.AddEventListener(mission_, std::move(listener)));
    return absl::OkStatus();
  }

  absl::StatusOr<Found> Poll() override {
    ASSIGN_OR_RETURN(const std::optional<map_store::MissionEvent> event,
                     store_.EventAfter(mission_, known_));
    if (!event.has_value()) return Found();
    known_ = event->number;
    Found found;
    ToProto(mission_, *event, &found.messages.emplace_back());
    found.more = true;
    return found;
  }

  void Unsubscribe() override { store_.RemoveEventListener(mission_, token_); }

  MapStore& store_;
  const std::string name_;
  uint64_t known_;  // The number of the last event that was sent.
  std::string mission_;
  uint64_t token_ = 0;
};

}  // namespace

grpc::ServerWriteReactor<v1::MissionEvent>* MapStoreService::WatchEvents(
    grpc::CallbackServerContext* context, const v1::WatchEventsRequest* request) {
  auto* reactor = new WatchEventsReactor(store_, pool_, *request,
                                         limits_.Enter(context->peer(), MayStay(*context)));
  reactor->Start();
  return reactor;
}

}  // namespace corbslam::services
