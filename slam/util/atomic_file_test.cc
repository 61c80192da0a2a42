#include "slam/util/atomic_file.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <thread>

namespace corbslam {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

std::string Read(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

class AtomicFileTest : public ::testing::Test {
 protected:
  void SetUp() override {
    path_ = ::testing::TempDir() + "/corbslam_atomic_file_" +
            ::testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::remove(path_);
  }
  void TearDown() override { EXPECT_FALSE(std::filesystem::exists(path_ + ".part")); }

  std::string path_;
};

TEST_F(AtomicFileTest, IsThereOnceItIsWhole) {
  auto file = AtomicFile::Create(path_);
  ASSERT_TRUE(file.ok()) << file.status();
  ASSERT_TRUE(file->Append("one ").ok());
  ASSERT_TRUE(file->Append("two").ok());
  EXPECT_FALSE(std::filesystem::exists(path_));
  ASSERT_TRUE(file->Finish().ok());
  EXPECT_EQ(Read(path_), "one two");
}

TEST_F(AtomicFileTest, KeepsOrReplacesWhatIsThere) {
  std::ofstream(path_) << "old";
  const auto kept = AtomicFile::Create(path_);
  EXPECT_EQ(kept.status().code(), absl::StatusCode::kAlreadyExists);
  EXPECT_THAT(std::string(kept.status().message()), HasSubstr(path_));
  {
    auto given_up = AtomicFile::Create(path_, AtomicFile::Old::kReplaced);
    ASSERT_TRUE(given_up.ok()) << given_up.status();
    ASSERT_TRUE(given_up->Append("half").ok());
  }
  EXPECT_EQ(Read(path_), "old");
  auto file = AtomicFile::Create(path_, AtomicFile::Old::kReplaced);
  ASSERT_TRUE(file.ok()) << file.status();
  ASSERT_TRUE(file->Append("new").ok());
  ASSERT_TRUE(file->Finish().ok());
  EXPECT_EQ(Read(path_), "new");
}

TEST_F(AtomicFileTest, SaysWhatItCantWrite) {
  const auto file = AtomicFile::Create("/nowhere/a");
  EXPECT_EQ(file.status().code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(std::string(file.status().message()), HasSubstr("/nowhere/a"));
}

// As long as one lives, no file of this process becomes longer than some bytes.
class ShortFiles {
 public:
  explicit ShortFiles(rlim_t bytes) {
    signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit few = {bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &few);
  }
  ~ShortFiles() { setrlimit(RLIMIT_FSIZE, &before_); }

 private:
  rlimit before_;
};

TEST_F(AtomicFileTest, WritesWholeOrLeavesWhatWasThere) {
  ASSERT_TRUE(WriteAtomically(path_, "old").ok());
  {
    const ShortFiles limit(4);
    const absl::Status full = WriteAtomically(path_, "longer");
    EXPECT_EQ(full.code(), absl::StatusCode::kUnavailable);
    EXPECT_THAT(std::string(full.message()), AllOf(HasSubstr(path_), HasSubstr("too large")));
  }
  EXPECT_EQ(Read(path_), "old");
  using std::filesystem::perms;
  std::filesystem::permissions(path_, perms::owner_read | perms::owner_write);
  ASSERT_TRUE(WriteAtomically(path_, "new").ok());
  EXPECT_EQ(Read(path_), "new");
  EXPECT_EQ(std::filesystem::status(path_).permissions(), perms::owner_read | perms::owner_write);
}

TEST_F(AtomicFileTest, LeavesWhatElseHasTheNameOfThePart) {
  std::filesystem::create_symlink("/dev/full", path_ + ".part");
  const absl::Status link = WriteAtomically(path_, "new");
  EXPECT_EQ(link.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(link.message()), HasSubstr(path_ + ".part"));
  EXPECT_TRUE(std::filesystem::is_symlink(path_ + ".part"));
  std::filesystem::remove(path_ + ".part");
}

TEST_F(AtomicFileTest, TakesThePlaceOfAPartThatWasLeftOverAndOfNoneThatIsBeingWritten) {
  std::ofstream(path_ + ".part") << "of a process that was killed";
  auto first = AtomicFile::Create(path_);
  ASSERT_TRUE(first.ok()) << first.status();
  ASSERT_TRUE(first->Append("first").ok());
  const absl::Status second = WriteAtomically(path_, "second");
  EXPECT_EQ(second.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(second.message()), HasSubstr("another process is writing it"));
  ASSERT_TRUE(first->Finish().ok());
  EXPECT_EQ(Read(path_), "first");
}

TEST_F(AtomicFileTest, FollowsLinksAndLeavesDevicesWhereTheyAre) {
  const std::string link = path_ + ".link";
  std::filesystem::remove(link);
  ASSERT_TRUE(WriteAtomically(path_, "old").ok());
  std::filesystem::create_symlink(path_, link);
  ASSERT_TRUE(WriteAtomically(link, "new").ok());
  EXPECT_TRUE(std::filesystem::is_symlink(link));
  EXPECT_EQ(Read(path_), "new");
  std::filesystem::remove(link);
  EXPECT_EQ(WriteAtomically("/dev/full", "bytes").code(), absl::StatusCode::kResourceExhausted);
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/full"));
}

TEST_F(AtomicFileTest, FollowsLinksThatLeadToNothingYet) {
  const std::string link = path_ + ".link";
  std::filesystem::remove(link);
  std::filesystem::create_symlink(std::filesystem::path(path_).filename(), link);
  EXPECT_EQ(AtomicFile::Create(link).status().code(), absl::StatusCode::kAlreadyExists);
  EXPECT_TRUE(IsForPlainFile(link));
  ASSERT_TRUE(WriteAtomically(link, "new").ok());
  EXPECT_TRUE(std::filesystem::is_symlink(link));
  EXPECT_EQ(Read(path_), "new");
  std::filesystem::remove(link);
  std::filesystem::create_symlink(link, link);
  EXPECT_EQ(WriteAtomically(link, "new").code(), absl::StatusCode::kUnavailable);
  std::filesystem::remove(link);
}

TEST_F(AtomicFileTest, WritesPieceByPieceIntoDevicesAndPipes) {
  ASSERT_EQ(mkfifo(path_.c_str(), 0600), 0);
  std::string read;
  std::thread reader([&] { read = Read(path_); });
  auto file = AtomicFile::Create(path_, AtomicFile::Old::kReplaced);
  ASSERT_TRUE(file.ok()) << file.status();
  EXPECT_TRUE(file->Append("one ").ok());
  EXPECT_TRUE(file->Append("two").ok());
  EXPECT_TRUE(file->Finish().ok());
  reader.join();
  EXPECT_EQ(read, "one two");
  EXPECT_TRUE(std::filesystem::is_fifo(path_));
  EXPECT_FALSE(IsForPlainFile(path_));
  EXPECT_EQ(CheckForPlainFile(path_, "these are two files").code(),
            absl::StatusCode::kInvalidArgument);
  std::filesystem::remove(path_);
  auto full = AtomicFile::Create("/dev/full", AtomicFile::Old::kReplaced);
  ASSERT_TRUE(full.ok()) << full.status();
  EXPECT_EQ(full->Append("bytes").code(), absl::StatusCode::kResourceExhausted);
  EXPECT_TRUE(WriteAtomically("/dev/null", "bytes").ok());
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/null"));
}

TEST_F(AtomicFileTest, MakesNoFilesAmongDevices) {
  EXPECT_EQ(WriteAtomically("/dev/corbslam_no_such_device", "bytes").code(),
            absl::StatusCode::kUnavailable);
  EXPECT_FALSE(std::filesystem::exists("/dev/corbslam_no_such_device"));
  EXPECT_FALSE(IsForPlainFile("/dev/null.README.md"));
}

TEST_F(AtomicFileTest, WritesOnWhereAnOpenFileStands) {
  const int fd = open(path_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  ASSERT_GE(fd, 0);
  ASSERT_EQ(write(fd, "before ", 7), 7);
  EXPECT_TRUE(WriteAtomically("/dev/fd/" + std::to_string(fd), "within").ok());
  ASSERT_EQ(write(fd, " behind", 7), 7);
  close(fd);
  EXPECT_EQ(Read(path_), "before within behind");
}

TEST_F(AtomicFileTest, LeavesSockets) {
  sockaddr_un address = {};
  address.sun_family = AF_UNIX;
  std::strncpy(address.sun_path, path_.c_str(), sizeof(address.sun_path) - 1);
  const int fd = socket(AF_UNIX, SOCK_STREAM, 0);
  ASSERT_EQ(bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
  EXPECT_EQ(WriteAtomically(path_, "new").code(), absl::StatusCode::kInvalidArgument);
  EXPECT_TRUE(std::filesystem::is_socket(path_));
  close(fd);
  std::filesystem::remove(path_);
}

TEST_F(AtomicFileTest, SaysWhyItCantWrite) {
  const absl::Status nowhere = WriteAtomically("/nowhere/a.svg", "");
  EXPECT_EQ(nowhere.code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(std::string(nowhere.message()), HasSubstr("No such file or directory"));
  const absl::Status folder = WriteAtomically(::testing::TempDir(), "");
  EXPECT_EQ(folder.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(folder.message()), HasSubstr("name a file in it"));
}

}  // namespace
}  // namespace corbslam
