#include "tests/fault/network/link_queue.h"

#include <gtest/gtest.h>

#include <string>

namespace corbslam::tests {
namespace {

const absl::Time kStart = absl::FromUnixSeconds(1000);

TEST(LinkQueueTest, WithoutAShapePacketsPassAtOnceAndInOrder) {
  LinkQueue queue({}, 0, kStart);
  EXPECT_EQ(queue.NextDue(), absl::InfiniteFuture());
  queue.Push("a", kStart);
  queue.Push("b", kStart);
  EXPECT_EQ(queue.Pop(kStart), "a");
  EXPECT_EQ(queue.Pop(kStart), "b");
  EXPECT_EQ(queue.Pop(kStart), std::nullopt);
  EXPECT_EQ(queue.counts().passed, 2u);
}

TEST(LinkQueueTest, DelayHoldsEachPacketBack) {
  LinkShape shape;
  shape.delay = absl::Milliseconds(100);
  LinkQueue queue(shape, 0, kStart);
  queue.Push("a", kStart + absl::Milliseconds(5));
  EXPECT_EQ(queue.NextDue(), kStart + absl::Milliseconds(105));
  EXPECT_EQ(queue.Pop(kStart + absl::Milliseconds(104)), std::nullopt);
  EXPECT_EQ(queue.Pop(kStart + absl::Milliseconds(105)), "a");
}

TEST(LinkQueueTest, RateSpacesPacketsAndTheRoomIsBounded) {
  LinkShape shape;
  shape.rate = 8000;  // The rate is a thousand bytes a second.
  shape.max_waiting_bytes = 2500;
  LinkQueue queue(shape, 0, kStart);
  for (int i = 0; i < 3; ++i) queue.Push(std::string(1000, 'x'), kStart);
  EXPECT_EQ(queue.counts().lost, 1u) << "there is room for two";
  EXPECT_EQ(queue.NextDue(), kStart + absl::Seconds(1));
  EXPECT_TRUE(queue.Pop(kStart + absl::Seconds(1)).has_value());
  EXPECT_EQ(queue.NextDue(), kStart + absl::Seconds(2));
  // An idle link owes nothing.
  EXPECT_TRUE(queue.Pop(kStart + absl::Seconds(2)).has_value());
  queue.Push(std::string(500, 'x'), kStart + absl::Seconds(10));
  EXPECT_EQ(queue.NextDue(), kStart + absl::Seconds(10.5));
}

TEST(LinkQueueTest, LossTakesItsShareAndTheSameOnesEachTime) {
  LinkShape shape;
  shape.loss = 0.05;
  LinkQueue queue(shape, 7, kStart);
  LinkQueue same(shape, 7, kStart);
  LinkQueue other(shape, 8, kStart);
  bool differs = false;
  for (int i = 0; i < 10000; ++i) {
    for (LinkQueue* each : {&queue, &same, &other}) each->Push("p", kStart);
    const bool passes = queue.Pop(kStart).has_value();
    EXPECT_EQ(same.Pop(kStart).has_value(), passes);
    differs |= other.Pop(kStart).has_value() != passes;
  }
  EXPECT_TRUE(differs);
  EXPECT_NEAR(static_cast<double>(queue.counts().lost), 500, 80);
}

TEST(LinkQueueTest, AnOutageTakesWhatComesAndWhatIsOnItsWay) {
  LinkShape shape;
  shape.delay = absl::Milliseconds(200);
  shape.outage_begin = absl::Seconds(5);
  shape.outage = absl::Seconds(30);
  LinkQueue queue(shape, 0, kStart);
  queue.Push("before", kStart + absl::Seconds(4.7));
  queue.Push("on its way", kStart + absl::Seconds(4.9));
  queue.Push("during", kStart + absl::Seconds(20));
  queue.Push("after", kStart + absl::Seconds(35));
  const absl::Time end = kStart + absl::Seconds(100);
  EXPECT_EQ(queue.Pop(end), "before");
  EXPECT_EQ(queue.Pop(end), "after");
  EXPECT_EQ(queue.Pop(end), std::nullopt);
  EXPECT_EQ(queue.counts().lost, 2u);
}

TEST(LinkShapeTest, AFlappingLinkIsUpAndDownInTurns) {
  LinkShape shape;
  shape.up = absl::Seconds(2);
  shape.down = absl::Seconds(2);
  EXPECT_TRUE(shape.IsUp(absl::Seconds(0)));
  EXPECT_TRUE(shape.IsUp(absl::Seconds(1.9)));
  EXPECT_FALSE(shape.IsUp(absl::Seconds(2.1)));
  EXPECT_TRUE(shape.IsUp(absl::Seconds(4)));
  EXPECT_FALSE(shape.IsUp(absl::Seconds(103)));
}

TEST(LinkShapeTest, ImpossibleShapesAreRefused) {
  EXPECT_TRUE(LinkShape().Validate().ok());
  LinkShape shape;
  shape.loss = 1;
  EXPECT_FALSE(shape.Validate().ok());
  shape = {};
  shape.rate = -1;
  EXPECT_FALSE(shape.Validate().ok());
  shape = {};
  shape.down = absl::Seconds(-1);
  EXPECT_FALSE(shape.Validate().ok());
}

}  // namespace
}  // namespace corbslam::tests
