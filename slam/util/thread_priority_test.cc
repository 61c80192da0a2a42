#include "slam/util/thread_priority.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <thread>

namespace corbslam {
namespace {

int NicenessOfThisThread() { return getpriority(PRIO_PROCESS, static_cast<id_t>(gettid())); }

// Runs it in a thread of its own, because a thread can't take back what it gave up.
template <typename Function>
void InAThread(Function function) {
  std::thread(function).join();
}

TEST(ThreadPriorityTest, IsSoManyStepsBelowWhatTheThreadHad) {
  const int before = NicenessOfThisThread();
  InAThread([before] {
    EXPECT_TRUE(LowerThreadPriority(5).ok());
    EXPECT_EQ(NicenessOfThisThread(), std::min(19, before + 5));
  });
  EXPECT_EQ(NicenessOfThisThread(), before) << "others keep theirs";
}

// The process has niceness 15, as if it was started with that.
TEST(ThreadPriorityTest, IsBelowTheProcessHoweverItWasStarted) {
  InAThread([] {
    const int process = std::max(15, NicenessOfThisThread());
    setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), process);
    InAThread([process] {
      EXPECT_TRUE(LowerThreadPriority(3).ok());
      EXPECT_EQ(NicenessOfThisThread(), std::min(19, process + 3));
      EXPECT_TRUE(LowerThreadPriority(10).ok());
      EXPECT_EQ(NicenessOfThisThread(), 19) << "there is no lower one";
    });
  });
}

TEST(ThreadPriorityTest, NoStepsChangeNothing) {
  const int before = NicenessOfThisThread();
  EXPECT_TRUE(LowerThreadPriority(0).ok());
  EXPECT_EQ(NicenessOfThisThread(), before);
}

}  // namespace
}  // namespace corbslam
