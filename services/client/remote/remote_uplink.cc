#include "services/client/remote/remote_uplink.h"

#include <memory>
#include <random>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "services/client/remote/sync_session.h"

namespace corbslam::services {
namespace {

constexpr absl::Duration kGoodbye = absl::Seconds(1);

// Sessions of one uplink. They outlive it if a session's last reaction is still running.
struct Sessions {
  absl::Mutex mutex;
  std::shared_ptr<SyncSession> current ABSL_GUARDED_BY(mutex);
  // Number of sessions that started and are not done, the current one included.
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
  RemoteUplink(std::shared_ptr<StoreRoute> route, const RemoteUplinkOptions& options)
      : options_(options),
        route_(std::move(route)),
        transport_(std::make_shared<SyncTransport>()),
        sessions_(std::make_shared<Sessions>()) {
    transport_->on_settings = options.on_settings;
  }
  ~RemoteUplink() override { Close(); }

  void Open(const SessionRequest& request, UplinkListener* listener) override {
    SessionRequest own = request;
    own.instance = options_.instance;
    own.take_over = options_.take_over && !transport_->was_granted;
    const std::shared_ptr<SyncSession> session = MakeSession({own, listener, 0});
    const std::shared_ptr<SyncSession> previous = Replace(session);
    if (previous != nullptr) previous->Cancel();
    session->Start(session);
  }

  bool Send(const MapUpdateBatch& batch) override {
    const std::shared_ptr<SyncSession> session = Current();
    return session != nullptr && session->Send(batch);
  }

  bool SendLocalised(const LocalisedFrames& localised) override {
    const std::shared_ptr<SyncSession> session = Current();
    return session != nullptr && session->SendLocalised(localised);
  }

  bool SendPicture(const KeyframePicture& picture) override {
    const std::shared_ptr<SyncSession> session = Current();
    return session != nullptr && session->SendPicture(picture);
  }

  bool SendReport(const AgentReport& report) override {
    const std::shared_ptr<SyncSession> session = Current();
    return session != nullptr && session->SendReport(report);
  }

  void PauseReading() override {
    if (const std::shared_ptr<SyncSession> session = Current()) session->PauseReading();
  }
  void ResumeReading() override {
    if (const std::shared_ptr<SyncSession> session = Current()) session->ResumeReading();
  }

  void Close() override {
    const std::shared_ptr<SyncSession> session = Replace(nullptr);
    if (session != nullptr && !(session->Leave() && HaveEndedWithin(kGoodbye))) session->Cancel();
    HaveEndedWithin(absl::InfiniteDuration());
  }

  uint64_t bytes_up() const override { return transport_->bytes_up; }
  uint64_t bytes_waiting() const override {
    const std::shared_ptr<SyncSession> session = Current();
    return session != nullptr ? session->bytes_waiting() : 0;
  }
  uint64_t bytes_down() const override { return transport_->bytes_down; }

 private:
  // One Open: a session after the other, as each store sends on to the next.
  struct Attempt {
    SessionRequest request;
    UplinkListener* listener = nullptr;
    int hops = 0;
  };

  std::shared_ptr<SyncSession> MakeSession(const Attempt& attempt) {
    const std::shared_ptr<grpc::Channel> asked = route_->channel();
    // This is called before the session is done, for which Close waits.
    const auto follow = [this, attempt, asked](const SyncSession* ended, absl::Status& reason) {
      Attempt next = attempt;
      const bool goes_on = route_->Follow(asked, reason, next.hops);
      return goes_on && !ended->was_granted() && GoOn(ended, next);
    };
    return std::make_shared<SyncSession>(
        transport_, v1::MapStore::NewStub(asked), attempt.request, attempt.listener,
        options_.max_queued_bytes, follow,
        [sessions = sessions_](const SyncSession* done) { sessions->OnDone(done); });
  }
  // Begins a session in the place of one that has ended; returns false if another one has it, or
  // none is wanted any more.
  bool GoOn(const SyncSession* ended, const Attempt& attempt) {
    const std::shared_ptr<SyncSession> session = MakeSession(attempt);
    {
      absl::MutexLock lock(&sessions_->mutex);
      if (sessions_->current.get() != ended) return false;
      sessions_->current = session;
      ++sessions_->live;
    }
    session->Start(session);
    return true;
  }

  std::shared_ptr<SyncSession> Current() const {
    absl::MutexLock lock(&sessions_->mutex);
    return sessions_->current;
  }
  // Makes `session` the current one and returns the one before.
  std::shared_ptr<SyncSession> Replace(std::shared_ptr<SyncSession> session) {
    absl::MutexLock lock(&sessions_->mutex);
    if (session != nullptr) ++sessions_->live;
    return std::exchange(sessions_->current, std::move(session));
  }

  bool HaveEndedWithin(absl::Duration patience) {
    absl::MutexLock lock(&sessions_->mutex);
    return sessions_->mutex.AwaitWithTimeout(absl::Condition(sessions_.get(), &Sessions::HaveEnded),
                                             patience);
  }

  const RemoteUplinkOptions options_;
  const std::shared_ptr<StoreRoute> route_;
  const std::shared_ptr<SyncTransport> transport_;
  const std::shared_ptr<Sessions> sessions_;
};

uint64_t DrawInstance() {
  std::random_device random;
  const uint64_t drawn = (uint64_t{random()} << 32) | random();
  return drawn == 0 ? 1 : drawn;
}

}  // namespace

uint64_t ProcessInstance() {
  static const uint64_t instance = DrawInstance();
  return instance;
}

std::unique_ptr<Uplink> MakeRemoteUplink(std::shared_ptr<StoreRoute> route,
                                         const RemoteUplinkOptions& options) {
  return std::make_unique<RemoteUplink>(std::move(route), options);
}

std::unique_ptr<Uplink> MakeRemoteUplink(std::shared_ptr<grpc::Channel> channel,
                                         const RemoteUplinkOptions& options) {
  return MakeRemoteUplink(std::make_shared<StoreRoute>(std::move(channel)), options);
}

}  // namespace corbslam::services
