#include "services/security/access_control.h"

#include <gmock/gmock.h>
#include <google/protobuf/descriptor.pb.h>
#include <google/protobuf/field_mask.pb.h>
#include <gtest/gtest.h>

#include "absl/strings/str_cat.h"
#include "corbslam/v1/access.pb.h"
#include "services/security/testing/token_keys.h"

namespace corbslam::services {
namespace {

using ::testing::HasSubstr;

const absl::Time kNow = absl::FromUnixSeconds(1'800'000'000);
constexpr char kHealth[] = "/grpc.health.v1.Health/Check";
constexpr char kGetMission[] = "/corbslam.v1.MapStore/GetMission";
constexpr char kDelete[] = "/corbslam.v1.MapStore/DeleteMission";
constexpr char kFuse[] = "/corbslam.v1.FusionWorker/FuseMaps";

const test_data::TokenKeys& Keys() {
  static const auto& keys = *new test_data::TokenKeys(test_data::MakeTokenKeys());
  return keys;
}

Evidence Certificate(const std::string& grant) { return {{absl::StrCat("corbslam:", grant)}, {}}; }

std::string Bearer(const std::string& grant, absl::Duration lifetime = absl::Hours(1)) {
  const auto token = SignToken({{*ParseGrant(grant)}, kNow + lifetime}, Keys().private_pem);
  EXPECT_TRUE(token.ok()) << token.status();
  return absl::StrCat("Bearer ", token.value_or(""));
}

AccessControl Make(bool health_is_open = true, const std::optional<std::string>& mission = {}) {
  AccessControlOptions options;
  options.health_is_open = health_is_open;
  options.mission = mission;
  options.tokens = *TokenVerifier::FromPem(Keys().public_pem);
  return AccessControl(options);
}

TEST(AccessControlTest, DecidesByMethodAndIdentity) {
  const AccessControl access = Make();
  const absl::StatusCode kOk = absl::StatusCode::kOk;
  const absl::StatusCode kDenied = absl::StatusCode::kPermissionDenied;
  const absl::StatusCode kNobody = absl::StatusCode::kUnauthenticated;
  struct {
    const char* path;
    Evidence evidence;
    absl::StatusCode expected;
  } const rows[] = {
      {kHealth, {}, kOk},
      {kGetMission, {}, kNobody},
      {kGetMission, {{"https://example.org"}, {}}, kNobody},
      {kGetMission, Certificate("missions/lab/viewers/eve"), kOk},
      {kGetMission, Certificate("stores/main"), kDenied},
      {kDelete, Certificate("missions/lab/viewers/eve"), kDenied},
      {kDelete, Certificate("missions/lab/operators/olga"), kOk},
      {kFuse, Certificate("missions/-/operators/olga"), kDenied},
      {kFuse, Certificate("stores/main"), kOk},
      {"/corbslam.v1.MapStore/DropEverything", Certificate("missions/-/operators/olga"), kDenied},
      {"", Certificate("missions/-/operators/olga"), kDenied},
      {kGetMission, {{}, Bearer("missions/lab/viewers/eve")}, kOk},
      {kGetMission, {{}, Bearer("missions/lab/viewers/eve", -absl::Seconds(1))}, kNobody},
      {kGetMission, {{}, "Basic abc"}, kNobody},
      {kGetMission, {{}, "Bearer "}, kNobody},
      {kDelete, {{}, Bearer("missions/lab/viewers/eve")}, kDenied},
  };
  for (const auto& [path, evidence, expected] : rows) {
    const absl::Status status = access.CheckMethod(path, evidence, kNow);
    EXPECT_EQ(status.code(), expected) << path << " " << status;
  }
}

TEST(AccessControlTest, DecidesByMission) {
  const AccessControl access = Make();
  const Evidence eve = Certificate("missions/lab/viewers/eve");
  EXPECT_TRUE(access.Check({Action::kLook, "lab", {}}, eve, kNow).ok());
  EXPECT_EQ(access.Check({Action::kLook, "field", {}}, eve, kNow).code(),
            absl::StatusCode::kPermissionDenied);
  EXPECT_EQ(access.Check({Action::kLook, "lab", {}}, {}, kNow).code(),
            absl::StatusCode::kUnauthenticated);
}

// A robot that shows an operator's token is that operator; one that shows a bad token is nobody,
// and not what its certificate says.
TEST(AccessControlTest, ATokenCountsInsteadOfTheCertificate) {
  const AccessControl access = Make();
  Evidence both = Certificate("missions/lab/agents/alpha");
  both.authorization = Bearer("missions/lab/operators/olga");
  EXPECT_TRUE(access.Check({Action::kAdminister, "lab", {}}, both, kNow).ok());
  EXPECT_FALSE(access.Check({Action::kUpload, "lab", "alpha"}, both, kNow).ok());
  both.authorization = Bearer("missions/lab/agents/alpha", -absl::Hours(1));
  EXPECT_EQ(access.Check({Action::kUpload, "lab", "alpha"}, both, kNow).code(),
            absl::StatusCode::kUnauthenticated);
}

TEST(AccessControlTest, TokensAreRefusedWhereNoKeyIsKnown) {
  const AccessControl access((AccessControlOptions()));
  const absl::Status status =
      access.CheckMethod(kGetMission, {{}, Bearer("missions/-/operators/olga")}, kNow);
  EXPECT_EQ(status.code(), absl::StatusCode::kUnauthenticated);
  EXPECT_THAT(std::string(status.message()), HasSubstr("--token-key"));
}

// Makes a call of a contract that has been forgotten to say what the call does, or which mission.
const google::protobuf::MethodDescriptor* MakeMethod(v1::Access::Action action,
                                                     google::protobuf::DescriptorPool& pool) {
  google::protobuf::FileDescriptorProto file;
  google::protobuf::FieldMask::descriptor()->file()->CopyTo(&file);
  EXPECT_NE(pool.BuildFile(file), nullptr);
  file.Clear();
  file.set_name("forgotten.proto");
  file.add_dependency("google/protobuf/field_mask.proto");
  google::protobuf::ServiceDescriptorProto& service = *file.add_service();
  service.set_name("Forgotten");
  google::protobuf::MethodDescriptorProto& method = *service.add_method();
  method.set_name("Get");
  method.set_input_type("google.protobuf.FieldMask");
  method.set_output_type("google.protobuf.FieldMask");
  if (action != v1::Access::ACTION_UNSPECIFIED) {
    method.mutable_options()->MutableExtension(v1::access)->set_action(action);
  }
  const google::protobuf::FileDescriptor* built = pool.BuildFile(file);
  return built != nullptr ? built->service(0)->method(0) : nullptr;
}

TEST(AccessControlTest, ACallThatDoesNotSayWhatItDoesAndWhereIsRefused) {
  for (const auto action : {v1::Access::ACTION_UNSPECIFIED, v1::Access::LOOK, v1::Access::UPLOAD,
                            v1::Access::COMMAND, v1::Access::ADMINISTER}) {
    google::protobuf::DescriptorPool pool;
    const google::protobuf::MethodDescriptor* method = MakeMethod(action, pool);
    ASSERT_NE(method, nullptr);
    const absl::Status status =
        Make().Check(*method, grpc::CallbackServerContext(), google::protobuf::FieldMask());
    EXPECT_EQ(status, absl::PermissionDeniedError(
                          "Forgotten.Get does not say what it does, and of which mission"));
  }
}

// Returns what a store called "north", which takes tokens of a day at most, says to these claims.
absl::Status Ask(TokenClaims claims) {
  AccessControlOptions options;
  options.tokens = *TokenVerifier::FromPem(Keys().public_pem);
  options.audience = "north";
  options.max_token_lifetime = absl::Hours(24);
  claims.grants = {*ParseGrant("missions/lab/viewers/eve")};
  const auto token = SignToken(claims, Keys().private_pem);
  EXPECT_TRUE(token.ok()) << token.status();
  return AccessControl(options).CheckMethod(
      kGetMission, {{}, absl::StrCat("Bearer ", token.value_or(""))}, kNow);
}

TEST(AccessControlTest, ATokenIsForItsServersAndForNoLongerThanTheyAllow) {
  const absl::Time soon = kNow + absl::Hours(1);
  EXPECT_TRUE(Ask({.grants = {}, .expires = soon, .audience = "north"}).ok());
  EXPECT_TRUE(Ask({.grants = {}, .expires = soon}).ok()) << "one of before there were audiences";
  EXPECT_THAT(std::string(Ask({.grants = {}, .expires = soon, .audience = "south"}).message()),
              HasSubstr("is for servers called south, not for north"));
  EXPECT_TRUE(Ask({.grants = {}, .expires = soon, .issued = soon - absl::Hours(24)}).ok());
  const char* too_long = "this server takes none of over 24h (--max-token-lifetime)";
  EXPECT_THAT(
      std::string(Ask({.grants = {}, .expires = soon, .issued = soon - absl::Hours(25)}).message()),
      HasSubstr(too_long));
  EXPECT_THAT(std::string(Ask({.grants = {}, .expires = kNow + absl::Hours(25)}).message()),
              HasSubstr(too_long));
  EXPECT_THAT(
      std::string(
          Ask({.grants = {}, .expires = kNow + absl::Hours(100), .issued = kNow + absl::Hours(99)})
              .message()),
      HasSubstr(too_long));
}

TEST(AccessControlTest, AServerWithoutANameTakesNoTokenThatIsForOne) {
  TokenClaims claims = {{*ParseGrant("missions/lab/viewers/eve")}, kNow + absl::Hours(1)};
  claims.audience = "north";
  const auto token = SignToken(claims, Keys().private_pem);
  const absl::Status status =
      Make().CheckMethod(kGetMission, {{}, absl::StrCat("Bearer ", *token)}, kNow);
  EXPECT_EQ(status.code(), absl::StatusCode::kUnauthenticated);
  EXPECT_THAT(std::string(status.message()), HasSubstr("--token-audience"));
}

TEST(AccessControlTest, WhoIsRevokedIsNobodyAndIsHeardOf) {
  AccessControlOptions options;
  options.tokens = *TokenVerifier::FromPem(Keys().public_pem);
  AccessControl access(options);
  int heard = 0;
  access.OnRevoked([&heard] { ++heard; });
  const Evidence eve = Certificate("missions/lab/viewers/eve");
  const auto identity = access.Identify(eve, kNow);
  ASSERT_TRUE(identity.ok());
  access.SetRevoked(*RevokedList::Parse("missions/-/viewers/eve"));
  EXPECT_EQ(heard, 1);
  EXPECT_EQ(access.CheckMethod(kGetMission, eve, kNow).code(), absl::StatusCode::kUnauthenticated);
  EXPECT_EQ(access.CheckNotRevoked(*identity).code(), absl::StatusCode::kUnauthenticated);
  EXPECT_TRUE(access.CheckMethod(kGetMission, Certificate("missions/lab/viewers/bob"), kNow).ok());
  access.SetRevoked(RevokedList());
  EXPECT_TRUE(access.CheckMethod(kGetMission, eve, kNow).ok());
}

TEST(AccessControlTest, TokensOfANewKeyCountFromTheNextCallOn) {
  AccessControlOptions options;
  options.tokens = *TokenVerifier::FromPem(test_data::MakeTokenKeys().public_pem);
  AccessControl access(options);
  const Evidence eve = {{}, Bearer("missions/lab/viewers/eve")};
  EXPECT_FALSE(access.CheckMethod(kGetMission, eve, kNow).ok());
  access.SetTokens(*TokenVerifier::FromPem(Keys().public_pem));
  EXPECT_TRUE(access.CheckMethod(kGetMission, eve, kNow).ok());
}

TEST(AccessControlTest, ClosedHealthIsForEverybodyWithAnIdentity) {
  const AccessControl access = Make(/*health_is_open=*/false);
  EXPECT_EQ(access.CheckMethod(kHealth, {}, kNow).code(), absl::StatusCode::kUnauthenticated);
  EXPECT_TRUE(access.CheckMethod(kHealth, Certificate("workers/one"), kNow).ok());
}

TEST(AccessControlTest, AServerOfOneMissionLetsNoOtherIn) {
  const AccessControl access = Make(/*health_is_open=*/true, "lab");
  constexpr char kWatch[] = "/corbslam.v1.Agent/WatchPose";
  EXPECT_TRUE(access.CheckMethod(kWatch, Certificate("missions/lab/viewers/eve"), kNow).ok());
  EXPECT_EQ(access.CheckMethod(kWatch, Certificate("missions/field/viewers/eve"), kNow).code(),
            absl::StatusCode::kPermissionDenied);
}

}  // namespace
}  // namespace corbslam::services
