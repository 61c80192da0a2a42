#include "services/programs/store_address.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace corbslam::services {
namespace {

using ::testing::HasSubstr;

TEST(StoreAddressTest, WhatNobodyCanConnectToIsRefused) {
  EXPECT_TRUE(CheckAdvertise("", false).ok());
  EXPECT_TRUE(CheckAdvertise("store1.lan:50051", true).ok());
  EXPECT_TRUE(CheckAdvertise("[2001:db8::1]:50051", true).ok());
  for (const char* wrong : {"0.0.0.0:50051", "[::]:50051", "store1", "store1:0", ":50051"}) {
    const absl::Status refused = CheckAdvertise(wrong, true);
    EXPECT_TRUE(absl::IsInvalidArgument(refused)) << wrong;
    EXPECT_THAT(std::string(refused.message()), HasSubstr("--advertise"));
  }
  const absl::Status alone = CheckAdvertise("store1.lan:50051", false);
  EXPECT_THAT(std::string(alone.message()), HasSubstr("of no use without --journal"));
}

TEST(StoreAddressTest, WhatIsServedIsWhereOthersReachIt) {
  EXPECT_EQ(AddressForOthers("lb:1", "0.0.0.0:50051", "box").value_or(""), "lb:1");
  EXPECT_EQ(AddressForOthers("", "0.0.0.0:50051", "box").value_or(""), "box:50051");
  EXPECT_EQ(AddressForOthers("", "[::]:50051", "box").value_or(""), "box:50051");
  EXPECT_EQ(AddressForOthers("", "10.0.0.5:50051", "box").value_or(""), "10.0.0.5:50051");
}

TEST(StoreAddressTest, AnAddressOfThisMachineAloneIsRefusedOnceAnotherMachineHasAStore) {
  map_store::DirectoryStore other;
  other.name = other.address = "there:50051";
  other.machine = "there";
  EXPECT_TRUE(CheckReachedByAll("127.0.0.1:50051", "here", {other}).ok());
  other.lease_left = absl::Seconds(10);
  for (const char* own : {"127.0.0.1:50051", "localhost:50051", "[::1]:50051"}) {
    const absl::Status refused = CheckReachedByAll(own, "here", {other});
    EXPECT_TRUE(absl::IsFailedPrecondition(refused)) << own;
    EXPECT_THAT(std::string(refused.message()), HasSubstr("--advertise"));
  }
  EXPECT_TRUE(CheckReachedByAll("10.0.0.5:50051", "here", {other}).ok());
  EXPECT_TRUE(CheckReachedByAll("127.0.0.1:50051", "there", {other}).ok());
}

}  // namespace
}  // namespace corbslam::services
