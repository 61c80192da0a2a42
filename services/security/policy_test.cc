#include "services/security/policy.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "corbslam/v1/access.pb.h"
#include "corbslam/v1/agent_service.pb.h"
#include "corbslam/v1/fusion_worker_service.pb.h"
#include "corbslam/v1/map_store_service.pb.h"

namespace corbslam::services {
namespace {

constexpr Action kAllActions[] = {Action::kCheckHealth,  Action::kReflect, Action::kLook,
                                  Action::kListMissions, Action::kUpload,  Action::kCommand,
                                  Action::kAdminister,   Action::kInspect, Action::kCompute};

Identity Be(const std::vector<std::string>& grants) {
  Identity identity;
  for (const std::string& text : grants) {
    const absl::StatusOr<Grant> grant = ParseGrant(text);
    EXPECT_TRUE(grant.ok()) << grant.status();
    if (grant.ok()) identity.grants.push_back(*grant);
  }
  return identity;
}

// Each row says who may do what of all that there is to do in mission lab, as agent alpha.
TEST(PolicyTest, EachRoleMayDoWhatItIsFor) {
  struct {
    std::string who;
    std::vector<Action> may;
  } const rows[] = {
      {"missions/lab/agents/alpha",
       {Action::kCheckHealth, Action::kReflect, Action::kListMissions, Action::kLook,
        Action::kUpload, Action::kCommand}},
      {"missions/lab/agents/-",
       {Action::kCheckHealth, Action::kReflect, Action::kListMissions, Action::kLook,
        Action::kUpload, Action::kCommand}},
      {"missions/lab/agents/bravo",
       {Action::kCheckHealth, Action::kReflect, Action::kListMissions, Action::kLook}},
      {"missions/lab/viewers/alpha",
       {Action::kCheckHealth, Action::kReflect, Action::kListMissions, Action::kLook}},
      {"missions/lab/operators/alpha",
       {Action::kCheckHealth, Action::kReflect, Action::kListMissions, Action::kLook,
        Action::kCommand, Action::kAdminister, Action::kInspect}},
      {"missions/-/viewers/alpha",
       {Action::kCheckHealth, Action::kReflect, Action::kListMissions, Action::kLook}},
      {"missions/-/operators/alpha",
       {Action::kCheckHealth, Action::kReflect, Action::kListMissions, Action::kLook,
        Action::kCommand, Action::kAdminister, Action::kInspect}},
      {"missions/field/agents/alpha",
       {Action::kCheckHealth, Action::kReflect, Action::kListMissions}},
      {"missions/field/viewers/alpha",
       {Action::kCheckHealth, Action::kReflect, Action::kListMissions}},
      {"missions/field/operators/alpha",
       {Action::kCheckHealth, Action::kReflect, Action::kListMissions}},
      {"stores/main", {Action::kCheckHealth, Action::kReflect, Action::kCompute}},
      {"workers/one", {Action::kCheckHealth, Action::kReflect}},
  };
  for (const auto& [who, may] : rows) {
    for (const Action action : kAllActions) {
      const absl::Status status = Authorise(Be({who}), {action, "lab", "alpha"});
      const bool expected = std::ranges::find(may, action) != may.end();
      EXPECT_EQ(status.code(),
                expected ? absl::StatusCode::kOk : absl::StatusCode::kPermissionDenied)
          << who << " " << static_cast<int>(action) << " " << status;
    }
  }
}

TEST(PolicyTest, AMissionThatIsNotNamedYetIsSomeMission) {
  EXPECT_TRUE(Authorise(Be({"missions/lab/agents/alpha"}), {Action::kUpload, {}, {}}).ok());
  EXPECT_FALSE(Authorise(Be({"missions/lab/viewers/v"}), {Action::kAdminister, {}, {}}).ok());
  EXPECT_FALSE(Authorise(Be({"missions/lab/viewers/v"}), {Action::kUpload, {}, {}}).ok());
  EXPECT_FALSE(Authorise(Identity(), {Action::kReflect, {}, {}}).ok());
}

TEST(PolicyTest, WhoInspectsAServerSeesTheCallersOfAllItsMissions) {
  EXPECT_FALSE(Authorise(Be({"missions/lab/operators/o"}), {Action::kInspect, {}, {}}).ok());
  EXPECT_TRUE(Authorise(Be({"missions/-/operators/o"}), {Action::kInspect, {}, {}}).ok());
}

TEST(PolicyTest, GrantsAddUpButDoNotMix) {
  const Identity both = Be({"missions/lab/agents/alpha", "missions/field/operators/alpha"});
  EXPECT_TRUE(Authorise(both, {Action::kUpload, "lab", "alpha"}).ok());
  EXPECT_TRUE(Authorise(both, {Action::kAdminister, "field", {}}).ok());
  EXPECT_FALSE(Authorise(both, {Action::kAdminister, "lab", {}}).ok());
  EXPECT_FALSE(Authorise(both, {Action::kUpload, "field", "alpha"}).ok());
}

TEST(PolicyTest, ARefusalSaysWhoWhatAndWhere) {
  const auto message = [](const Access& access) {
    return std::string(Authorise(Be({"missions/lab/viewers/eve"}), access).message());
  };
  EXPECT_EQ(message({Action::kUpload, "lab", "alpha"}),
            "missions/lab/viewers/eve may not upload to missions/lab as agent alpha");
  EXPECT_EQ(message({Action::kAdminister, "lab", {}}),
            "missions/lab/viewers/eve may not administer missions/lab");
  EXPECT_EQ(message({Action::kLook, "field", {}}),
            "missions/lab/viewers/eve may not look into missions/field");
}

// A method that is added to the contract has no rule yet: then this fails, and nobody may call it.
TEST(PolicyTest, EveryMethodOfTheContractHasARule) {
  for (const google::protobuf::FileDescriptor* file :
       {v1::SyncRequest::descriptor()->file(), v1::FuseMapsRequest::descriptor()->file(),
        v1::AgentStatus::descriptor()->file()}) {
    ASSERT_EQ(file->service_count(), 1) << file->name();
    const google::protobuf::ServiceDescriptor* service = file->service(0);
    for (int i = 0; i < service->method_count(); ++i) {
      const std::string path =
          absl::StrCat("/", service->full_name(), "/", service->method(i)->name());
      EXPECT_TRUE(ActionOf(path).has_value()) << path;
    }
  }
}

// Returns true if messages of this type have this text, such as "mission.name".
bool HasText(const google::protobuf::Descriptor* type, const std::string& path) {
  const google::protobuf::FieldDescriptor* field = nullptr;
  for (const absl::string_view name : absl::StrSplit(path, '.')) {
    field = type != nullptr ? type->FindFieldByName(std::string(name)) : nullptr;
    if (field == nullptr || field->is_repeated()) return false;
    type = field->message_type();
  }
  return field->type() == google::protobuf::FieldDescriptor::TYPE_STRING;
}

// A store has several missions, so that each of its calls says of which one it is.
TEST(PolicyTest, EveryCallOfAStoreNamesItsMission) {
  const google::protobuf::ServiceDescriptor* service =
      v1::SyncRequest::descriptor()->file()->service(0);
  for (int i = 0; i < service->method_count(); ++i) {
    const google::protobuf::MethodDescriptor& method = *service->method(i);
    const v1::Access& access = method.options().GetExtension(v1::access);
    EXPECT_EQ(access.mission_size() == 0, access.action() == v1::Access::LIST_MISSIONS)
        << method.name();
    EXPECT_EQ(access.agent().empty(), access.action() != v1::Access::UPLOAD) << method.name();
    for (const std::string& path : access.mission()) {
      EXPECT_TRUE(HasText(method.input_type(), path)) << method.name() << " " << path;
    }
    EXPECT_TRUE(access.agent().empty() || HasText(method.input_type(), access.agent()));
    EXPECT_EQ(access.or_all_missions(), method.name() == "ListStoredBackups") << method.name();
  }
}

TEST(PolicyTest, OtherMethodsHaveNone) {
  EXPECT_EQ(ActionOf("/grpc.health.v1.Health/Check"), Action::kCheckHealth);
  EXPECT_EQ(ActionOf("/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo"),
            Action::kReflect);
  EXPECT_EQ(ActionOf("/grpc.channelz.v1.Channelz/GetServers"), Action::kInspect);
  for (const char* path : {"", "/", "/corbslam.v1.MapStore/", "/corbslam.v1.MapStore/Sync2",
                           "corbslam.v1.MapStore/Sync", "/corbslam.v2.MapStore/GetMission",
                           "/grpc.health.v1.HealthX/Check"}) {
    EXPECT_EQ(ActionOf(path), std::nullopt) << path;
  }
}

}  // namespace
}  // namespace corbslam::services
