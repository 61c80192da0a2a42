#include "services/security/policy.h"

#include <algorithm>
#include <map>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "services/convert/resource_names.h"

namespace corbslam::services {
namespace {

bool Allows(Role role, Action action) {
  const bool person_or_robot =
      role == Role::kAgent || role == Role::kViewer || role == Role::kOperator;
  switch (action) {
    case Action::kCheckHealth:
    case Action::kReflect:
      return true;
    case Action::kLook:
    case Action::kListMissions:
      return person_or_robot;
    case Action::kUpload:
      return role == Role::kAgent;
    case Action::kCommand:
      return role == Role::kAgent || role == Role::kOperator;
    case Action::kAdminister:
    case Action::kInspect:
      return role == Role::kOperator;
    case Action::kCompute:
      return role == Role::kStore;
  }
  return false;
}

bool Matches(const std::string& granted, const std::optional<std::string>& wanted) {
  return !wanted || granted == kAll || granted == *wanted;
}

bool Covers(const Grant& grant, const Access& access) {
  if (!Allows(grant.role, access.action)) return false;
  switch (access.action) {
    case Action::kCheckHealth:
    case Action::kReflect:
    case Action::kListMissions:
    case Action::kCompute:
      return true;
    case Action::kInspect:
      return grant.mission == kAll || (access.mission && grant.mission == *access.mission);
    case Action::kUpload:
      return Matches(grant.mission, access.mission) && Matches(grant.name, access.agent);
    case Action::kCommand:
      return Matches(grant.mission, access.mission) &&
             (grant.role == Role::kOperator || Matches(grant.name, access.agent));
    case Action::kLook:
    case Action::kAdminister:
      return Matches(grant.mission, access.mission);
  }
  return false;
}

std::string DescribeAccess(const Access& access) {
  const std::string mission = access.mission ? MissionName(*access.mission) : "any mission";
  switch (access.action) {
    case Action::kCheckHealth:
      return "check this server's health";
    case Action::kReflect:
      return "ask for this server's methods";
    case Action::kLook:
      return absl::StrCat("look into ", mission);
    case Action::kListMissions:
      return "list missions";
    case Action::kUpload:
      return absl::StrCat("upload to ", mission,
                          access.agent ? absl::StrCat(" as agent ", *access.agent) : "");
    case Action::kCommand:
      return absl::StrCat("give orders to ", access.agent ? *access.agent : "a robot", " of ",
                          mission);
    case Action::kAdminister:
      return absl::StrCat("administer ", mission);
    case Action::kInspect:
      return "inspect this server";
    case Action::kCompute:
      return "have a fusion worker compute";
  }
  return "do this";
}

const std::map<absl::string_view, Action>& OwnMethods() {
  static const auto& methods = *new std::map<absl::string_view, Action>{
      {"/corbslam.v1.MapStore/Sync", Action::kUpload},
      {"/corbslam.v1.MapStore/WatchMap", Action::kLook},
      {"/corbslam.v1.MapStore/WatchEvents", Action::kLook},
      {"/corbslam.v1.MapStore/ReplayMap", Action::kLook},
      {"/corbslam.v1.MapStore/ListMissions", Action::kListMissions},
      {"/corbslam.v1.MapStore/GetMission", Action::kLook},
      {"/corbslam.v1.MapStore/CreateMission", Action::kAdminister},
      {"/corbslam.v1.MapStore/UpdateMission", Action::kAdminister},
      {"/corbslam.v1.MapStore/SetRobotSettings", Action::kAdminister},
      {"/corbslam.v1.MapStore/GetRobotSettings", Action::kLook},
      {"/corbslam.v1.MapStore/DeleteMission", Action::kAdminister},
      {"/corbslam.v1.MapStore/SleepMission", Action::kAdminister},
      {"/corbslam.v1.MapStore/BackupMission", Action::kAdminister},
      {"/corbslam.v1.MapStore/RestoreMission", Action::kAdminister},
      {"/corbslam.v1.MapStore/StoreBackup", Action::kAdminister},
      {"/corbslam.v1.MapStore/ListStoredBackups", Action::kAdminister},
      {"/corbslam.v1.MapStore/RestoreStoredBackup", Action::kAdminister},
      {"/corbslam.v1.MapStore/VerifyStoredBackup", Action::kAdminister},
      {"/corbslam.v1.MapStore/DeleteStoredBackup", Action::kAdminister},
      {"/corbslam.v1.MapStore/ArchiveMission", Action::kAdminister},
      {"/corbslam.v1.MapStore/ListAgents", Action::kLook},
      {"/corbslam.v1.MapStore/ListLocalMaps", Action::kLook},
      {"/corbslam.v1.MapStore/GetLocalMap", Action::kLook},
      {"/corbslam.v1.MapStore/ListKeyframes", Action::kLook},
      {"/corbslam.v1.MapStore/GetKeyframe", Action::kLook},
      {"/corbslam.v1.MapStore/GetStatistics", Action::kLook},
      {"/corbslam.v1.MapStore/GetTrajectory", Action::kLook},
      {"/corbslam.v1.MapStore/ListOverlaps", Action::kLook},
      {"/corbslam.v1.MapStore/GetOverlap", Action::kLook},
      {"/corbslam.v1.MapStore/Localize", Action::kLook},
      {"/corbslam.v1.MapStore/LocalizeStream", Action::kLook},
      {"/corbslam.v1.MapStore/AskForExactPlaces", Action::kAdminister},
      {"/corbslam.v1.MapStore/RetractOverlap", Action::kAdminister},
      {"/corbslam.v1.MapStore/ForgetLocalMaps", Action::kAdminister},
      {"/corbslam.v1.MapStore/RederiveGlobalLayer", Action::kAdminister},
      {"/corbslam.v1.FusionWorker/VerifyOverlap", Action::kCompute},
      {"/corbslam.v1.FusionWorker/FuseMaps", Action::kCompute},
      {"/corbslam.v1.FusionWorker/AdjustBundle", Action::kCompute},
      {"/corbslam.v1.FusionWorker/LocateFrame", Action::kCompute},
      {"/corbslam.v1.FusionWorker/ExtractFeatures", Action::kCompute},
      {"/corbslam.v1.Agent/WatchPose", Action::kLook},
      {"/corbslam.v1.Agent/WatchEvents", Action::kLook},
      {"/corbslam.v1.Agent/WatchMap", Action::kLook},
      {"/corbslam.v1.Agent/GetStatus", Action::kLook},
      {"/corbslam.v1.Agent/GetTrajectory", Action::kLook},
      {"/corbslam.v1.Agent/PauseMapping", Action::kCommand},
      {"/corbslam.v1.Agent/ResumeMapping", Action::kCommand},
      {"/corbslam.v1.Agent/OpenNewMap", Action::kCommand},
      {"/corbslam.v1.Agent/SetMask", Action::kCommand}};
  return methods;
}

}  // namespace

absl::Status Authorise(const Identity& identity, const Access& access) {
  const auto covers = [&access](const Grant& grant) { return Covers(grant, access); };
  if (std::ranges::any_of(identity.grants, covers)) return absl::OkStatus();
  return absl::PermissionDeniedError(
      absl::StrCat(Describe(identity), " may not ", DescribeAccess(access)));
}

std::optional<Action> ActionOf(absl::string_view path) {
  if (const auto own = OwnMethods().find(path); own != OwnMethods().end()) return own->second;
  if (absl::StartsWith(path, "/grpc.health.v1.Health/")) return Action::kCheckHealth;
  if (absl::StartsWith(path, "/grpc.reflection.v1alpha.ServerReflection/")) {
    return Action::kReflect;
  }
  if (absl::StartsWith(path, "/grpc.channelz.v1.Channelz/")) return Action::kInspect;
  return std::nullopt;
}

}  // namespace corbslam::services
