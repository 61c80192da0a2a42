#include "services/tool/mission/mission_admin.h"

#include <fstream>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "services/client/store/call_status.h"
#include "services/convert/resource_names.h"
#include "slam/util/atomic_file.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

constexpr size_t kPieceBytes = 1 << 20;
constexpr int kAttempts = 5;
constexpr absl::Duration kSleepTimeout = absl::Minutes(10);

}  // namespace

MissionAdmin::MissionAdmin(const std::shared_ptr<grpc::Channel>& channel)
    : stub_(v1::MapStore::NewStub(channel)) {}

absl::StatusOr<std::vector<v1::Mission>> MissionAdmin::List() {
  std::vector<v1::Mission> missions;
  v1::ListMissionsRequest request;
  do {
    grpc::ClientContext context;
    SetDeadline(context);
    v1::ListMissionsResponse response;
    RETURN_IF_ERROR(ToStatus(stub_->ListMissions(&context, request, &response), "ListMissions"));
    missions.insert(missions.end(), response.missions().begin(), response.missions().end());
    request.set_page_token(response.next_page_token());
  } while (!request.page_token().empty());
  return missions;
}

absl::StatusOr<v1::Mission> MissionAdmin::Get(const std::string& mission) {
  grpc::ClientContext context;
  SetDeadline(context);
  v1::GetMissionRequest request;
  request.set_name(MissionName(mission));
  v1::Mission found;
  RETURN_IF_ERROR(ToStatus(stub_->GetMission(&context, request, &found), "GetMission"));
  return found;
}

absl::StatusOr<v1::Mission> MissionAdmin::Create(const v1::Mission& mission) {
  grpc::ClientContext context;
  SetDeadline(context);
  v1::CreateMissionRequest request;
  *request.mutable_mission() = mission;
  v1::Mission made;
  RETURN_IF_ERROR(ToStatus(stub_->CreateMission(&context, request, &made), "CreateMission"));
  return made;
}

absl::StatusOr<v1::Mission> MissionAdmin::Update(const v1::UpdateMissionRequest& request) {
  grpc::ClientContext context;
  SetDeadline(context);
  v1::Mission changed;
  RETURN_IF_ERROR(ToStatus(stub_->UpdateMission(&context, request, &changed), "UpdateMission"));
  return changed;
}

absl::StatusOr<v1::Mission> MissionAdmin::Change(
    const std::string& mission,
    const std::function<absl::StatusOr<v1::UpdateMissionRequest>(const v1::Mission& now)>& change) {
  for (int attempt = 1;; ++attempt) {
    ASSIGN_OR_RETURN(const v1::Mission now, Get(mission));
    ASSIGN_OR_RETURN(v1::UpdateMissionRequest request, change(now));
    request.set_expected_revision(now.settings_revision());
    absl::StatusOr<v1::Mission> changed = Update(request);
    if (!absl::IsAborted(changed.status()) || attempt == kAttempts) return changed;
  }
}

absl::StatusOr<v1::RobotSettingsList> MissionAdmin::GetSettings(const std::string& name) {
  grpc::ClientContext context;
  SetDeadline(context);
  v1::GetRobotSettingsRequest request;
  request.set_name(name);
  v1::RobotSettingsList found;
  RETURN_IF_ERROR(ToStatus(stub_->GetRobotSettings(&context, request, &found), "GetRobotSettings"));
  return found;
}

absl::StatusOr<v1::RobotSettingsList> MissionAdmin::SetSettings(
    const std::string& name, const v1::SignedRobotSettings& settings) {
  grpc::ClientContext context;
  SetDeadline(context);
  v1::SetRobotSettingsRequest request;
  request.set_name(name);
  *request.mutable_settings() = settings;
  v1::RobotSettingsList set;
  RETURN_IF_ERROR(ToStatus(stub_->SetRobotSettings(&context, request, &set), "SetRobotSettings"));
  return set;
}

