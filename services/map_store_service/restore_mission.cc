#include <glog/logging.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "services/convert/resource_names.h"
#include "services/convert/status.h"
#include "services/map_store_service/lookups_to_proto.h"
#include "services/map_store_service/map_store_service.h"
#include "services/map_store_service/streams/read_timer.h"
#include "services/observe/logging/log_fields.h"
#include "services/server/stream_task.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using map_store::MapStore;
using map_store::MissionInfo;
using map_store::MissionRestorer;

namespace {

enum class RestoreJob { kNone, kTake, kRestore, kFinish };

// Reads the next piece once the one before was taken. Owns itself.
class RestoreReactor : public grpc::ServerReadReactor<v1::RestoreMissionRequest>,
                       private StreamTask<RestoreJob> {
 public:
  using Enter = std::function<absl::StatusOr<std::shared_ptr<const void>>(const std::string& name)>;

  RestoreReactor(MapStore& store, TaskPool& pool, StreamLimits& limits, absl::string_view peer,
                 MayAsk may_restore, Enter enter, v1::Mission* response)
      : StreamTask(pool, Threads::kLookUps),
        store_(store),
        limits_(limits.options()),
        ticket_(limits.Enter(peer)),
        may_restore_(std::move(may_restore)),
        enter_(std::move(enter)),
        response_(*response),
        restorer_(store.StartRestoring()) {
    if (!ticket_.ok()) {
      NeverWork();
      Finish(ToGrpcStatus(ticket_.status()));
      return;
    }
    timer_.Arm(limits_.open_timeout_s, "the first message");
    StartRead(&request_);
  }

  void OnReadDone(bool ok) override {
    Note([this, ok]()
             ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { (ok ? has_piece_ : read_to_end_) = true; });
  }
  void OnCancel() override { End(absl::CancelledError("the caller went away")); }
  void OnDone() override { delete this; }

 private:
  void End(const absl::Status& status) {
    Note([this, &status]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
      if (!end_) end_ = status;
    });
  }

  RestoreJob NextJob() const override ABSL_SHARED_LOCKS_REQUIRED(mutex_) {
    if (end_) return RestoreJob::kFinish;
    if (has_piece_) return RestoreJob::kTake;
    return read_to_end_ ? RestoreJob::kRestore : RestoreJob::kNone;
  }

  void DoJob(RestoreJob job) override {
    if (job == RestoreJob::kTake) TakePiece();
    if (job == RestoreJob::kRestore) {
      timer_.Disarm();
      const absl::Status restored = Restore();
      absl::MutexLock lock(&mutex_);
      if (!end_) end_ = restored;
    }
    // The reactor may be gone once this returns.
    if (job == RestoreJob::kFinish) Leave();
  }

  void Leave() {
    absl::Status end;
    {
      absl::MutexLock lock(&mutex_);
      end = *end_;
    }
    if (ticket_.ok()) ticket_->reset();
    work_.reset();
    Finish(ToGrpcStatus(end));
  }

  void TakePiece() {
    const absl::Status status = Take();
    {
      absl::MutexLock lock(&mutex_);
      has_piece_ = false;
      if (!status.ok() && !end_) end_ = status;
      if (end_) return;
    }
    timer_.Arm(limits_.part_timeout_s, "the next piece");
    StartRead(&request_);
  }

  absl::Status Take() {
    if (mission_.empty()) {
      ASSIGN_OR_RETURN(const std::string mission, ParseMissionName(request_.name()));
      RETURN_IF_ERROR(may_restore_(request_));
      ASSIGN_OR_RETURN(work_, enter_(request_.name()));
      mission_ = mission;
    }
    return restorer_.Add(request_.piece());
  }

  absl::Status Restore() {
    if (mission_.empty()) return absl::InvalidArgumentError("no message came");
    ASSIGN_OR_RETURN(map_store::MissionState state, restorer_.Finish());
    RETURN_IF_ERROR(store_.RestoreMission(mission_, std::move(state)));
    LOG(INFO) << LogFields{.mission = mission_} << "mission restored";
    ASSIGN_OR_RETURN(const MissionInfo info, store_.GetMission(mission_));
    ToProto(info, &response_);
    return absl::OkStatus();
  }

  MapStore& store_;
  const StreamLimitOptions& limits_;
  // An error if there were too many streams before this one.
  absl::StatusOr<std::unique_ptr<StreamLimits::Ticket>> ticket_;
  const MayAsk may_restore_;
  const Enter enter_;
  v1::Mission& response_;
  // Only gRPC uses it between StartRead and OnReadDone, and only DoJob otherwise.
  v1::RestoreMissionRequest request_;
  // Only DoJob uses these.
  std::string mission_;
  std::shared_ptr<const void> work_;
  MissionRestorer restorer_;

  bool has_piece_ ABSL_GUARDED_BY(mutex_) = false;
  bool read_to_end_ ABSL_GUARDED_BY(mutex_) = false;
  std::optional<absl::Status> end_ ABSL_GUARDED_BY(mutex_);

  // Declared last, so that it ends while the rest is there.
  ReadTimer timer_{[this](const absl::Status& overdue) {
    Note([this, &overdue]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
      // Otherwise the piece came in time, and waits for a thread.
      if (!has_piece_ && !read_to_end_ && !end_) end_ = overdue;
    });
  }};
};

}  // namespace

grpc::ServerReadReactor<v1::RestoreMissionRequest>* MapStoreService::RestoreMission(
    grpc::CallbackServerContext* context, MayAsk may_restore, v1::Mission* response) {
  const auto enter = [this, context](const std::string& name) {
    return EnterLongWork(*context, name);
  };
  return new RestoreReactor(store_, long_pool_, limits_, context->peer(), std::move(may_restore),
                            enter, response);
}

}  // namespace corbslam::services
