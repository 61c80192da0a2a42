#include "services/client/remote/worker_choice.h"

#include <gtest/gtest.h>

namespace corbslam::services {
namespace {

TEST(WorkerChoiceTest, TheLeastBusyIsAskedAndOfEqualsNotAlwaysTheSame) {
  const absl::Time now = absl::UnixEpoch();
  std::vector<WorkerStanding> workers(3);
  EXPECT_EQ(ChooseWorker(workers, 0, now), 0u);
  EXPECT_EQ(ChooseWorker(workers, 2, now), 2u);
  workers[2].running = 1;
  EXPECT_EQ(ChooseWorker(workers, 2, now), 0u);
  workers[0].is_tried = workers[1].is_tried = true;
  EXPECT_EQ(ChooseWorker(workers, 0, now), 2u);
  workers[2].is_tried = true;
  EXPECT_EQ(ChooseWorker(workers, 0, now), 3u);
  EXPECT_EQ(ChooseWorker({}, 0, now), 0u);
}

TEST(WorkerChoiceTest, WhoTookNothingAMomentAgoIsAskedLast) {
  const absl::Time now = absl::UnixEpoch();
  std::vector<WorkerStanding> workers(2);
  workers[0].refused_at = now;
  workers[1].running = 5;
  EXPECT_EQ(ChooseWorker(workers, 0, now + absl::Seconds(9)), 1u);
  EXPECT_EQ(ChooseWorker(workers, 0, now + absl::Seconds(10)), 0u);
  workers[1].is_tried = true;
  EXPECT_EQ(ChooseWorker(workers, 0, now), 0u);
}

}  // namespace
}  // namespace corbslam::services
