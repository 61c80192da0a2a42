#include <atomic>
#include <chrono>
#include <cstdlib>
#include <optional>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/strings/str_cat.h"
#include "absl/synchronization/mutex.h"
#include "services/agent_service/agent_service.h"
#include "services/agent_service/pulled_stream.h"
#include "services/convert/geometry.h"
#include "services/server/refusal.h"

namespace corbslam::services {

using client_agent::TrackingResult;

namespace {

constexpr double kMinRate_hz = 0.1;
constexpr double kMaxRate_hz = 1000;

// Writes the newest pose whenever the one before is written. Owns itself.
class WatchPoseReactor : public grpc::ServerWriteReactor<v1::WatchPoseResponse> {
 public:
  // Frames nearer in the agent's own time than `interval_ns` are left out. `camera_from_wanted`
  // turns the camera's poses into those of `poses_of`; nullopt: they are the same.
  WatchPoseReactor(PoseBoard& board, v1::AgentClock clock, int64_t interval_ns, PosesOf poses_of,
                   const std::optional<Rigid3d>& camera_from_wanted)
      : board_(board),
        clock_(clock),
        interval_ns_(interval_ns),
        poses_of_(poses_of),
        camera_from_wanted_(camera_from_wanted) {
    const uint64_t token =
        board_.Add([this](const PostedPose& pose) { OnPose(pose); }, [this] { OnEnd(); });
    token_.store(token);
  }

  void OnWriteDone(bool ok) override {
    {
      absl::MutexLock lock(&mutex_);
      writing_ = false;
      cancelled_ |= !ok;
    }
    Advance();
  }
  void OnCancel() override {
    {
      absl::MutexLock lock(&mutex_);
      cancelled_ = true;
    }
    Advance();
  }
  void OnDone() override {
    board_.Remove(token_);
    delete this;
  }

 private:
  void OnPose(const PostedPose& pose) {
    {
      absl::MutexLock lock(&mutex_);
      // The difference may be negative, as a sequence may be played backwards.
      const int64_t step_ns = std::abs(pose.result.timestamp_ns - last_ns_.value_or(0));
      if (last_ns_ && step_ns < interval_ns_) return;
      next_ = ToProto(pose, poses_of_, camera_from_wanted_);
      next_->set_clock(clock_);
      next_came_ = pose.came;
    }
    Advance();
  }
  void OnEnd() {
    {
      absl::MutexLock lock(&mutex_);
      ended_ = true;
    }
    Advance();
  }

  void Advance() {
    std::optional<grpc::Status> end;
    {
      absl::MutexLock lock(&mutex_);
      if (writing_ || finished_) return;
      if (cancelled_) {
        end = grpc::Status::CANCELLED;
      } else if (next_) {
        BeginWrite();
      } else if (ended_) {
        end = grpc::Status::OK;
      } else {
        return;
      }
      finished_ = end.has_value();
    }
    if (end.has_value()) return Finish(*end);
    StartWrite(&written_);
  }

  void BeginWrite() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    writing_ = true;
    written_ = *std::exchange(next_, std::nullopt);
    last_ns_ = written_.timestamp_ns();
    const std::chrono::duration<double> age = std::chrono::steady_clock::now() - next_came_;
    written_.set_age_s(age.count());
  }

  PoseBoard& board_;
  const v1::AgentClock clock_;
  const int64_t interval_ns_;
  const PosesOf poses_of_;
  const std::optional<Rigid3d> camera_from_wanted_;
  std::atomic<uint64_t> token_{0};
  // gRPC reads this message while writing_ is set.
  v1::WatchPoseResponse written_;

  absl::Mutex mutex_;
  std::optional<v1::WatchPoseResponse> next_ ABSL_GUARDED_BY(mutex_);
  PoseBoard::Moment next_came_ ABSL_GUARDED_BY(mutex_);
  std::optional<int64_t> last_ns_ ABSL_GUARDED_BY(mutex_);
  bool writing_ ABSL_GUARDED_BY(mutex_) = false;
  bool cancelled_ ABSL_GUARDED_BY(mutex_) = false;
  bool ended_ ABSL_GUARDED_BY(mutex_) = false;  // No pose follows.
  bool finished_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace

void AgentService::OnFrame(const TrackingResult& result, uint64_t dropped, PoseBoard::Moment came) {
  const uint64_t global_epoch = poses_.Post(result, came, dropped);
  if (options_.events != nullptr) options_.events->NoteFrame(result, global_epoch);
}

void AgentService::OnEnd() {
  if (options_.events != nullptr) options_.events->NoteEnd();
  poses_.End();
}

grpc::ServerWriteReactor<v1::WatchPoseResponse>* AgentService::WatchPose(
    grpc::CallbackServerContext*, const v1::WatchPoseRequest* request) {
  const double rate_hz = request->max_rate_hz();
  // The condition is written so that NaN is refused.
  if (rate_hz != 0 && !(rate_hz >= kMinRate_hz && rate_hz <= kMaxRate_hz)) {
    return new RefusedStream<v1::WatchPoseResponse>(absl::InvalidArgumentError(
        absl::StrCat("max_rate_hz is ", rate_hz, ", must be 0 or in [0.1, 1000]")));
  }
  const auto poses_of = FromProto(request->poses_of());
  if (!poses_of.ok()) return new RefusedStream<v1::WatchPoseResponse>(poses_of.status());
  const auto camera_from_wanted = CameraFromWanted(options_.recorded_camera, *poses_of);
  if (!camera_from_wanted.ok())
    return new RefusedStream<v1::WatchPoseResponse>(camera_from_wanted.status());
  const int64_t interval_ns = rate_hz == 0 ? 0 : static_cast<int64_t>(1e9 / rate_hz);
  return new WatchPoseReactor(poses_, options_.clock, interval_ns, *poses_of, *camera_from_wanted);
}

}  // namespace corbslam::services
