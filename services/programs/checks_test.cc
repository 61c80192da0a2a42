#include "services/programs/checks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "services/programs/default_vocabulary.h"
#include "services/testing/test_path.h"

namespace corbslam::services {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

namespace fs = std::filesystem;

class ChecksTest : public ::testing::Test {
 protected:
  ChecksTest() {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }

  const fs::path folder_ = TestPath("folder");
};

TEST_F(ChecksTest, AddressesNeedAPort) {
  EXPECT_TRUE(CheckFlagAddress("--listen", "0.0.0.0:50051").ok());
  EXPECT_TRUE(CheckFlagAddress("--listen", "[::1]:0").ok());
  for (const char* address : {"", "localhost", "localhost:", "localhost:65536", "localhost:http"}) {
    EXPECT_THAT(CheckFlagAddress("--worker", address).message(), HasSubstr("--worker: address is"));
    EXPECT_THAT(CheckFlagServer("--worker", address).message(), HasSubstr("--worker: address is"));
  }
  EXPECT_TRUE(CheckFlagServer("--server", "store.lan:50051").ok());
  EXPECT_THAT(CheckFlagServer("--server", "store.lan:0").message(), HasSubstr("listening on"));
}

TEST_F(ChecksTest, FoldersCanBeThereOrBeMade) {
  EXPECT_TRUE(CheckFolder("--data-dir", folder_).ok());
  EXPECT_TRUE(CheckFolder("--data-dir", folder_ / "a/b/c").ok());
  EXPECT_FALSE(fs::exists(folder_ / "a"));
  std::ofstream(folder_ / "file") << "text";
  EXPECT_THAT(CheckFolder("--data-dir", folder_ / "file").message(), HasSubstr("is no folder"));
  EXPECT_THAT(CheckFolder("--data-dir", folder_ / "file/below").message(),
              AllOf(HasSubstr("--data-dir"), HasSubstr("file is no folder")));
  if (geteuid() == 0) return;  // Root may write everywhere.
  EXPECT_EQ(CheckFolder("--data-dir", "/proc/nothing").code(), absl::StatusCode::kPermissionDenied);
}

TEST_F(ChecksTest, FilesNeedTheirFolder) {
  EXPECT_TRUE(CheckFolderOf(folder_ / "new.json").ok());
  EXPECT_THAT(CheckFolderOf(folder_ / "none/new.json").message(), HasSubstr("none/new.json"));
}

TEST_F(ChecksTest, MetricsNeedAnAddress) {
  EXPECT_TRUE(CheckObserving({}).empty());
  const auto found = CheckObserving({.metrics_listen = "nowhere"});
  ASSERT_EQ(found.size(), 1u);
  EXPECT_THAT(found[0].message(), HasSubstr("--metrics-listen"));
}

TEST_F(ChecksTest, VocabulariesAreReadToTheEnd) {
  EXPECT_TRUE(CheckVocabulary(DefaultVocabularyPath()).ok());
  EXPECT_FALSE(CheckVocabulary(folder_ / "none.voc").ok());
  const fs::path damaged = folder_ / "damaged.voc";
  fs::copy_file(DefaultVocabularyPath(), damaged);
  std::fstream file(damaged, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(static_cast<std::streamoff>(fs::file_size(damaged) / 2));
  file.put('\x5a').put('\x5a');
  file.close();
  EXPECT_FALSE(CheckVocabulary(damaged).ok());
}

}  // namespace
}  // namespace corbslam::services
