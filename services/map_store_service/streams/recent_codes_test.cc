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
  std::weak_ptr<const std::string> Apply(size_t bytes, const absl::Status& status = {},
                                         const SessionAgent& who = {}) {
    MapUpdateBatch batch;
    batch.full_keyframes.resize(2);
    batch.full_keyframes[0].code = std::make_shared<const std::string>(bytes, 'c');
    codes_.OnApplied(who, batch, absl::ZeroDuration(), status);
    return batch.full_keyframes[0].code;
  }

  absl::Time now_ = absl::FromUnixSeconds(1'000'000);
  RecentCodes codes_{100, [this] { return now_; }};
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

TEST_F(RecentCodesTest, TheyGoWithTheLastSessionOfTheirMission) {
  const SessionAgent alpha{"a mission", "alpha"};
  const SessionAgent bravo{"a mission", "bravo"};
  const SessionAgent elsewhere{"another mission", "alpha"};
  for (const SessionAgent& who : {alpha, bravo, elsewhere}) codes_.OnOpened(who);
  const auto of_alpha = Apply(30, {}, alpha);
  const auto of_other = Apply(30, {}, elsewhere);
  codes_.OnClosed(alpha, absl::OkStatus());
  EXPECT_FALSE(of_alpha.expired()) << "bravo may still be sent it";
  codes_.OnClosed(bravo, absl::OkStatus());
  EXPECT_TRUE(of_alpha.expired());
  EXPECT_FALSE(of_other.expired());
  EXPECT_EQ(codes_.bytes(), 30u);
}

TEST_F(RecentCodesTest, OldOnesGoWhenOthersCome) {
  const auto first = Apply(30);
  now_ += RecentCodes::kMaxAge;
  const auto second = Apply(30);
  EXPECT_FALSE(first.expired());
  now_ += absl::Seconds(1);
  const auto third = Apply(30);
  EXPECT_TRUE(first.expired());
  EXPECT_FALSE(second.expired());
  EXPECT_EQ(codes_.bytes(), 60u);
}

TEST_F(RecentCodesTest, WhatIsRefusedIsNotKept) {
  EXPECT_TRUE(Apply(10, absl::InvalidArgumentError("a pose")).expired());
  EXPECT_EQ(codes_.bytes(), 0u);
}

}  // namespace
}  // namespace corbslam::services
