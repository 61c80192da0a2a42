// Tests stored backups through the calls that operators make.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <random>
#include <string>

#include "map_store/rocks/backup_folder.h"
#include "map_store/rocks/rocks_journal.h"
#include "services/convert/testing/test_data.h"
#include "services/map_store_service/map_store_service.h"
#include "services/server/server.h"
#include "services/testing/test_path.h"

namespace corbslam::services {

using map_store::BackupFolder;
using map_store::BackupOptions;
using map_store::MapStore;
using map_store::MapStoreOptions;
using map_store::RocksJournal;
using map_store::StoredBackups;

namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class StoredBackupsServiceTest : public ::testing::Test {
 protected:
  void SetUp() override {
    fs::remove_all(folder_);
    auto journal = RocksJournal::Open({.directory = (folder_ / "data").string()});
    ASSERT_TRUE(journal.ok()) << journal.status();
    const RocksJournal* rocks = journal->get();
    store_ = std::make_unique<MapStore>(MapStoreOptions(), nullptr, *std::move(journal), nullptr);
    ASSERT_TRUE(store_->Recover().ok());
    BackupOptions options;
    options.directory = (folder_ / "backups").string();
    options.bytes_per_s = 0;
    auto shelf = BackupFolder::Open(rocks, options);
    ASSERT_TRUE(shelf.ok()) << shelf.status();
    backups_ = std::make_unique<StoredBackups>(store_.get(), *std::move(shelf), 24, &absl::Now);
    MapStoreServiceOptions service_options;
    service_options.backups = backups_.get();
    Serve(service_options);
    for (const char* mission : {"lab", "yard"}) Upload(mission);
  }
  ~StoredBackupsServiceTest() override {
    stub_.reset();
    server_.reset();
    service_.reset();
    backups_.reset();
    store_.reset();
    fs::remove_all(folder_);
  }

  void Serve(const MapStoreServiceOptions& options) {
    stub_.reset();
    server_.reset();
    service_ = std::make_unique<MapStoreService>(store_.get(), options);
    auto server = Server::Start("", {service_.get()});
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
    stub_ = v1::MapStore::NewStub(server_->InProcessChannel());
  }
  void Upload(const std::string& mission) {
    SessionRequest request;
    request.mission = mission;
    request.agent = "alpha";
    const auto session = store_->OpenSession(request);
    ASSERT_TRUE(session.ok()) << session.status();
    std::mt19937 random(7);
    ASSERT_TRUE(
        store_->Apply(session->session_id, test_data::MakeBatch(random, test_data::kMap, 1)).ok());
    store_->CloseSession(session->session_id);
  }

  grpc::Status Store(const std::string& name, v1::StoredBackup* made) {
    grpc::ClientContext context;
    v1::StoreBackupRequest request;
    request.set_name(name);
    return stub_->StoreBackup(&context, request, made);
  }
  grpc::Status Restore(const std::string& backup, const std::string& name, v1::Mission* made) {
    grpc::ClientContext context;
    v1::RestoreStoredBackupRequest request;
    request.set_backup(backup);
    request.set_name(name);
    return stub_->RestoreStoredBackup(&context, request, made);
  }
  grpc::Status Delete(const std::string& backup, v1::StoredBackup* gone) {
    grpc::ClientContext context;
    v1::DeleteStoredBackupRequest request;
    request.set_backup(backup);
    return stub_->DeleteStoredBackup(&context, request, gone);
  }
  v1::ListStoredBackupsResponse List(const std::string& parent, int size,
                                     const std::string& token = "") {
    grpc::ClientContext context;
    v1::ListStoredBackupsRequest request;
    request.set_parent(parent);
    request.set_page_size(size);
    request.set_page_token(token);
    v1::ListStoredBackupsResponse response;
    const grpc::Status status = stub_->ListStoredBackups(&context, request, &response);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return response;
  }

  const fs::path folder_ = TestPath("folder");
  std::unique_ptr<MapStore> store_;
  std::unique_ptr<StoredBackups> backups_;
  std::unique_ptr<MapStoreService> service_;
  std::unique_ptr<Server> server_;
  std::unique_ptr<v1::MapStore::Stub> stub_;
};

TEST_F(StoredBackupsServiceTest, StoresListsVerifiesAndRestores) {
  v1::StoredBackup made;
  ASSERT_TRUE(Store("missions/lab", &made).ok());
  EXPECT_EQ(made.name(), "missions/lab/backups/1");
  EXPECT_EQ(made.keyframes(), 2u);
  EXPECT_GT(made.created_ns(), 0);
  ASSERT_TRUE(Store("missions/lab", &made).ok());
  ASSERT_TRUE(Store("missions/yard", &made).ok());
  const auto first = List("missions/-", 2);
  ASSERT_EQ(first.backups_size(), 2);
  EXPECT_EQ(first.backups(1).name(), "missions/lab/backups/2");
  const auto rest = List("missions/-", 2, first.next_page_token());
  ASSERT_EQ(rest.backups_size(), 1);
  EXPECT_EQ(rest.backups(0).name(), "missions/yard/backups/1");
  EXPECT_EQ(rest.next_page_token(), "");
  EXPECT_EQ(List("missions/lab", 0).backups_size(), 2);
  {
    grpc::ClientContext context;
    v1::VerifyStoredBackupRequest request;
    request.set_backup("missions/lab/backups/2");
    const grpc::Status verified = stub_->VerifyStoredBackup(&context, request, &made);
    EXPECT_TRUE(verified.ok()) << verified.error_message();
    EXPECT_EQ(made.name(), "missions/lab/backups/2");
  }
  EXPECT_TRUE(Delete("missions/lab/backups/2", &made).ok());
  EXPECT_EQ(made.name(), "missions/lab/backups/2");
  EXPECT_EQ(List("missions/lab", 0).backups_size(), 1);
  EXPECT_EQ(Delete("missions/lab/backups/2", &made).error_code(), grpc::StatusCode::NOT_FOUND);
  v1::Mission mission;
  EXPECT_EQ(Restore("missions/lab/backups/1", "", &mission).error_code(),
            grpc::StatusCode::ALREADY_EXISTS);
  const grpc::Status restored = Restore("missions/lab/backups/1", "missions/lab2", &mission);
  ASSERT_TRUE(restored.ok()) << restored.error_message();
  EXPECT_EQ(mission.name(), "missions/lab2");
  EXPECT_EQ(mission.keyframes(), 2u);
}

TEST_F(StoredBackupsServiceTest, ArchivesAndBringsBackUnderTheOldName) {
  grpc::ClientContext context;
  v1::ArchiveMissionRequest request;
  request.set_name("missions/lab");
  v1::StoredBackup archived;
  const grpc::Status status = stub_->ArchiveMission(&context, request, &archived);
  ASSERT_TRUE(status.ok()) << status.error_message();
  EXPECT_TRUE(archived.archived());
  EXPECT_TRUE(absl::IsNotFound(store_->GetMission("lab").status()));
  EXPECT_TRUE(List("missions/lab", 0).backups(0).archived());
  v1::Mission mission;
  ASSERT_TRUE(Restore(archived.name(), "", &mission).ok());
  EXPECT_EQ(mission.name(), "missions/lab");
}

TEST_F(StoredBackupsServiceTest, RefusesNamesAndStoresWithoutAFolder) {
  v1::StoredBackup made;
  v1::Mission mission;
  for (const char* name : {"", "lab", "missions/", "missions/-", "missions/a b", "missions/.."}) {
    EXPECT_EQ(Store(name, &made).error_code(), grpc::StatusCode::INVALID_ARGUMENT) << name;
  }
  for (const char* name : {"missions/lab", "missions/lab/backups/0", "missions/lab/backups/x",
                           "missions/lab/backups/99999999999", "missions/../backups/1"}) {
    EXPECT_EQ(Restore(name, "missions/x", &mission).error_code(),
              grpc::StatusCode::INVALID_ARGUMENT)
        << name;
    EXPECT_EQ(Delete(name, &made).error_code(), grpc::StatusCode::INVALID_ARGUMENT) << name;
  }
  EXPECT_EQ(Store("missions/nobody", &made).error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(Restore("missions/lab/backups/7", "missions/x", &mission).error_code(),
            grpc::StatusCode::NOT_FOUND);
  Serve({});
  const grpc::Status none = Store("missions/lab", &made);
  EXPECT_EQ(none.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_THAT(none.error_message(), HasSubstr("--backup-dir"));
}

}  // namespace
}  // namespace corbslam::services
