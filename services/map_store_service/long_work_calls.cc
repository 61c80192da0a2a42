#include <memory>
#include <utility>

#include "services/map_store_service/map_store_service.h"
#include "services/server/refusal.h"
#include "services/server/unary.h"

namespace corbslam::services {
namespace {

// No mission's name is longer.
constexpr size_t kMaxName = 200;

// Returns "missions/a" of "missions/a/agents/b", and the name itself where it is no such one.
std::string MissionPart(const std::string& name) {
  const size_t first = name.find('/');
  return first == std::string::npos ? name : name.substr(0, name.find('/', first + 1));
}

}  // namespace

absl::StatusOr<std::shared_ptr<const void>> MapStoreService::EnterLongWork(
    const grpc::CallbackServerContext& context, const std::string& name) {
  std::string caller = NameOf(context);
  if (caller.empty()) caller = HostOfPeer(context.peer());
  return long_work_.Enter(caller, MissionPart(name.substr(0, kMaxName)));
}

grpc::ServerUnaryReactor* MapStoreService::AnswerLong(TaskPool& pool,
                                                      grpc::CallbackServerContext* context,
                                                      const std::string& name,
                                                      const std::function<absl::Status()>& answer) {
  absl::StatusOr<std::shared_ptr<const void>> ticket = EnterLongWork(*context, name);
  if (!ticket.ok()) return RefuseCall(context, ticket.status());
  const auto kept = std::make_shared<std::shared_ptr<const void>>(*std::move(ticket));
  return AnswerOn(pool, context, [kept, answer] {
    const absl::Status status = answer();
    // The caller may come again at once. What could not be done yet stays counted.
    if (status.ok()) kept->reset();
    return status;
  });
}

}  // namespace corbslam::services
