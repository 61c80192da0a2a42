#include "client_agent/link/picture_outbox.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "client_agent/link/store_link.h"
#include "client_agent/link/testing/fake_map_jobs.h"
#include "client_agent/link/testing/fake_uplink.h"

namespace corbslam::client_agent {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr LocalMapId kOwn{1};

KeyframePicture Picture(uint32_t index, size_t bytes = 1000) {
  return {{kOwn, index}, std::string(bytes, 'x'), 4};
}

MapUpdateBatch BatchWith(const std::vector<uint32_t>& indices) {
  MapUpdateBatch batch;
  batch.local_map = kOwn;
  for (const uint32_t index : indices) {
    batch.full_keyframes.push_back(
        {MakeKeyframePayload({kOwn, index}, 0, 0, std::make_shared<Camera>(), {}), {}, {}});
  }
  return batch;
}

std::vector<uint32_t> Indices(const std::vector<KeyframePicture>& pictures) {
  std::vector<uint32_t> indices;
  for (const KeyframePicture& picture : pictures) indices.push_back(picture.keyframe.index);
  return indices;
}

class PictureOutboxTest : public ::testing::Test {
 protected:
  PictureOutboxTest() { uplink_.open = true; }
  std::vector<uint32_t> Send(uint64_t bytes_per_second = 0) {
    LinkBudget budget(bytes_per_second);
    outbox_.SendTo(uplink_, budget, now_);
    return Indices(uplink_.pictures);
  }

  absl::Time now_ = absl::UnixEpoch();
  FakeUplink uplink_;
  PictureOutbox outbox_;
};

TEST_F(PictureOutboxTest, APictureFollowsTheBatchWithItsKeyframe) {
  for (const uint32_t index : {1, 2, 3}) outbox_.Add(Picture(index));
  EXPECT_THAT(Send(), IsEmpty());
  EXPECT_FALSE(outbox_.HasReady());
  outbox_.NoteSent(BatchWith({1, 3}));
  EXPECT_TRUE(outbox_.HasReady());
  EXPECT_THAT(Send(), ElementsAre(1, 3));
  EXPECT_THAT(Send(), ElementsAre(1, 3)) << "none is sent twice";
  outbox_.NoteSent(BatchWith({1, 2, 3}));
  EXPECT_THAT(Send(), ElementsAre(1, 3, 2)) << "nor when a batch is sent again";
  EXPECT_EQ(outbox_.counts().sent, 3u);
  EXPECT_EQ(outbox_.counts().sent_bytes, 3000u);
}

TEST_F(PictureOutboxTest, OneThatIsLateFollowsAtOnce) {
  outbox_.NoteSent(BatchWith({5}));
  outbox_.Add(Picture(5));
  EXPECT_THAT(Send(), ElementsAre(5));
}

TEST_F(PictureOutboxTest, TheOldestGoBeyondItsBounds) {
  for (uint32_t index = 0; index < PictureOutbox::kMaxPictures + 10; ++index) {
    outbox_.Add(Picture(index, 100));
  }
  EXPECT_EQ(outbox_.counts().waiting, PictureOutbox::kMaxPictures);
  EXPECT_EQ(outbox_.counts().dropped, 10u);
  outbox_.NoteSent(BatchWith({9, 10}));
  EXPECT_THAT(Send(), ElementsAre(10));
  for (uint32_t index = 1000; index < 1200; ++index) outbox_.Add(Picture(index, 50000));
  EXPECT_LE(outbox_.counts().waiting * 50000, PictureOutbox::kMaxBytes);
}

TEST_F(PictureOutboxTest, WhatIsNoPictureOrTooLargeIsNotHeld) {
  outbox_.Add(Picture(1, 0));
  outbox_.Add(Picture(2, kMaxPictureBytes + 1));
  outbox_.Add(Picture(3, kMaxPictureBytes));
  EXPECT_EQ(outbox_.counts().waiting, 1u);
}

TEST_F(PictureOutboxTest, MapsGoFirst) {
  outbox_.Add(Picture(1));
  outbox_.NoteSent(BatchWith({1}));
  uplink_.waiting = PictureOutbox::kMostAhead_bytes + 1;
  EXPECT_THAT(Send(), IsEmpty()) << "the transport has enough to do";
  uplink_.waiting = 0;
  // Of a second's budget more than half would be gone.
  EXPECT_THAT(Send(/*bytes_per_second=*/1500), IsEmpty());
  EXPECT_THAT(Send(/*bytes_per_second=*/3000), ElementsAre(1));
}

TEST_F(PictureOutboxTest, ATransportWithoutRoomGivesItBack) {
  for (const uint32_t index : {1, 2}) outbox_.Add(Picture(index));
  outbox_.NoteSent(BatchWith({1, 2}));
  uplink_.takes_pictures = false;
  EXPECT_THAT(Send(), IsEmpty());
  EXPECT_EQ(outbox_.counts().waiting, 2u);
  uplink_.takes_pictures = true;
  EXPECT_THAT(Send(), ElementsAre(1, 2)) << "in their order";
}

TEST_F(PictureOutboxTest, AStoreThatTakesNoneIsSentNone) {
  outbox_.Add(Picture(1));
  outbox_.NoteSent(BatchWith({1}));
  outbox_.BeginSession(/*takes=*/false);
  EXPECT_FALSE(outbox_.Wants());
  EXPECT_THAT(Send(), IsEmpty());
  outbox_.Add(Picture(2));
  EXPECT_EQ(outbox_.counts().waiting, 0u);
  outbox_.BeginSession(/*takes=*/true);
  EXPECT_TRUE(outbox_.Wants());
}

// The link as a whole, without a thread of its own.
class LinkPicturesTest : public ::testing::Test {
 protected:
  void Make(StoreLinkOptions options = {}) {
    options.mission = "m";
    options.agent = "alpha";
    options.hold_newest_keyframes = 0;
    link_ = std::make_unique<StoreLink>(options, &uplink_,
                                        [](const auto&) { return std::make_shared<Words>(); });
    link_->BeginLocalMap(map_, jobs_);
  }
  void AddKeyframe(uint32_t index) {
    Keyframe keyframe;
    keyframe.payload = MakeKeyframePayload({kOwn, index}, 0, 0, std::make_shared<Camera>(), {});
    map_.Write([&](Map& map) { map.AddKeyframe(keyframe); });
    link_->AddPicture(Picture(index));
  }

