// Streams messages that are made when they can be written, so that a slow reader costs one message.
#ifndef CORBSLAM_SERVICES_AGENT_SERVICE_PULLED_STREAM_H_
#define CORBSLAM_SERVICES_AGENT_SERVICE_PULLED_STREAM_H_

#include <grpcpp/support/server_callback.h>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "services/server/stream_task.h"
#include "services/server/task_pool.h"

namespace corbslam::services {

enum class PullJob { kNone, kPull, kFinish };

// Makes and writes a message whenever somebody called Want and the one before is written, until the
// caller goes or all was told. Owns itself.
template <typename Response>
class PulledStream : public grpc::ServerWriteReactor<Response>, private StreamTask<PullJob> {
 public:
  explicit PulledStream(TaskPool& pool) : StreamTask(pool, Threads::kLookUps) {}

  void OnWriteDone(bool ok) override {
    Note([this, ok]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
      busy_ = false;
      cancelled_ |= !ok;
    });
  }
  void OnCancel() override {
    Note([this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { cancelled_ = true; });
  }
  void OnDone() override {
    Unsubscribe();
    delete this;
  }

 protected:
  // Says that there may be a message to write. May be called from any thread, under its locks.
  void Want() {
    Note([this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { wanted_ = true; });
  }
  // Says that no message follows those that are wanted: the stream ends in good order. May be
  // called as Want.
  void End() {
    Note([this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { ended_ = true; });
  }
  // Makes the next message; returns false if there is none now. Called on the pool, without locks.
  virtual bool Make(Response& response) = 0;
  // Once it returns, nobody calls Want any more.
  virtual void Unsubscribe() = 0;

 private:
  PullJob NextJob() const override ABSL_SHARED_LOCKS_REQUIRED(mutex_) {
    if (busy_) return PullJob::kNone;
    if (cancelled_) return PullJob::kFinish;
    if (wanted_) return PullJob::kPull;
    return ended_ ? PullJob::kFinish : PullJob::kNone;
  }
  void BeginJob(PullJob job) override ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    if (job != PullJob::kPull) return;
    wanted_ = false;
    busy_ = true;
  }
  void DoJob(PullJob job) override {
    // The reactor may be gone once Finish is called.
    if (job == PullJob::kFinish) return this->Finish(How());
    written_.Clear();
    if (Make(written_)) return this->StartWrite(&written_);
    absl::MutexLock lock(&mutex_);
    busy_ = false;
  }

  grpc::Status How() const {
    absl::MutexLock lock(&mutex_);
    return cancelled_ ? grpc::Status::CANCELLED : grpc::Status::OK;
  }

  // gRPC reads this message while busy_ is set.
  Response written_;
  bool wanted_ ABSL_GUARDED_BY(mutex_) = false;
  bool busy_ ABSL_GUARDED_BY(mutex_) = false;
  bool cancelled_ ABSL_GUARDED_BY(mutex_) = false;
  bool ended_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_AGENT_SERVICE_PULLED_STREAM_H_
