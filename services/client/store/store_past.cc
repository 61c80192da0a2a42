// What StoreReader reads as streams of changes: the map as it is, its past, and events.
#include <atomic>
#include <memory>
#include <thread>
#include <utility>

#include "absl/synchronization/notification.h"
#include "absl/time/clock.h"
#include "services/client/store/call_status.h"
#include "services/client/store/store_reader.h"
#include "services/convert/resource_names.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

// Remembered events come without a pause; how many there are is not told.
constexpr absl::Duration kQuiet = absl::Seconds(2);

// Cancels a call once it has been quiet for a while.
class QuietWatch {
 public:
  explicit QuietWatch(grpc::ClientContext& context)
      : context_(context), heard_ns_(absl::GetCurrentTimeNanos()), thread_([this] { Run(); }) {}
  ~QuietWatch() {
    ended_.Notify();
    thread_.join();
  }
  void Hear() { heard_ns_ = absl::GetCurrentTimeNanos(); }
  bool has_cancelled() const { return has_cancelled_; }

 private:
  void Run() {
    absl::Duration left = kQuiet;
    while (left > absl::ZeroDuration() && !ended_.WaitForNotificationWithTimeout(left)) {
      left = kQuiet - absl::Nanoseconds(absl::GetCurrentTimeNanos() - heard_ns_);
    }
    if (left > absl::ZeroDuration()) return;
    has_cancelled_ = true;
    context_.TryCancel();
  }

  grpc::ClientContext& context_;
  std::atomic<int64_t> heard_ns_;
  std::atomic<bool> has_cancelled_ = false;
  absl::Notification ended_;
  std::thread thread_;
};

}  // namespace

absl::StatusOr<ToldMap> StoreReader::ReadMap() {
  grpc::ClientContext context;
  SetStreamDeadline(context);
  v1::WatchMapRequest request;
  request.set_mission(MissionName(mission_));
  request.set_include_points(true);
  const auto reader = stub_->WatchMap(&context, request);
  ToldMap map;
  v1::WatchMapResponse response;
  bool is_whole = false;
  absl::Status status;
  while (!is_whole && status.ok() && reader->Read(&response)) {
    status = map.Apply(response);
    is_whole = !response.continues();
  }
  // The call is cancelled, since later changes would follow.
  if (is_whole || !status.ok()) context.TryCancel();
  const grpc::Status end = reader->Finish();
  RETURN_IF_ERROR(status);
  if (is_whole) return map;
  RETURN_IF_ERROR(ToStatus(end, "WatchMap"));
  return absl::UnavailableError("WatchMap: the map store ended before the map was whole");
}

absl::StatusOr<std::vector<v1::WatchMapResponse>> StoreReader::ReadPast(uint32_t max_revisions) {
  grpc::ClientContext context;
  SetStreamDeadline(context);
  v1::ReplayMapRequest request;
  request.set_mission(MissionName(mission_));
  request.set_include_points(true);
  request.set_max_revisions(max_revisions);
  const auto reader = stub_->ReplayMap(&context, request);
  std::vector<v1::WatchMapResponse> past;
  v1::WatchMapResponse response;
  while (reader->Read(&response)) past.push_back(std::move(response));
  RETURN_IF_ERROR(ToStatus(reader->Finish(), "ReplayMap"));
  if (past.empty() || past.back().continues()) {
    return absl::DataLossError("ReplayMap: the past came only in part");
  }
  return past;
}

absl::Status StoreReader::ReplayMap(uint32_t max_revisions, const OnMoment& on_moment) {
  grpc::ClientContext context;
  SetStreamDeadline(context);
  v1::ReplayMapRequest request;
  request.set_mission(MissionName(mission_));
  request.set_max_revisions(max_revisions);
  const auto reader = stub_->ReplayMap(&context, request);
  ToldMap map;
  v1::WatchMapResponse response;
  response.set_continues(false);
  absl::Status status;
  while (status.ok() && reader->Read(&response)) {
    status = map.Apply(response);
    if (status.ok() && !response.continues()) status = on_moment(map);
  }
  if (!status.ok()) context.TryCancel();
  const grpc::Status end = reader->Finish();
  RETURN_IF_ERROR(status);
  RETURN_IF_ERROR(ToStatus(end, "ReplayMap"));
  if (!response.continues()) return absl::OkStatus();
  return absl::UnavailableError("ReplayMap: the map store ended within a moment");
}

absl::StatusOr<std::vector<v1::MissionEvent>> StoreReader::ReadEvents() {
  grpc::ClientContext context;
  SetStreamDeadline(context);
  v1::WatchEventsRequest request;
  request.set_mission(MissionName(mission_));
  const auto reader = stub_->WatchEvents(&context, request);
  std::vector<v1::MissionEvent> events;
  v1::MissionEvent event;
  QuietWatch watch(context);
  while (reader->Read(&event)) {
    watch.Hear();
    events.push_back(event);
  }
  const grpc::Status end = reader->Finish();
  if (!watch.has_cancelled()) RETURN_IF_ERROR(ToStatus(end, "WatchEvents"));
  return events;
}

}  // namespace corbslam::services
