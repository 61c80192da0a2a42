#include <glog/logging.h>
#include <grpcpp/channel.h>

#include "absl/time/clock.h"
#include "corbslam/v1/map_store_service.grpc.pb.h"
#include "services/client/reachability/cause.h"
#include "services/client/remote/channel.h"
#include "services/client/remote/store_route.h"
#include "services/client/store/call_status.h"
#include "services/client/store/store_reader.h"
#include "services/convert/resource_names.h"
#include "services/runtime/address.h"
#include "slam/exchange/mission_elsewhere.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

// Limit for a connection that succeeds at the first attempt.
constexpr absl::Duration kAtOnce = absl::Milliseconds(300);

// Returns false early if the first attempt fails.
bool ConnectAtOnce(grpc::Channel& channel) {
  const auto deadline = absl::ToChronoTime(absl::Now() + kAtOnce);
  grpc_connectivity_state state = channel.GetState(/*try_to_connect=*/true);
  while (state != GRPC_CHANNEL_READY && state != GRPC_CHANNEL_TRANSIENT_FAILURE) {
    if (!channel.WaitForStateChange(state, deadline)) return false;
    state = channel.GetState(/*try_to_connect=*/true);
  }
  return state == GRPC_CHANNEL_READY;
}

// Returns UNAVAILABLE with the cause if no connection stands in the end.
absl::Status WaitForConnection(const ServerTarget& target, absl::Duration patience,
                               grpc::Channel& channel) {
  const absl::Time deadline = absl::Now() + patience;
  if (ConnectAtOnce(channel)) return absl::OkStatus();
  const std::optional<Cause> cause = FindCause(target);
  const absl::Status status =
      ToStatus(target, cause.value_or(Cause{"no connection stands in time", ""}));
  if (cause.has_value() && cause->is_certain) return status;
  if (cause.has_value()) LOG(WARNING) << status.message() << "; it is tried for " << patience;
  return channel.WaitForConnected(absl::ToChronoTime(deadline)) ? absl::OkStatus() : status;
}

// Checks that a map store answers. Every map store refuses this question before it looks at
// anything; another server does not know it.
absl::Status CheckIsStore(const ServerTarget& target,
                          const std::shared_ptr<grpc::Channel>& channel) {
  grpc::ClientContext context;
  SetDeadline(context);
  v1::Mission response;
  const grpc::Status status =
      v1::MapStore::NewStub(channel)->GetMission(&context, v1::GetMissionRequest(), &response);
  // A server of TLS 1.3 refuses a caller's certificate once the connection seems to stand.
  if (status.error_code() == grpc::StatusCode::UNAVAILABLE) {
    return ExplainFailure(target, FromGrpcStatus(status));
  }
  if (status.error_code() != grpc::StatusCode::UNIMPLEMENTED) return absl::OkStatus();
  const std::optional<Cause> cause = FindCauseOfService(target, channel, absl::Seconds(1));
  return ToStatus(target,
                  cause.value_or(Cause{"another server does",
                                       "is it the port of a fusion worker or of a robot?"}));
}

}  // namespace

absl::StatusOr<std::shared_ptr<grpc::Channel>> ConnectToStore(const std::string& address,
                                                              const SecurityOptions& security,
                                                              absl::Duration patience) {
  RETURN_IF_ERROR(ParseServerAddress(address).status());
  ASSIGN_OR_RETURN(const auto credentials, MakeChannelCredentials(security));
  const ServerTarget target = {address, kMapStoreService, security};
  std::shared_ptr<grpc::Channel> channel = MakeChannel(address, credentials);
  RETURN_IF_ERROR(WaitForConnection(target, patience, *channel));
  RETURN_IF_ERROR(CheckIsStore(target, channel));
  return channel;
}

absl::StatusOr<std::shared_ptr<grpc::Channel>> ConnectToStoreOf(const std::string& mission,
                                                                const std::string& address,
                                                                const SecurityOptions& security,
                                                                absl::Duration patience) {
  const ConnectToOther connect = [&](const std::string& other) {
    return ConnectToStore(other, security, patience);
  };
  ASSIGN_OR_RETURN(std::shared_ptr<grpc::Channel> channel, connect(address));
  StoreRoute route(channel, connect);
  v1::GetMissionRequest request;
  request.set_name(MissionName(mission));
  const absl::Status asked = route.Ask([&request](v1::MapStore::Stub& store) {
    grpc::ClientContext context;
    SetDeadline(context);
    v1::Mission found;
    return ToStatus(store.GetMission(&context, request, &found), "GetMission");
  });
  if (FindElsewhere(asked).has_value()) return asked;
  // Other errors are for those who know what they ask for.
  return route.channel();
}

}  // namespace corbslam::services
