#include "services/convert/asked_resource.h"

#include <gtest/gtest.h>

#include <string>

#include "absl/strings/str_cat.h"
#include "corbslam/v1/map_store_service.pb.h"

namespace corbslam::services {
namespace {

std::string Ask(const char* call, const google::protobuf::Message& request) {
  const auto* method = FindMethod(absl::StrCat("/corbslam.v1.MapStore/", call));
  return method == nullptr ? "no such call" : ResourceOf(*method, request);
}

TEST(AskedResourceTest, IsTheFirstFieldThatTheContractNames) {
  v1::DeleteStoredBackupRequest deletion;
  deletion.set_backup("missions/lab/backups/3");
  EXPECT_EQ(Ask("DeleteStoredBackup", deletion), "missions/lab/backups/3");
  v1::RestoreStoredBackupRequest restore;
  restore.set_backup("missions/lab/backups/3");
  restore.set_name("missions/again");
  EXPECT_EQ(Ask("RestoreStoredBackup", restore), "missions/lab/backups/3");
  v1::CreateMissionRequest creation;
  creation.mutable_mission()->set_name("missions/lab");
  EXPECT_EQ(Ask("CreateMission", creation), "missions/lab");
  v1::ForgetLocalMapsRequest forgetting;
  forgetting.set_parent("missions/lab");
  EXPECT_EQ(Ask("ForgetLocalMaps", forgetting), "missions/lab");
}

TEST(AskedResourceTest, IsEmptyWhereACallNamesNothing) {
  EXPECT_EQ(Ask("ListMissions", v1::ListMissionsRequest()), "");
}

TEST(AskedResourceTest, FindsTheCallsOfOurContractAlone) {
  EXPECT_NE(FindMethod("/corbslam.v1.MapStore/Sync"), nullptr);
  for (const char* path :
       {"corbslam.v1.MapStore/Sync", "/corbslam.v1.MapStore/Nothing", "/corbslam.v1.MapStore",
        "/corbslam.v1.Nobody/Sync", "/corbslam.v1.MapStore/Sync/more", "", "/",
        "/grpc.health.v1.Health/Check"}) {
    EXPECT_EQ(FindMethod(path), nullptr) << path;
  }
}

TEST(AskedResourceTest, ATextThatIsNotThereIsAnError) {
  const v1::CreateMissionRequest request;
  EXPECT_EQ(ReadText(request, "name").status().code(), absl::StatusCode::kInternal);
  EXPECT_EQ(ReadText(request, "mission").status().code(), absl::StatusCode::kInternal);
  EXPECT_EQ(*ReadText(request, "mission.name"), "");
}

}  // namespace
}  // namespace corbslam::services
