#include "services/remote/remote_uplink.h"

#include <memory>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "services/remote/sync_session.h"

namespace corbslam {
namespace {

// Outlives the uplink where a session's last reaction is still running.
struct Sessions {
  absl::Mutex mutex;
  std::shared_ptr<SyncSession> current ABSL_GUARDED_BY(mutex);
  // Started and not done, the current one included.
  int live ABSL_GUARDED_BY(mutex) = 0;

  bool HaveEnded() const ABSL_SHARED_LOCKS_REQUIRED(mutex) { return live == 0; }
  void OnDone(const SyncSession* session) {
    absl::MutexLock lock(&mutex);
    if (current.get() == session) current = nullptr;
    --live;
  }
};

class RemoteUplink : public Uplink {
 public:
  RemoteUplink(const std::shared_ptr<grpc::Channel>& channel, const RemoteUplinkOptions& options)
      : options_(options),
        transport_(std::make_shared<SyncTransport>()),
        sessions_(std::make_shared<Sessions>()) {
    transport_->stub = v1::MapStore::NewStub(channel);
  }
  ~RemoteUplink() override { Close(); }

  void Open(const SessionRequest& request, UplinkListener* listener) override {
    auto session = std::make_shared<SyncSession>(
        transport_, request, listener, options_.max_queued_bytes,
        [sessions = sessions_](const SyncSession* done) { sessions->OnDone(done); });
    const std::shared_ptr<SyncSession> previous = Replace(session);
    if (previous != nullptr) previous->Cancel();
    session->Start(session);
  }

  bool Send(const MapUpdateBatch& batch) override {
    std::shared_ptr<SyncSession> session;
    {
      absl::MutexLock lock(&sessions_->mutex);
      session = sessions_->current;
    }
    return session != nullptr && session->Send(batch);
  }

  void Close() override {
    std::shared_ptr<SyncSession> session = Replace(nullptr);
    if (session != nullptr) session->Cancel();
    session.reset();
    absl::MutexLock lock(&sessions_->mutex);
    sessions_->mutex.Await(absl::Condition(sessions_.get(), &Sessions::HaveEnded));
  }

  uint64_t bytes_up() const override { return transport_->bytes_up; }
  uint64_t bytes_down() const override { return transport_->bytes_down; }

 private:
  // Returns the one before.
  std::shared_ptr<SyncSession> Replace(std::shared_ptr<SyncSession> session) {
    absl::MutexLock lock(&sessions_->mutex);
    if (session != nullptr) ++sessions_->live;
    return std::exchange(sessions_->current, std::move(session));
  }

  const RemoteUplinkOptions options_;
  const std::shared_ptr<SyncTransport> transport_;
  const std::shared_ptr<Sessions> sessions_;
};

}  // namespace

std::unique_ptr<Uplink> MakeRemoteUplink(std::shared_ptr<grpc::Channel> channel,
                                         const RemoteUplinkOptions& options) {
  return std::make_unique<RemoteUplink>(channel, options);
}

}  // namespace corbslam
