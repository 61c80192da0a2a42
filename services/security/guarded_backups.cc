// Implements the part of GuardedMapStore that hands on calls about stored backups.
#include <grpcpp/support/server_callback.h>

#include "services/convert/resource_names.h"
#include "services/convert/status.h"
#include "services/security/guarded_map_store.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

grpc::ServerUnaryReactor* RefuseBackup(grpc::CallbackServerContext* context,
                                       const absl::Status& status) {
  grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
  reactor->Finish(ToGrpcStatus(status));
  return reactor;
}

}  // namespace

grpc::ServerUnaryReactor* GuardedMapStore::StoreBackup(grpc::CallbackServerContext* context,
                                                       const v1::StoreBackupRequest* request,
                                                       v1::StoredBackup* response) {
  const absl::Status status = Check(*context, Action::kAdminister, request->name());
  return status.ok() ? service_.StoreBackup(context, request, response)
                     : RefuseBackup(context, status);
}

// MakeListFilter leaves out what the caller of a list of all may not look into; that the caller
// administers something at all was checked with the call.
grpc::ServerUnaryReactor* GuardedMapStore::ListStoredBackups(
    grpc::CallbackServerContext* context, const v1::ListStoredBackupsRequest* request,
    v1::ListStoredBackupsResponse* response) {
  const absl::Status status = request->parent() == kAllMissions
                                  ? absl::OkStatus()
                                  : Check(*context, Action::kAdminister, request->parent());
  return status.ok() ? service_.ListStoredBackups(context, request, response)
                     : RefuseBackup(context, status);
}

grpc::ServerUnaryReactor* GuardedMapStore::RestoreStoredBackup(
    grpc::CallbackServerContext* context, const v1::RestoreStoredBackupRequest* request,
    v1::Mission* response) {
  // It reads the one mission and makes the other.
  absl::Status status = Check(*context, Action::kAdminister, request->backup());
  if (status.ok() && !request->name().empty()) {
    status = Check(*context, Action::kAdminister, request->name());
  }
  return status.ok() ? service_.RestoreStoredBackup(context, request, response)
                     : RefuseBackup(context, status);
}

grpc::ServerUnaryReactor* GuardedMapStore::VerifyStoredBackup(
    grpc::CallbackServerContext* context, const v1::VerifyStoredBackupRequest* request,
    v1::StoredBackup* response) {
  const absl::Status status = Check(*context, Action::kAdminister, request->backup());
  return status.ok() ? service_.VerifyStoredBackup(context, request, response)
                     : RefuseBackup(context, status);
}

grpc::ServerUnaryReactor* GuardedMapStore::DeleteStoredBackup(
    grpc::CallbackServerContext* context, const v1::DeleteStoredBackupRequest* request,
    v1::StoredBackup* response) {
  const absl::Status status = Check(*context, Action::kAdminister, request->backup());
  return status.ok() ? service_.DeleteStoredBackup(context, request, response)
                     : RefuseBackup(context, status);
}

grpc::ServerUnaryReactor* GuardedMapStore::ArchiveMission(grpc::CallbackServerContext* context,
                                                          const v1::ArchiveMissionRequest* request,
                                                          v1::StoredBackup* response) {
  const absl::Status status = Check(*context, Action::kAdminister, request->name());
  return status.ok() ? service_.ArchiveMission(context, request, response)
                     : RefuseBackup(context, status);
}

}  // namespace corbslam::services
