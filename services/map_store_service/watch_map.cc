#include <algorithm>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "services/convert/resource_names.h"
#include "services/convert/status.h"
#include "services/map_store_service/map_changes_to_proto.h"
#include "services/map_store_service/map_store_service.h"
#include "services/server/stream_task.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using map_store::MapChanges;
using map_store::MapStore;
using map_store::MapWatcher;

namespace {

// So many keyframes and points are read under one lock, which takes some two milliseconds.
constexpr size_t kItemsInAPiece = 5000;

enum class WatchJob { kNone, kWrite, kFinish, kLook };

// Sends what changed, once the part before was written. Owns itself.
class WatchMapReactor : public grpc::ServerWriteReactor<v1::WatchMapResponse>,
                        private StreamTask<WatchJob> {
 public:
  WatchMapReactor(MapStore& store, TaskPool& pool, const v1::WatchMapRequest& request,
                  absl::StatusOr<std::unique_ptr<StreamLimits::Ticket>> ticket)
      : StreamTask(pool, Threads::kLookUps),
        store_(store),
        name_(request.mission()),
        watcher_(request.from_version(), request.include_points()),
        ticket_(std::move(ticket)) {
    ListenForClose();
    if (!ticket_.ok()) {
      NeverWork();
      Finish(ToGrpcStatus(ticket_.status()));
      return;
    }
    Note([this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { changed_ = true; });
  }

  void OnWriteDone(bool ok) override {
    Note([this, ok]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
      writing_ = false;
      parts_.pop_front();
      cancelled_ |= !ok;
    });
  }
  void OnCancel() override {
    Note([this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { cancelled_ = true; });
  }
  void OnDone() override {
    link_.Cut();
    delete this;
  }

 private:
  void ListenForClose() {
    if (!ticket_.ok()) return;
    const absl::Status open = (*ticket_)->SetCloseListener(link_.Guard([this] { OnClose(); }));
    if (!open.ok()) ticket_ = open;
  }

  WatchJob NextJob() const override ABSL_SHARED_LOCKS_REQUIRED(mutex_) {
    if (writing_) return WatchJob::kNone;
    if (cancelled_ || end_) return WatchJob::kFinish;
    if (!parts_.empty()) return WatchJob::kWrite;
    return changed_ ? WatchJob::kLook : WatchJob::kNone;
  }

  void BeginJob(WatchJob job) override ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    if (job == WatchJob::kWrite) writing_ = true;
    if (job == WatchJob::kLook) changed_ = false;
  }

  void DoJob(WatchJob job) override {
    if (job == WatchJob::kWrite) WritePart();
    if (job == WatchJob::kLook) {
      const absl::Status status = Look();
      absl::MutexLock lock(&mutex_);
      if (!status.ok()) end_ = status;
    }
    // The reactor may be gone once this returns.
    if (job == WatchJob::kFinish) End();
  }

  void WritePart() {
    const v1::WatchMapResponse* part = nullptr;
    {
      absl::MutexLock lock(&mutex_);
      part = &parts_.front();
    }
    StartWrite(part);
  }

  absl::Status Look() {
    if (!token_) RETURN_IF_ERROR(Subscribe());
    ASSIGN_OR_RETURN(const std::optional<MapChanges> changes,
                     store_.NextChanges(mission_, kItemsInAPiece, watcher_));
    if (!changes) return absl::OkStatus();
    std::vector<v1::WatchMapResponse> parts = ToProto(*changes);
    absl::MutexLock lock(&mutex_);
    // The rest of the changes is looked at once these are written.
    changed_ = changed_ || changes->continues;
    for (v1::WatchMapResponse& part : parts) parts_.push_back(std::move(part));
    return absl::OkStatus();
  }

  absl::Status Subscribe() {
    ASSIGN_OR_RETURN(mission_, ParseMissionName(name_));
    ASSIGN_OR_RETURN(token_, store_.AddMapListener(mission_, link_.Guard([this] { OnChange(); })));
    return absl::OkStatus();
  }

  void OnClose() {
    Note([this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
      end_ = absl::UnavailableError("the map store is stopping");
    });
  }

  void OnChange() {
    Note([this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { changed_ = true; });
  }

  void End() {
    if (token_) store_.RemoveMapListener(mission_, *token_);
    absl::Status status;
    {
      absl::MutexLock lock(&mutex_);
      status = end_.value_or(absl::CancelledError("the caller went away"));
    }
    // The ticket is given back before the caller hears of the end: it may come again at once.
    ticket_->reset();
    Finish(ToGrpcStatus(status));
  }

  MapStore& store_;
  const std::string name_;
  // Only DoJob uses these three.
  MapWatcher watcher_;
  std::string mission_;
  std::optional<uint64_t> token_;
  // An error if there were too many streams before this one.
  absl::StatusOr<std::unique_ptr<StreamLimits::Ticket>> ticket_;

  bool changed_ ABSL_GUARDED_BY(mutex_) = false;
  bool writing_ ABSL_GUARDED_BY(mutex_) = false;
  bool cancelled_ ABSL_GUARDED_BY(mutex_) = false;
  std::optional<absl::Status> end_ ABSL_GUARDED_BY(mutex_);
  std::deque<v1::WatchMapResponse> parts_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace

grpc::ServerWriteReactor<v1::WatchMapResponse>* MapStoreService::WatchMap(
    grpc::CallbackServerContext* context, const v1::WatchMapRequest* request) {
  return new WatchMapReactor(store_, pool_, *request, limits_.Enter(context->peer()));
}

}  // namespace corbslam::services
