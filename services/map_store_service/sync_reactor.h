// Handles one agent's stream at the map store.
#ifndef CORBSLAM_SERVICES_MAP_STORE_SERVICE_SYNC_REACTOR_H_
#define CORBSLAM_SERVICES_MAP_STORE_SERVICE_SYNC_REACTOR_H_

#include <grpcpp/support/byte_buffer.h>

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"
#include "corbslam/v1/map_store_service.grpc.pb.h"
#include "map_store/store/map_store.h"
#include "services/convert/features.h"
#include "services/convert/map_update.h"
#include "services/map_store_service/map_store_service.h"
#include "services/map_store_service/streams/read_timer.h"
#include "services/map_store_service/streams/share_pacer.h"
#include "services/map_store_service/streams/stream_limits.h"
#include "services/map_store_service/streams/sync_observer.h"
#include "services/map_store_service/streams/wake_timer.h"
#include "services/server/stream_task.h"
#include "services/server/task_pool.h"

namespace corbslam::services {

enum class SyncJob { kNone, kWrite, kFinish, kRequest, kRead, kShare };

// Reads the next message when the one before was applied and the agent may send more, and asks for
// the next shared update when the one before was written and the budget of the agent's link has
// paid for it. Owns itself.
class SyncReactor : public grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>,
                    private StreamTask<SyncJob> {
 public:
  // Who opened the stream.
  struct Caller {
    std::string peer;  // As gRPC spells it.
    std::string name;  // Empty if nobody knows.
    MayAsk may_open;   // Of the message that opens the session.
    StayCheck may_stay;
    std::function<bool()> is_cancelled;
  };
  SyncReactor(map_store::MapStore& store, TaskPool& pool, StreamLimits& limits,
              const MapStoreServiceOptions& options, Caller caller);

  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

 private:
  void OnShareable();
  void OnOverdue(const absl::Status& overdue);
  // Refuses the stream; called in the constructor, as nothing has begun.
  void Refuse(const absl::Status& status);
  SyncJob NextJob() const override ABSL_SHARED_LOCKS_REQUIRED(mutex_);
  void BeginJob(SyncJob job) override ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void DoJob(SyncJob job) override;

  void WriteReply();
  void HandleRequest();
  // Reads the next message; where the limit of the agent's uplink is spent, a timer wakes the
  // stream when it is not any more, or to look again.
  void Read();
  void OnUplinkPaid();
  // Has the request handled again once its mission is awake; returns the error if it never will be.
  absl::Status WaitUntilAwake(const absl::Status& error);
  absl::Status ReadRequest(v1::SyncRequest& request);
  absl::Status Handle(const v1::SyncRequest& request);
  absl::Status Open(const v1::SyncRequest& message);
  absl::Status Apply(const v1::MapUpdateBatch& part);
  absl::Status NoteLocalised(const v1::LocalisedFrames& localised);
  absl::Status NoteReport(const v1::AgentReport& report);
  absl::StatusOr<Acknowledgement> ApplyComplete(const MapUpdateBatch& batch);
  void Share();
  // Returns false if the link's budget is spent; a timer then wakes the stream when it is not any
  // more.
  bool MayShare();
  void OnBudget();
  void SendSettings();
  void SendShared(const SharedUpdate& update);
  void Reply(const v1::SyncResponse& response);
  // Leaves the store and says how the stream ends.
  absl::Status Leave();
  void End(const absl::Status& status);

  map_store::MapStore& store_;
  const size_t shared_bytes_;
  const std::vector<SyncObserver*>& observers_;
  const Caller caller_;
  const std::string peer_;  // Readable.

  const StreamLimitOptions& limits_;
  // Null if there were too many streams before this one.
  std::unique_ptr<StreamLimits::Ticket> ticket_;

  // Only gRPC uses it between StartRead and OnReadDone, and only DoJob otherwise.
  grpc::ByteBuffer request_;
  // Only DoJob uses these.
  std::optional<v1::SyncRequest> asked_;  // The request, once it was read.
  size_t asked_bytes_ = 0;
  std::optional<uint64_t> session_id_;
  SessionAgent who_;                        // Set once the session is open.
  FeatureForm form_ = FeatureForm::kPlain;  // Form of the features that are sent.
  CameraBook received_cameras_;
  CameraBook sent_cameras_;
  BatchAssembler assembler_;
  map_store::BatchTransfer transfer_;
  std::string awaited_;  // The next part of an unfinished batch; empty: none is awaited.
  SharePacer pacer_;
  // The settings that the agent was told; nullopt: it doesn't understand any.
  std::optional<map_store::SettingsVersions> told_settings_;
  // True: what the agent itself says, too, changes what it is to be told.
  bool moves_what_is_shared_ = false;

  bool has_request_ ABSL_GUARDED_BY(mutex_) = false;
  // The next message is to be read, but, if the second is true, not before a timer has rung.
  bool wants_read_ ABSL_GUARDED_BY(mutex_) = false;
  bool is_held_ ABSL_GUARDED_BY(mutex_) = false;
  // True: the request waits for its mission, which is held once it is awake.
  bool waits_for_mission_ ABSL_GUARDED_BY(mutex_) = false;
  std::shared_ptr<const void> mission_ ABSL_GUARDED_BY(mutex_);
  absl::Time read_at_ ABSL_GUARDED_BY(mutex_);
  bool shareable_ ABSL_GUARDED_BY(mutex_) = false;
  // True: no shared update is sent until the timer rings.
  bool paced_ ABSL_GUARDED_BY(mutex_) = false;
  bool read_to_end_ ABSL_GUARDED_BY(mutex_) = false;
  bool cancelled_ ABSL_GUARDED_BY(mutex_) = false;
  bool writing_ ABSL_GUARDED_BY(mutex_) = false;
  std::optional<absl::Status> end_ ABSL_GUARDED_BY(mutex_);
  std::deque<grpc::ByteBuffer> replies_ ABSL_GUARDED_BY(mutex_);

  // Declared last, so that they end while the rest is there.
  WakeTimer budget_timer_;
  WakeTimer uplink_timer_;
  ReadTimer timer_{[this](const absl::Status& overdue) { OnOverdue(overdue); }};
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_MAP_STORE_SERVICE_SYNC_REACTOR_H_