absl::Status MissionAdmin::ReadBackup(
    const std::string& mission, const std::function<absl::Status(const std::string& piece)>& sink) {
  grpc::ClientContext context;
  v1::BackupMissionRequest request;
  request.set_name(MissionName(mission));
  const auto reader = stub_->BackupMission(&context, request);
  absl::Status taken;
  v1::BackupMissionResponse response;
  while (taken.ok() && reader->Read(&response)) taken = sink(response.piece());
  if (!taken.ok()) context.TryCancel();
  const grpc::Status status = reader->Finish();
  RETURN_IF_ERROR(taken);
  return ToStatus(status, "BackupMission");
}

absl::StatusOr<uint64_t> MissionAdmin::BackUp(const std::string& mission, const std::string& path,
                                              const Progress& on_progress) {
  ASSIGN_OR_RETURN(AtomicFile file, AtomicFile::Create(path));
  uint64_t bytes = 0;
  RETURN_IF_ERROR(ReadBackup(mission, [&](const std::string& piece) {
    bytes += piece.size();
    if (on_progress != nullptr) on_progress(bytes);
    return file.Append(piece);
  }));
  RETURN_IF_ERROR(file.Finish());
  return bytes;
}

absl::StatusOr<v1::Mission> MissionAdmin::Restore(const std::string& path,
                                                  const std::string& mission,
                                                  const Progress& on_progress) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return absl::NotFoundError(absl::StrCat("can't read ", path));
  grpc::ClientContext context;
  v1::Mission restored;
  const auto writer = stub_->RestoreMission(&context, &restored);
  v1::RestoreMissionRequest request;
  request.set_name(MissionName(mission));
  uint64_t bytes = 0;
  bool goes_on = true;
  while (goes_on) {
    std::string piece(kPieceBytes, '\0');
    file.read(piece.data(), static_cast<std::streamsize>(piece.size()));
    piece.resize(static_cast<size_t>(file.gcount()));
    if (piece.empty() && bytes > 0) break;
    bytes += piece.size();
    goes_on = !piece.empty();
    *request.mutable_piece() = std::move(piece);
    // Write returns false if the store has ended the call; Finish says why.
    goes_on = writer->Write(request) && goes_on;
    if (on_progress != nullptr) on_progress(bytes);
  }
  if (file.bad()) {
    context.TryCancel();
    writer->Finish();
    return absl::UnavailableError(absl::StrCat("can't read ", path));
  }
  writer->WritesDone();
  RETURN_IF_ERROR(ToStatus(writer->Finish(), absl::StrCat("RestoreMission from ", path)));
  return restored;
}

absl::StatusOr<v1::Mission> MissionAdmin::Sleep(const std::string& mission) {
  grpc::ClientContext context;
  // It may have a snapshot to write first.
  context.set_deadline(absl::ToChronoTime(absl::Now() + kSleepTimeout));
  v1::SleepMissionRequest request;
  request.set_name(MissionName(mission));
  v1::Mission asleep;
  RETURN_IF_ERROR(ToStatus(stub_->SleepMission(&context, request, &asleep), "SleepMission"));
  return asleep;
}

absl::StatusOr<v1::ForgetLocalMapsResponse> MissionAdmin::Forget(
    const v1::ForgetLocalMapsRequest& request) {
  grpc::ClientContext context;
  // A snapshot of what is left is written, too.
  context.set_deadline(absl::ToChronoTime(absl::Now() + kSleepTimeout));
  v1::ForgetLocalMapsResponse forgotten;
  RETURN_IF_ERROR(
      ToStatus(stub_->ForgetLocalMaps(&context, request, &forgotten), "ForgetLocalMaps"));
  return forgotten;
}

absl::StatusOr<uint32_t> MissionAdmin::Delete(const std::string& mission) {
  grpc::ClientContext context;
  SetDeadline(context);
  v1::DeleteMissionRequest request;
  request.set_name(MissionName(mission));
  v1::DeleteMissionResponse response;
  RETURN_IF_ERROR(ToStatus(stub_->DeleteMission(&context, request, &response), "DeleteMission"));
  return response.local_maps();
}

}  // namespace corbslam::services
