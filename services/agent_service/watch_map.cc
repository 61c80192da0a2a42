#include <atomic>
#include <optional>

#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "services/agent_service/agent_service.h"
#include "services/agent_service/near_map_message.h"
#include "services/agent_service/pulled_stream.h"
#include "services/server/refusal.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using client_agent::NearMap;
using client_agent::NearMapLimits;

namespace {

constexpr uint32_t kMostPoints = 200'000;

// Looks at the map with the first frame after each interval.
class WatchMapReactor : public PulledStream<v1::WatchAgentMapResponse> {
 public:
  WatchMapReactor(TaskPool& pool, PoseBoard& board, const client_agent::Agent& agent,
                  const NearMapLimits& limits, absl::Duration interval)
      : PulledStream(pool), board_(board), agent_(agent), limits_(limits), interval_(interval) {
    token_ = board_.Add([this](const PostedPose&) { OnFrame(); }, [this] { End(); });
  }

 private:
  // The board calls it under its lock.
  void OnFrame() {
    const absl::Time now = absl::Now();
    // A clock that was set back must not stop the stream.
    if (now < due_ && due_ - now <= interval_) return;
    due_ = now + interval_;
    Want();
  }

  bool Make(v1::WatchAgentMapResponse& response) override {
    const std::optional<NearMap> near = agent_.GetNearMap(limits_);
    if (near.has_value()) ToProto(*near, &response);
    return near.has_value();
  }
  void Unsubscribe() override { board_.Remove(token_); }

  PoseBoard& board_;
  const client_agent::Agent& agent_;
  const NearMapLimits limits_;
  const absl::Duration interval_;
  absl::Time due_ = absl::InfinitePast();  // Only OnFrame uses it.
  std::atomic<uint64_t> token_ = 0;
};

// Returns the value, or `instead` for 0. The condition is written so that NaN is refused.
absl::StatusOr<double> InRange(absl::string_view field, double value, double least, double most,
                               double instead) {
  if (value == 0) return instead;
  if (value >= least && value <= most) return value;
  return absl::InvalidArgumentError(
      absl::StrCat(field, " is ", value, ", must be 0 or in [", least, ", ", most, "]"));
}

absl::StatusOr<NearMapLimits> ReadLimits(const v1::WatchAgentMapRequest& request) {
  NearMapLimits limits;
  ASSIGN_OR_RETURN(limits.radius_m,
                   InRange("radius_m", request.radius_m(), 1, 1000, limits.radius_m));
  if (request.max_points() > kMostPoints) {
    return absl::InvalidArgumentError(
        absl::StrCat("max_points is ", request.max_points(), ", must be at most ", kMostPoints));
  }
  if (request.max_points() != 0) limits.max_points = request.max_points();
  return limits;
}

}  // namespace

grpc::ServerWriteReactor<v1::WatchAgentMapResponse>* AgentService::WatchMap(
    grpc::CallbackServerContext*, const v1::WatchAgentMapRequest* request) {
  using Refused = RefusedStream<v1::WatchAgentMapResponse>;
  const auto limits = ReadLimits(*request);
  if (!limits.ok()) return new Refused(limits.status());
  const auto rate_hz = InRange("max_rate_hz", request->max_rate_hz(), 0.1, 10, 1);
  if (!rate_hz.ok()) return new Refused(rate_hz.status());
  return new WatchMapReactor(pool_, poses_, agent_, *limits, absl::Seconds(1) / *rate_hz);
}

}  // namespace corbslam::services
