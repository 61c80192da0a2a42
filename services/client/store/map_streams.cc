#include "services/client/store/map_streams.h"

#include "services/client/store/call_status.h"
#include "services/convert/resource_names.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

absl::Status ReadWholeMap(v1::MapStore::Stub& stub, const std::string& mission, bool with_points,
                          const TakeMapMessage& take) {
  grpc::ClientContext context;
  SetStreamDeadline(context);
  v1::WatchMapRequest request;
  request.set_mission(MissionName(mission));
  request.set_include_points(with_points);
  const auto reader = stub.WatchMap(&context, request);
  v1::WatchMapResponse response;
  bool is_complete = false;
  absl::Status taken;
  while (!is_complete && taken.ok() && reader->Read(&response)) {
    taken = take(response);
    is_complete = !response.continues();
  }
  // The call is cancelled, since later revisions would follow. A stream that the store ended keeps
  // its own reason.
  if (is_complete || !taken.ok()) context.TryCancel();
  const grpc::Status status = reader->Finish();
  RETURN_IF_ERROR(taken);
  if (is_complete) return absl::OkStatus();
  if (status.ok()) return absl::DataLossError("WatchMap: the map came only in part");
  return ToStatus(status, "WatchMap");
}

absl::Status ReadReplay(v1::MapStore::Stub& stub, const v1::ReplayMapRequest& request,
                        const TakeMapMessage& take) {
  grpc::ClientContext context;
  SetStreamDeadline(context);
  const auto reader = stub.ReplayMap(&context, request);
  v1::WatchMapResponse response;
  absl::Status taken;
  while (taken.ok() && reader->Read(&response)) taken = take(response);
  if (!taken.ok()) context.TryCancel();
  const grpc::Status status = reader->Finish();
  RETURN_IF_ERROR(taken);
  RETURN_IF_ERROR(ToStatus(status, "ReplayMap"));
  if (!response.continues()) return absl::OkStatus();
  return absl::DataLossError("ReplayMap: the past came only in part");
}

}  // namespace corbslam::services
