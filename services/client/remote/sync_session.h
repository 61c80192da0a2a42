// Runs one session of an agent: one call of MapStore.Sync.
#ifndef CORBSLAM_SERVICES_CLIENT_REMOTE_SYNC_SESSION_H_
#define CORBSLAM_SERVICES_CLIENT_REMOTE_SYNC_SESSION_H_

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "corbslam/v1/map_store_service.grpc.pb.h"
#include "services/convert/features.h"
#include "services/convert/shared_update.h"
#include "slam/exchange/uplink.h"

namespace corbslam::services {

// Holds what the sessions of one uplink share.
struct SyncTransport {
  // Bytes on the wire, both ways.
  std::atomic<uint64_t> bytes_up{0};
  std::atomic<uint64_t> bytes_down{0};
  // RemoteUplinkOptions::on_settings.
  std::function<void(const v1::RobotSettingsList&)> on_settings;
  // True once the store has granted a session.
  std::atomic<bool> was_granted{false};
};

// One session. Thread-safe. Once started, it keeps itself alive until its call has ended.
class SyncSession : private grpc::ClientBidiReactor<v1::SyncRequest, v1::SyncResponse> {
 public:
  // Called with how a session has ended, before the listener is. True: another one takes its place,
  // and the listener hears nothing. It may change what the listener is told.
  using EndCallback = std::function<bool(const SyncSession* ended, absl::Status& reason)>;
  // Called after the last call of the listener.
  using DoneCallback = std::function<void(const SyncSession*)>;

  SyncSession(std::shared_ptr<SyncTransport> transport, std::unique_ptr<v1::MapStore::Stub> stub,
              const SessionRequest& request, UplinkListener* listener, size_t max_queued_bytes,
              EndCallback on_end, DoneCallback on_done);

  // Starts the call. `self` is this session.
  void Start(std::shared_ptr<SyncSession> self);
  // Returns whether the store has granted it.
  bool was_granted() const;
  // Does what Uplink::Send does.
  bool Send(const MapUpdateBatch& batch);
  // Does what Uplink::SendLocalised does.
  bool SendLocalised(const LocalisedFrames& localised);
  // Does what Uplink::SendPicture does.
  bool SendPicture(const KeyframePicture& picture);
  // Does what Uplink::SendReport does.
  bool SendReport(const AgentReport& report);
  // Returns what Uplink::bytes_waiting does; 0 once the call has broken.
  uint64_t bytes_waiting() const;
  // These do what those of Uplink do.
  void PauseReading();
  void ResumeReading();
  // Closes the sending side, so that the store ends the call in good order. The listener hears
  // nothing more, though a call of it may still run. What is unsent goes first if it is little.
  // Returns false if no session stands or more is unsent; then only Cancel ends the call.
  bool Leave();
  // Ends the call soon; the listener hears nothing more, as after Leave.
  void Cancel();

 private:
  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnWritesDoneDone(bool ok) override;
  void OnDone(const grpc::Status& status) override;

  absl::Status Handle(const v1::SyncResponse& response);
  absl::Status HandleShared(const v1::SharedUpdate& part);
  // Bytes of messages that are not on the wire yet.
  uint64_t UnsentBytes() const ABSL_SHARED_LOCKS_REQUIRED(mutex_);
  bool HasRoom() const ABSL_SHARED_LOCKS_REQUIRED(mutex_) {
    return granted_ && !broken_ && !leaving_ && !leaves_soon_ && queued_bytes_ <= max_queued_bytes_;
  }
  void Push(v1::SyncRequest request) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // Returns the message to write next; null if one is being written or there is none.
  const v1::SyncRequest* NextWrite() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void WriteNext();
  bool IsSilenced() const;
  // Returns true if the next message must not be read before ResumeReading.
  bool HoldsRead();
  // Returns true if the hold that keeps the call alive for Send must be given up now.
  bool TakeHold() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const std::shared_ptr<SyncTransport> transport_;
  const std::unique_ptr<v1::MapStore::Stub> stub_;
  UplinkListener* const listener_;
  const size_t max_queued_bytes_;
  EndCallback on_end_;
  DoneCallback on_done_;
  std::shared_ptr<SyncSession> self_;
  grpc::ClientContext context_;

  // The reading side uses these, one reaction at a time.
  v1::SyncResponse response_;
  CameraBook received_cameras_;
  SharedUpdateAssembler assembler_;
  absl::Status failure_;

  mutable absl::Mutex mutex_;
  std::deque<v1::SyncRequest> queue_ ABSL_GUARDED_BY(mutex_);
  size_t queued_bytes_ ABSL_GUARDED_BY(mutex_) = 0;
  CameraBook sent_cameras_ ABSL_GUARDED_BY(mutex_);
  FeatureForm form_ ABSL_GUARDED_BY(mutex_) = FeatureForm::kPlain;
  bool granted_ ABSL_GUARDED_BY(mutex_) = false;
  // True while a message is written, or the end of all messages.
  bool writing_ ABSL_GUARDED_BY(mutex_) = false;
  bool leaving_ ABSL_GUARDED_BY(mutex_) = false;  // True: no more writes begin.
  // True: no more messages are taken, and the sending side closes when all are written.
  bool leaves_soon_ ABSL_GUARDED_BY(mutex_) = false;
  bool broken_ ABSL_GUARDED_BY(mutex_) = false;  // True: no more reads or writes.
  bool held_ ABSL_GUARDED_BY(mutex_) = true;
  bool paused_ ABSL_GUARDED_BY(mutex_) = false;
  // True if a read waits for ResumeReading; a hold of its own keeps the call alive for it.
  bool read_waits_ ABSL_GUARDED_BY(mutex_) = false;
  bool silenced_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_CLIENT_REMOTE_SYNC_SESSION_H_
