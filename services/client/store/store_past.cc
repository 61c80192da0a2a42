// What StoreReader reads as streams of changes: the map as it is, its past, and events.
#include <atomic>
#include <memory>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/synchronization/notification.h"
#include "absl/time/clock.h"
#include "services/client/store/call_status.h"
#include "services/client/store/map_streams.h"
#include "services/client/store/store_reader.h"
#include "services/convert/resource_names.h"
#include "slam/util/named_thread.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

// Remembered events come without a pause; how many there are is not told.
constexpr absl::Duration kQuiet = absl::Seconds(2);
constexpr int kKeyframesAPage = 1000;

// Cancels a call once it has been quiet for a while.
class QuietWatch {
 public:
  explicit QuietWatch(grpc::ClientContext& context)
      : context_(context),
        heard_ns_(absl::GetCurrentTimeNanos()),
        thread_(StartThread("replay watch", [this] { Run(); })) {}
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
  ToldMap map;
  RETURN_IF_ERROR(ReadPresent(
      /*with_points=*/true,
      [&map](const v1::WatchMapResponse& response) { return map.Apply(response); }));
  return map;
}

absl::Status StoreReader::ReadPresent(bool with_points, const TakeMapMessage& take) {
  return ReadWholeMap(*stub_, mission_, with_points, take);
}

absl::Status StoreReader::ReadPast(uint32_t max_moments, bool with_points,
                                   const TakeMapMessage& take) {
  v1::ReplayMapRequest request;
  request.set_mission(MissionName(mission_));
  request.set_include_points(with_points);
  request.set_max_moments(max_moments);
  return ReadReplay(*stub_, request, take);
}

absl::Status StoreReader::ReplayMap(uint32_t max_moments, bool with_points,
                                    const OnMoment& on_moment) {
  ToldMap map;
  const auto take = [&](const v1::WatchMapResponse& response) -> absl::Status {
    RETURN_IF_ERROR(map.Apply(response));
    return response.continues() ? absl::OkStatus() : on_moment(map);
  };
  return ReadPast(max_moments, with_points, take);
}

absl::StatusOr<std::map<KeyframeId, int64_t>> StoreReader::ReadKeyframeTimes() {
  v1::ListKeyframesRequest request;
  request.set_parent(absl::StrCat(MissionName(mission_), "/localMaps/-"));
  request.set_page_size(kKeyframesAPage);
  std::map<KeyframeId, int64_t> times_ns;
  do {
    grpc::ClientContext context;
    SetDeadline(context);
    v1::ListKeyframesResponse response;
    RETURN_IF_ERROR(ToStatus(stub_->ListKeyframes(&context, request, &response), "ListKeyframes"));
    for (const v1::Keyframe& keyframe : response.keyframes()) {
      ASSIGN_OR_RETURN(const KeyframePath path, ParseKeyframeName(keyframe.name()));
      times_ns[path.keyframe] = keyframe.timestamp_ns();
    }
    request.set_page_token(response.next_page_token());
  } while (!request.page_token().empty());
  return times_ns;
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
