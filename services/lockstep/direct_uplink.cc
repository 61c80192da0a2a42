#include "services/lockstep/direct_uplink.h"

#include <utility>

namespace corbslam {
namespace {

constexpr size_t kSharedBudget_bytes = 1 << 20;

}  // namespace

void DirectUplink::Open(const SessionRequest& request, UplinkListener* listener) {
  listener_ = listener;
  absl::StatusOr<MapStore::OpenedSession> opened = store_->OpenSession(request);
  if (!opened.ok()) return End(opened.status());
  session_ = opened->session_id;
  listener_->OnSessionOpened(opened->grant);
}

bool DirectUplink::Send(const MapUpdateBatch& batch) {
  if (!session_.has_value()) return false;
  const absl::StatusOr<Acknowledgement> stored = store_->Apply(*session_, batch);
  if (!stored.ok()) {
    End(stored.status());
    return false;
  }
  listener_->OnAcknowledged(*stored);
  return true;
}

void DirectUplink::DeliverShared() {
  while (session_.has_value()) {
    absl::StatusOr<std::optional<SharedUpdate>> update =
        store_->NextShared(*session_, kSharedBudget_bytes);
    if (!update.ok()) return End(update.status());
    if (!update->has_value()) return;
    listener_->OnShared(std::move(**update));
  }
}

void DirectUplink::Close() {
  if (session_.has_value()) store_->CloseSession(*session_);
  session_.reset();
}

void DirectUplink::End(const absl::Status& reason) {
  Close();
  listener_->OnSessionClosed(reason);
}

}  // namespace corbslam
