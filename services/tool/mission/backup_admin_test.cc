#include "services/tool/mission/backup_admin.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "services/server/server.h"

namespace corbslam::services {
namespace {

using ::testing::HasSubstr;

constexpr int64_t kMinute_ns = 60'000'000'000;

// A store that has two backups of each mission, of minute 10 and 20.
class TwoBackups : public v1::MapStore::CallbackService {
 public:
  grpc::ServerUnaryReactor* ListStoredBackups(grpc::CallbackServerContext* context,
                                              const v1::ListStoredBackupsRequest* request,
                                              v1::ListStoredBackupsResponse* response) override {
    // A page has one.
    const int number = request->page_token().empty() ? 1 : 2;
    if (request->parent() != "missions/none") {
      v1::StoredBackup& backup = *response->add_backups();
      backup.set_name(request->parent() + "/backups/" + std::to_string(number));
      backup.set_created_ns(number * 10 * kMinute_ns);
      if (number == 1) response->set_next_page_token("more");
    }
    grpc::ServerUnaryReactor* reactor = context->DefaultReactor();
    reactor->Finish(grpc::Status::OK);
    return reactor;
  }
};

class BackupAdminTest : public ::testing::Test {
 protected:
  void SetUp() override {
    auto server = Server::Start("", {&service_});
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
    admin_ = std::make_unique<BackupAdmin>(server_->InProcessChannel());
  }
  static absl::Time Minute(int minute) { return absl::UnixEpoch() + absl::Minutes(minute); }

  TwoBackups service_;
  std::unique_ptr<Server> server_;
  std::unique_ptr<BackupAdmin> admin_;
};

TEST_F(BackupAdminTest, ListsAllPages) {
  const auto backups = admin_->List("");
  ASSERT_TRUE(backups.ok()) << backups.status();
  ASSERT_EQ(backups->size(), 2u);
  EXPECT_EQ((*backups)[1].name(), "missions/-/backups/2");
}

TEST_F(BackupAdminTest, APointInTimeIsTheNewestThatIsNotNewer) {
  EXPECT_EQ(admin_->FindAt("lab", Minute(20))->name(), "missions/lab/backups/2");
  EXPECT_EQ(admin_->FindAt("lab", Minute(19))->name(), "missions/lab/backups/1");
  EXPECT_EQ(admin_->FindAt("lab", absl::InfiniteFuture())->name(), "missions/lab/backups/2");
  const absl::Status before = admin_->FindAt("lab", Minute(9)).status();
  EXPECT_TRUE(absl::IsNotFound(before)) << before;
  EXPECT_THAT(std::string(before.message()), HasSubstr("1970-01-01T00:10:00"));
  EXPECT_TRUE(absl::IsNotFound(admin_->FindAt("none", Minute(20)).status()));
}

TEST(BackupTimeTest, WantsAZone) {
  EXPECT_EQ(*ParseBackupTime("1970-01-01T01:00:10+01:00"), absl::FromUnixSeconds(10));
  EXPECT_EQ(*ParseBackupTime("1970-01-01T00:00:10Z"), absl::FromUnixSeconds(10));
  for (const char* text : {"", "yesterday", "1970-01-01", "1970-01-01T00:00:10", "1700000000"}) {
    EXPECT_TRUE(absl::IsInvalidArgument(ParseBackupTime(text).status())) << text;
  }
}

TEST(BackupTextTest, ATableAndJsonSayTheSame) {
  v1::StoredBackup backup;
  backup.set_name("missions/lab/backups/3");
  backup.set_created_ns(10 * kMinute_ns);
  backup.set_bytes(3 << 20);
  backup.set_keyframes(4711);
  backup.set_archived(true);
  backup.set_mission_uid("0123");
  const std::string table = FormatBackups({backup});
  for (const char* part : {"missions/lab/backups/3", "1970-01-01T00:10:00", "3.0", "4711", "0123",
                           "not yet", "archive"}) {
    EXPECT_THAT(table, HasSubstr(part));
  }
  EXPECT_EQ(ToJson(backup)["keyframes"], 4711);
  EXPECT_EQ(ToJson(backup)["archived"], true);
  EXPECT_EQ(ToJson(backup)["mission_uid"], "0123");
  backup.set_damage("a file");
  EXPECT_THAT(FormatBackups({backup}), HasSubstr("DAMAGED: a file"));
}

}  // namespace
}  // namespace corbslam::services
