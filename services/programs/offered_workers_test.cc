#include "services/programs/offered_workers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace corbslam::services {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

map_store::DirectoryStore Offering(const std::string& machine,
                                   const std::vector<std::string>& workers) {
  map_store::DirectoryStore store;
  store.machine = machine;
  store.workers = workers;
  store.lease_left = absl::Seconds(5);
  return store;
}

TEST(OfferedWorkersTest, EachIsUsedOnceAndNoneThatIsItsOwn) {
  EXPECT_THAT(OfferedWorkers({Offering("m1", {"w1:1", "w1:1", "w2:1"}), Offering("m2", {"w2:1"})},
                             {"w2:1"}, "here"),
              ElementsAre("w1:1"));
}

TEST(OfferedWorkersTest, OnesThatOnlyTheirMachineReachesAreOfferedThere) {
  const auto store = Offering("m1", {"127.0.0.1:50052", "localhost:1", "w:1"});
  EXPECT_THAT(OfferedWorkers({store}, {}, "m2"), ElementsAre("w:1"));
  EXPECT_THAT(OfferedWorkers({store}, {}, "m1"),
              ElementsAre("127.0.0.1:50052", "localhost:1", "w:1"));
}

TEST(OfferedWorkersTest, StoresThatAreGoneAndItselfOfferNothing) {
  auto gone = Offering("m1", {"w1:1"});
  gone.lease_left = absl::ZeroDuration();
  auto own = Offering("m1", {"w2:1"});
  own.is_own = true;
  EXPECT_THAT(OfferedWorkers({gone, own}, {}, "m1"), IsEmpty());
}

}  // namespace
}  // namespace corbslam::services
