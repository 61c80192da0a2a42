#include "slam/util/lock_holder.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <functional>
#include <string>

#include "absl/strings/str_cat.h"
#include "slam/util/process_name.h"

namespace corbslam {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

std::string MakeFile() {
  const std::string path =
      absl::StrCat(::testing::TempDir(), "/lock_holder_test_", getpid(), "_",
                   ::testing::UnitTest::GetInstance()->current_test_info()->name());
  std::ofstream(path) << "text";
  return path;
}

// A process that has locked the file, until this goes.
class Locker {
 public:
  explicit Locker(const std::function<int(int)>& lock, const std::string& path) {
    int ready[2];
    if (pipe(ready) != 0) return;
    pid_ = fork();
    if (pid_ == 0) {
      const bool locked = lock(open(path.c_str(), O_RDWR)) == 0;
      if (write(ready[1], locked ? "y" : "n", 1) == 1) pause();
      _exit(1);
    }
    char answer = 0;
    locked_ = read(ready[0], &answer, 1) == 1 && answer == 'y';
    close(ready[0]);
    close(ready[1]);
  }
  ~Locker() {
    if (pid_ <= 0) return;
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  pid_t pid() const { return pid_; }
  bool locked() const { return locked_; }

 private:
  pid_t pid_ = -1;
  bool locked_ = false;
};

int LockByFlock(int fd) { return flock(fd, LOCK_EX | LOCK_NB); }
int LockByFcntl(int fd) {
  struct flock whole = {};
  whole.l_type = F_WRLCK;
  return fcntl(fd, F_SETLK, &whole);
}

TEST(LockHolderTest, NamesTheProcessWhicheverLockItHas) {
  const std::string path = MakeFile();
  EXPECT_EQ(FindLockHolder(path), std::nullopt);
  for (const auto& lock : {LockByFlock, LockByFcntl}) {
    const Locker locker(lock, path);
    ASSERT_TRUE(locker.locked());
    EXPECT_EQ(FindLockHolder(path), locker.pid());
    EXPECT_THAT(DescribeLockHolder(path), StartsWith(absl::StrCat("process ", locker.pid(), " (")));
  }
  EXPECT_EQ(FindLockHolder(path), std::nullopt) << "they are gone";
}

TEST(LockHolderTest, LeavesALockOfOnesOwn) {
  const std::string path = MakeFile();
  const int fd = open(path.c_str(), O_RDWR);
  ASSERT_EQ(LockByFcntl(fd), 0);
  EXPECT_EQ(DescribeLockHolder(path), "this process itself has it");
  EXPECT_FALSE(Locker(LockByFcntl, path).locked()) << "it is still ours";
  close(fd);
}

TEST(LockHolderTest, SaysWhereItCantTell) {
  EXPECT_EQ(FindLockHolder("/nowhere/at/all"), std::nullopt);
  EXPECT_THAT(DescribeLockHolder("/nowhere/at/all"), HasSubstr("can't be told from here"));
}

TEST(ProcessNameTest, IsThatOfTheProgram) {
  EXPECT_EQ(DescribeProcess(getpid()), "this process itself");
  const pid_t gone = fork();
  if (gone == 0) _exit(0);
  waitpid(gone, nullptr, 0);
  EXPECT_EQ(DescribeProcess(gone), absl::StrCat("process ", gone));
  EXPECT_THAT(DescribeProcess(getppid()), HasSubstr(" ("));
}

}  // namespace
}  // namespace corbslam
