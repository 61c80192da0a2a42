#include <atomic>
#include <cstdlib>
#include <optional>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/strings/str_cat.h"
#include "absl/synchronization/mutex.h"
#include "services/agent_service/agent_service.h"
#include "services/agent_service/pulled_stream.h"
#include "services/convert/geometry.h"

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
  WatchPoseReactor(PoseBoard& board, int64_t interval_ns, PosesOf poses_of,
                   const std::optional<Rigid3d>& camera_from_wanted)
      : board_(board),
        interval_ns_(interval_ns),
        poses_of_(poses_of),
        camera_from_wanted_(camera_from_wanted) {
    const uint64_t token = board_.Add([this](const PostedPose& pose) { OnPose(pose); });
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
    }
    Advance();
  }

  void Advance() {
    bool finish = false;
    {
      absl::MutexLock lock(&mutex_);
      if (writing_ || finished_ || (!cancelled_ && !next_)) return;
      finish = finished_ = cancelled_;
      if (!finish) {
        writing_ = true;
        written_ = *std::exchange(next_, std::nullopt);
        last_ns_ = written_.timestamp_ns();
      }
    }
    if (finish) return Finish(grpc::Status::CANCELLED);
    StartWrite(&written_);
  }

  PoseBoard& board_;
  const int64_t interval_ns_;
  const PosesOf poses_of_;
  const std::optional<Rigid3d> camera_from_wanted_;
  std::atomic<uint64_t> token_{0};
  // gRPC reads this message while writing_ is set.
  v1::WatchPoseResponse written_;

  absl::Mutex mutex_;
  std::optional<v1::WatchPoseResponse> next_ ABSL_GUARDED_BY(mutex_);
  std::optional<int64_t> last_ns_ ABSL_GUARDED_BY(mutex_);
  bool writing_ ABSL_GUARDED_BY(mutex_) = false;
  bool cancelled_ ABSL_GUARDED_BY(mutex_) = false;
  bool finished_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace

void AgentService::OnFrame(const TrackingResult& result, uint64_t dropped) {
  const uint64_t global_epoch = poses_.Post(result, agent_.GlobalFromLocal(), dropped);
  if (options_.events != nullptr) options_.events->NoteFrame(result, global_epoch);
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
  return new WatchPoseReactor(poses_, interval_ns, *poses_of, *camera_from_wanted);
}

}  // namespace corbslam::services
