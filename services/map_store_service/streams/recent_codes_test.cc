#include "services/map_store_service/streams/recent_codes.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

namespace corbslam::services {
namespace {

class RecentCodesTest : public ::testing::Test {
 protected:
  // Returns the code of a batch that has been applied, which lives as long as it is kept.
  std::weak_ptr<const std::string> Apply(size_t bytes, const absl::Status& status = {}) {
    MapUpdateBatch batch;
    batch.full_keyframes.resize(2);
    batch.full_keyframes[0].code = std::make_shared<const std::string>(bytes, 'c');
    codes_.OnApplied({}, batch, absl::ZeroDuration(), status);
    return batch.full_keyframes[0].code;
  }

  RecentCodes codes_{100};
};

TEST_F(RecentCodesTest, TheNewestAreKept) {
  const auto first = Apply(50);
  const auto second = Apply(50);
  EXPECT_FALSE(first.expired());
  EXPECT_EQ(codes_.bytes(), 100u);
  const auto third = Apply(1);
  EXPECT_TRUE(first.expired());
  EXPECT_FALSE(second.expired());
  EXPECT_FALSE(third.expired());
  EXPECT_EQ(codes_.bytes(), 51u);
}

TEST_F(RecentCodesTest, OneThatIsTooLongIsNotKept) {
  EXPECT_TRUE(Apply(101).expired());
  EXPECT_EQ(codes_.bytes(), 0u);
}

TEST_F(RecentCodesTest, WhatIsRefusedIsNotKept) {
  EXPECT_TRUE(Apply(10, absl::InvalidArgumentError("a pose")).expired());
  EXPECT_EQ(codes_.bytes(), 0u);
}

}  // namespace
}  // namespace corbslam::services
