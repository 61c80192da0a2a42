#include "client_agent/agent/after_work.h"

#include <gtest/gtest.h>

#include <vector>

#include "absl/synchronization/notification.h"
#include "absl/time/clock.h"

namespace corbslam::client_agent {
namespace {

TEST(AfterWorkTest, WhoPostsDoesNotWaitForWork) {
  absl::Notification go_on;
  std::vector<int> done;
  {
    AfterWork work(/*threaded=*/true);
    work.Post([&] { go_on.WaitForNotification(); });
    for (int i = 0; i < 3; ++i) work.Post([&done, i] { done.push_back(i); });
    EXPECT_FALSE(work.WaitUntilIdle(absl::Now() + absl::Milliseconds(20)));
    go_on.Notify();
  }
  EXPECT_EQ(done, (std::vector<int>{0, 1, 2})) << "all of it is done before the end";
}

TEST(AfterWorkTest, IsIdleOnceAllIsDone) {
  AfterWork work(/*threaded=*/true);
  EXPECT_TRUE(work.WaitUntilIdle(absl::Now() + absl::Minutes(1)));
  int done = 0;
  for (int i = 0; i < 100; ++i) work.Post([&done] { ++done; });
  EXPECT_TRUE(work.WaitUntilIdle(absl::Now() + absl::Minutes(1)));
  EXPECT_EQ(done, 100);
}

TEST(AfterWorkTest, WithoutAThreadItIsDoneAtOnce) {
  AfterWork work(/*threaded=*/false);
  bool done = false;
  work.Post([&done] { done = true; });
  EXPECT_TRUE(done);
}

}  // namespace
}  // namespace corbslam::client_agent
