#include "services/security/policy.h"

#include <algorithm>
#include <string>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "corbslam/v1/access.pb.h"
#include "services/convert/asked_resource.h"
#include "services/convert/resource_names.h"

namespace corbslam::services {

using google::protobuf::MethodDescriptor;

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

std::optional<Action> FromProto(v1::Access::Action action) {
  switch (action) {
    case v1::Access::LOOK:
      return Action::kLook;
    case v1::Access::LIST_MISSIONS:
      return Action::kListMissions;
    case v1::Access::UPLOAD:
      return Action::kUpload;
    case v1::Access::COMMAND:
      return Action::kCommand;
    case v1::Access::ADMINISTER:
      return Action::kAdminister;
    case v1::Access::COMPUTE:
      return Action::kCompute;
    default:
      return std::nullopt;
  }
}

}  // namespace

absl::Status Authorise(const Identity& identity, const Access& access) {
  const auto covers = [&access](const Grant& grant) { return Covers(grant, access); };
  if (std::ranges::any_of(identity.grants, covers)) return absl::OkStatus();
  return absl::PermissionDeniedError(
      absl::StrCat(Describe(identity), " may not ", DescribeAccess(access)));
}

std::optional<Action> ActionOf(const MethodDescriptor& method) {
  return FromProto(method.options().GetExtension(v1::access).action());
}

std::optional<Action> ActionOf(absl::string_view path) {
  if (const MethodDescriptor* method = FindMethod(path)) {
    if (const std::optional<Action> said = ActionOf(*method)) return said;
  }
  // gRPC's own protos don't say it.
  if (absl::StartsWith(path, "/grpc.health.v1.Health/")) return Action::kCheckHealth;
  if (absl::StartsWith(path, "/grpc.reflection.v1alpha.ServerReflection/")) {
    return Action::kReflect;
  }
  if (absl::StartsWith(path, "/grpc.channelz.v1.Channelz/")) return Action::kInspect;
  return std::nullopt;
}

}  // namespace corbslam::services