  FakeUplink uplink_;
  FakeMapJobs jobs_;
  GuardedMap map_{kOwn};
  std::unique_ptr<StoreLink> link_;
};

TEST_F(LinkPicturesTest, PicturesGoUpBehindTheirKeyframesAndCountAsSent) {
  uplink_.capabilities.keyframe_pictures = true;
  Make();
  AddKeyframe(0);
  AddKeyframe(1);
  EXPECT_TRUE(link_->WantsPictures());
  link_->Step();
  EXPECT_THAT(Indices(uplink_.pictures), ElementsAre(0, 1));
  EXPECT_EQ(link_->pictures().sent, 2u);
  EXPECT_GE(uplink_.bytes_up(), 2000u);
  EXPECT_TRUE(link_->Finish(absl::Seconds(1)).ok());
}

TEST_F(LinkPicturesTest, AnOlderStoreIsSentNone) {
  Make();
  AddKeyframe(0);
  link_->Step();
  EXPECT_THAT(uplink_.pictures, IsEmpty());
  EXPECT_FALSE(link_->WantsPictures());
  EXPECT_EQ(uplink_.stored[kOwn].size(), 1u);
}

TEST_F(LinkPicturesTest, WhileNobodyAnswersTheyWaitAndTheMapLosesNothing) {
  uplink_.capabilities.keyframe_pictures = true;
  uplink_.reachable = false;
  StoreLinkOptions options;
  options.min_backoff = options.max_backoff = absl::ZeroDuration();
  Make(options);
  AddKeyframe(0);
  link_->Step();
  EXPECT_EQ(link_->pictures().waiting, 1u);
  uplink_.reachable = true;
  link_->Step();
  link_->Step();
  EXPECT_THAT(Indices(uplink_.pictures), ElementsAre(0));
}

TEST_F(LinkPicturesTest, ARobotThatOnlyLocalisesWantsNone) {
  StoreLinkOptions options;
  options.localise_only = true;
  Make(options);
  EXPECT_FALSE(link_->WantsPictures());
}

}  // namespace
}  // namespace corbslam::client_agent
