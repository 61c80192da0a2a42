#include "services/observe/metrics/robot_metrics.h"

#include <string>

#include "absl/time/clock.h"
#include "services/observe/metrics/buckets.h"

namespace corbslam::services {

using client_agent::TrackingResult;
using client_agent::TrackingState;

namespace {

constexpr std::array<const char*, 3> kStates = {"not_initialised", "tracking", "lost"};
static_assert(static_cast<int>(TrackingState::kTracking) == 1);
static_assert(static_cast<int>(TrackingState::kLost) == 2);

prometheus::Counter& OneCounter(const std::string& name, const std::string& help,
                                prometheus::Registry& registry) {
  return prometheus::BuildCounter().Name(name).Help(help).Register(registry).Add({});
}

}  // namespace

RobotMetrics::RobotMetrics(prometheus::Registry& registry)
    : frame_durations_(prometheus::BuildHistogram()
                           .Name("corbslam_robot_frame_duration_seconds")
                           .Help("From a frame's pictures to its pose.")
                           .Register(registry)
                           .Add({}, FrameTimes_s())),
      keyframes_made_(OneCounter("corbslam_robot_keyframes_made_total",
                                 "Frames that became keyframes.", registry)),
      frames_dropped_(OneCounter("corbslam_robot_frames_dropped_total",
                                 "Frames that came before the one before was tracked.", registry)),
      attempts_(OneCounter("corbslam_robot_session_attempts_total",
                           "Sessions with the map store that were asked for.", registry)),
      reconnects_(OneCounter("corbslam_robot_reconnects_total",
                             "Sessions that stood after the first.", registry)),
      connected_(prometheus::BuildGauge()
                     .Name("corbslam_robot_connected")
                     .Help("Whether a session with the map store stands.")
                     .Register(registry)
                     .Add({})),
      acknowledgements_(prometheus::BuildHistogram()
                            .Name("corbslam_robot_acknowledgement_duration_seconds")
                            .Help("From a batch's sending to its acknowledgement, the link "
                                  "included.")
                            .Register(registry)
                            .Add({}, ShortTimes_s())) {
  auto& frames = prometheus::BuildCounter()
                     .Name("corbslam_robot_frames_total")
                     .Help("Frames, by how tracking ended.")
                     .Register(registry);
  auto& is_now = prometheus::BuildGauge()
                     .Name("corbslam_robot_tracking_state")
                     .Help("1 for the state that tracking is in, 0 for the others.")
                     .Register(registry);
  for (size_t i = 0; i < kStates.size(); ++i) {
    states_[i] = {&frames.Add({{"state", kStates[i]}}), &is_now.Add({{"state", kStates[i]}})};
  }
  states_[0].is_now->Set(1);
}

void RobotMetrics::OnTracked(const TrackingResult& result, absl::Duration took) {
  frame_durations_.Observe(absl::ToDoubleSeconds(took));
  if (result.made_keyframe) keyframes_made_.Increment();
  if (result.follows_keyframe) keyframes_made_.Increment();
  const auto now = static_cast<size_t>(result.state);
  states_[now].frames->Increment();
  for (size_t i = 0; i < states_.size(); ++i) states_[i].is_now->Set(i == now);
}

void RobotMetrics::SetDropped(uint64_t frames) {
  frames_dropped_.Increment(static_cast<double>(frames) - frames_dropped_.Value());
}

void RobotMetrics::OnOpening() {
  attempts_.Increment();
  // The agent may have closed the session before by itself.
  connected_.Set(0);
}

void RobotMetrics::OnOpened() {
  connected_.Set(1);
  absl::MutexLock lock(&mutex_);
  if (was_connected_) reconnects_.Increment();
  was_connected_ = true;
}

void RobotMetrics::OnClosed(const absl::Status&) { connected_.Set(0); }

void RobotMetrics::OnSent(const MapUpdateBatch& batch, absl::Time offered) {
  absl::MutexLock lock(&mutex_);
  ObserveAcknowledged(pending_.Sent(batch.local_map, batch.number, offered));
}

void RobotMetrics::OnAcknowledged(const Acknowledgement& acknowledgement) {
  absl::MutexLock lock(&mutex_);
  ObserveAcknowledged(pending_.Acknowledged(acknowledgement));
}

void RobotMetrics::ObserveAcknowledged(const std::vector<absl::Time>& sent) {
  const absl::Time now = absl::Now();
  for (const absl::Time& time : sent) acknowledgements_.Observe(absl::ToDoubleSeconds(now - time));
}

}  // namespace corbslam::services
