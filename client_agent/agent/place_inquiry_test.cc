#include "client_agent/agent/place_inquiry.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>

#include "absl/synchronization/notification.h"

namespace corbslam::client_agent {
namespace {

using Found = absl::StatusOr<std::optional<Rigid3d>>;

std::shared_ptr<const KeyframePayload> Frame(size_t keypoints = 10) {
  Features features;
  features.keypoints.resize(keypoints);
  features.descriptors.resize(keypoints);
  return MakeKeyframePayload({}, 0, 0, std::make_shared<const Camera>(), std::move(features));
}

class PlaceInquiryTest : public ::testing::Test {
 protected:
  PlaceInquiryOptions Options() {
    PlaceInquiryOptions options;
    options.clock = [this] { return now_; };
    return options;
  }
  PlaceQuestion Lost() const { return {frame_, {1}, std::nullopt}; }
  PlaceQuestion Tracked() const { return {frame_, {1}, Rigid3d::Identity()}; }
  AskPlace Asker() {
    return [this](const KeyframePayload&) {
      ++asked_;
      return found_;
    };
  }

  const std::shared_ptr<const KeyframePayload> frame_ = Frame();
  absl::Time now_ = absl::UnixEpoch();
  int asked_ = 0;
  Found found_ = std::optional<Rigid3d>();
};

TEST_F(PlaceInquiryTest, NobodyIsAskedWhereThereIsNobody) {
  PlaceInquiry inquiry(nullptr, Options(), /*threaded=*/true);
  EXPECT_FALSE(inquiry.MayAsk(true));
  inquiry.Ask(Lost());
  EXPECT_FALSE(inquiry.TakeAnswer().has_value());
}

TEST_F(PlaceInquiryTest, AnAnswerComesOnceWithItsQuestion) {
  found_ = Rigid3d{Eigen::Quaterniond::Identity(), {1, 2, 3}};
  PlaceInquiry inquiry(Asker(), Options(), /*threaded=*/false);
  inquiry.Ask(Lost());
  EXPECT_FALSE(inquiry.MayAsk(true)) << "the answer was not taken yet";
  const auto answer = inquiry.TakeAnswer();
  ASSERT_TRUE(answer.has_value());
  EXPECT_EQ(answer->question.frame, frame_);
  EXPECT_EQ(answer->camera_from_global.translation, Eigen::Vector3d(1, 2, 3));
  EXPECT_FALSE(inquiry.TakeAnswer().has_value());
}

TEST_F(PlaceInquiryTest, WhoOnlyDoesNotKnowWhereItsMapLiesAsksSeldomerAndSeldomer) {
  PlaceInquiry inquiry(Asker(), Options(), /*threaded=*/false);
  for (int second = 0; second < 600; ++second) {
    for (int tenth = 0; tenth < 10; ++tenth) {
      inquiry.Ask(Tracked());
      now_ += absl::Milliseconds(100);
    }
  }
  // 0.2 s doubled up to 5 s.
  EXPECT_GT(asked_, 100);
  EXPECT_LT(asked_, 130);
  EXPECT_TRUE(inquiry.MayAsk(true) || now_ < absl::UnixEpoch() + absl::Seconds(601));
}

// The answer may be of no use to it, as where its map store does not fuse its map.
TEST_F(PlaceInquiryTest, SoDoesWhoIsAnsweredEachTime) {
  found_ = Rigid3d::Identity();
  PlaceInquiry inquiry(Asker(), Options(), /*threaded=*/false);
  const auto ask_for = [&](int seconds) {
    const int before = asked_;
    for (int tenth = 0; tenth < 10 * seconds; ++tenth) {
      inquiry.Ask(Tracked());
      inquiry.TakeAnswer();
      now_ += absl::Milliseconds(100);
    }
    return asked_ - before;
  };
  EXPECT_LT(ask_for(600), 130);
  inquiry.BeginLocalMap();
  EXPECT_GE(ask_for(1), 2) << "a new local map lies somewhere else";
}

TEST_F(PlaceInquiryTest, ALostRobotAsksAgainAndAgain) {
  PlaceInquiry inquiry(Asker(), Options(), /*threaded=*/false);
  for (int i = 0; i < 100; ++i) {
    inquiry.Ask(Lost());
    now_ += absl::Milliseconds(100);
  }
  EXPECT_EQ(asked_, 50);
}

TEST_F(PlaceInquiryTest, QuestionsLeaveMostOfANarrowLinkToTheMap) {
  PlaceInquiryOptions options = Options();
  // 10 keypoints of some 48 bytes at a quarter of 96 bytes a second: 20 s.
  options.uplink_bytes_per_second = 96;
  PlaceInquiry inquiry(Asker(), options, /*threaded=*/false);
  inquiry.Ask(Lost());
  now_ += absl::Seconds(19);
  EXPECT_FALSE(inquiry.MayAsk(true));
  now_ += absl::Seconds(2);
  EXPECT_TRUE(inquiry.MayAsk(true));
}

TEST_F(PlaceInquiryTest, AStoreThatIsAwayIsAskedAgainLater) {
  found_ = absl::UnavailableError("away");
  PlaceInquiry inquiry(Asker(), Options(), /*threaded=*/false);
  inquiry.Ask(Lost());
  now_ += absl::Seconds(1);
  EXPECT_FALSE(inquiry.MayAsk(true));
  now_ += absl::Seconds(2);
  EXPECT_TRUE(inquiry.MayAsk(true));
}

TEST_F(PlaceInquiryTest, AStoreThatCannotIsNotAskedAgain) {
  for (const auto& error : {absl::UnimplementedError("old"), absl::PermissionDeniedError("no")}) {
    found_ = error;
    PlaceInquiry inquiry(Asker(), Options(), /*threaded=*/false);
    inquiry.Ask(Lost());
    now_ += absl::Hours(1);
    EXPECT_FALSE(inquiry.MayAsk(true)) << error;
    EXPECT_FALSE(inquiry.MayAsk(false)) << error;
  }
}

TEST_F(PlaceInquiryTest, OneQuestionIsOnItsWayAtATime) {
  absl::Notification let_go;
  std::atomic<int> asked = 0;
  PlaceInquiryOptions options;
  PlaceInquiry inquiry(
      [&](const KeyframePayload&) -> Found {
        ++asked;
        let_go.WaitForNotification();
        return std::optional(Rigid3d::Identity());
      },
      options, /*threaded=*/true);
  inquiry.Ask(Lost());
  inquiry.Ask(Lost());
  EXPECT_FALSE(inquiry.MayAsk(true));
  let_go.Notify();
  std::optional<PlaceAnswer> answer;
  while (!answer.has_value()) answer = inquiry.TakeAnswer();
  EXPECT_EQ(asked, 1);
}

}  // namespace
}  // namespace corbslam::client_agent
