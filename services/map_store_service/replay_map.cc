#include <deque>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "services/convert/resource_names.h"
#include "services/map_store_service/map_changes_to_proto.h"
#include "services/map_store_service/map_store_service.h"
#include "services/server/unary.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using map_store::MapChanges;
using map_store::ReplayOptions;

namespace {

// What a replay asks for.
struct Question {
  std::string mission;
  ReplayOptions options;
};

absl::StatusOr<Question> Read(const v1::ReplayMapRequest& request) {
  Question question;
  ASSIGN_OR_RETURN(question.mission, ParseMissionName(request.mission()));
  question.options.include_points = request.include_points();
  if (request.max_moments() != 0) question.options.max_moments = request.max_moments();
  RETURN_IF_ERROR(question.options.Validate());
  return question;
}

// Counts the stream among all streams, and among replays, until it has ended.
absl::StatusOr<std::shared_ptr<const void>> Enter(const std::string& peer, StreamLimits& limits,
                                                  ReplaySlots& slots) {
  struct Tickets {
    std::unique_ptr<StreamLimits::Ticket> stream;
    std::shared_ptr<const void> replay;
  };
  const auto tickets = std::make_shared<Tickets>();
  ASSIGN_OR_RETURN(tickets->stream, limits.Enter(peer));
  ASSIGN_OR_RETURN(tickets->replay, slots.Take());
  return tickets;
}

// Gives away the pieces one by one, so that what was read takes no memory any more.
class Past {
 public:
  explicit Past(std::vector<MapChanges> pieces)
      : pieces_(std::make_move_iterator(pieces.begin()), std::make_move_iterator(pieces.end())) {}

  bool FillNext(v1::WatchMapResponse& response) {
    if (messages_.empty() && !pieces_.empty()) {
      for (v1::WatchMapResponse& message : ToProto(pieces_.front())) {
        messages_.push_back(std::move(message));
      }
      pieces_.pop_front();
    }
    if (messages_.empty()) return false;
    response = std::move(messages_.front());
    messages_.pop_front();
    return true;
  }

 private:
  std::deque<MapChanges> pieces_;
  std::deque<v1::WatchMapResponse> messages_;  // Those of one piece.
};

}  // namespace

grpc::ServerWriteReactor<v1::WatchMapResponse>* MapStoreService::ReplayMap(
    grpc::CallbackServerContext* context, const v1::ReplayMapRequest* request) {
  using Reactor = StreamReactor<v1::WatchMapResponse>;
  const absl::StatusOr<Question> question = Read(*request);
  if (!question.ok()) return Reactor::Start(replay_pool_, question.status(), nullptr);
  return Reactor::Start(
      replay_pool_, Enter(context->peer(), limits_, replay_slots_),
      [this, context, asked = *question]() -> absl::StatusOr<Reactor::Next> {
        const auto goes_on = [context] { return !context->IsCancelled(); };
        ASSIGN_OR_RETURN(std::vector<MapChanges> pieces,
                         store_.ReplayMap(asked.mission, asked.options, goes_on));
        const auto past = std::make_shared<Past>(std::move(pieces));
        return [past](v1::WatchMapResponse& response) { return past->FillNext(response); };
      },
      &pool_);
}

}  // namespace corbslam::services
