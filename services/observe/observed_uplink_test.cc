#include "services/observe/observed_uplink.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "services/observe/pending_batches.h"

namespace corbslam::services {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr LocalMapId kMap{7};

// Takes batches while it has room, and plays the store's part on demand.
class ScriptedUplink : public Uplink {
 public:
  void Open(const SessionRequest&, UplinkListener* listener) override { listener_ = listener; }
  bool Send(const MapUpdateBatch&) override { return has_room_; }
  bool SendLocalised(const LocalisedFrames& localised) override {
    localised_run_ = localised.run;
    return has_room_;
  }
  bool SendPicture(const KeyframePicture& picture) override {
    picture_ = picture.jpeg;
    return has_room_;
  }
  bool SendReport(const AgentReport& report) override {
    report_frames_ = report.frames;
    return has_room_;
  }
  void Close() override {}
  uint64_t bytes_up() const override { return 11; }
  uint64_t bytes_down() const override { return 22; }

  UplinkListener* listener_ = nullptr;
  bool has_room_ = true;
  uint64_t localised_run_ = 0;
  std::string picture_;
  uint64_t report_frames_ = 0;
};

// Plays the agent's part.
class Listener : public UplinkListener {
 public:
  explicit Listener(std::vector<std::string>* notes) : notes_(*notes) {}
  void OnSessionOpened(const SessionGrant&) override { notes_.push_back("agent opened"); }
  void OnExactPlacesWanted() override { notes_.push_back("agent is asked for exact places"); }
  void OnAcknowledged(const Acknowledgement& up_to) override {
    notes_.push_back(absl::StrCat("agent acknowledged ", up_to.number));
  }
  void OnShared(SharedUpdate update) override {
    notes_.push_back(absl::StrCat("agent shared ", update.revision));
  }
  void OnSessionClosed(const absl::Status&) override { notes_.push_back("agent closed"); }

 private:
  std::vector<std::string>& notes_;
};

class Observer : public UplinkObserver {
 public:
  explicit Observer(std::vector<std::string>* notes) : notes_(*notes) {}
  void OnOpening() override { notes_.push_back("opening"); }
  void OnOpened() override { notes_.push_back("opened"); }
  void OnSent(const MapUpdateBatch& batch, absl::Time) override {
    notes_.push_back(absl::StrCat("sent ", batch.number));
  }
  void OnAcknowledged(const Acknowledgement& up_to) override {
    notes_.push_back(absl::StrCat("acknowledged ", up_to.number));
  }
  void OnClosed(const absl::Status&) override { notes_.push_back("closed"); }

 private:
  std::vector<std::string>& notes_;
};

TEST(ObservedUplinkTest, ObserversHearAllAndTheAgentToo) {
  std::vector<std::string> notes;
  ScriptedUplink inner;
  Observer observer(&notes);
  Listener agent(&notes);
  const auto uplink = MakeObservedUplink(&inner, {&observer});
  uplink->Open({}, &agent);
  inner.listener_->OnSessionOpened({.acknowledged = {{kMap, 3}}});
  MapUpdateBatch batch;
  batch.number = 4;
  inner.has_room_ = false;
  EXPECT_FALSE(uplink->Send(batch)) << "not sent, not heard of";
  inner.has_room_ = true;
  EXPECT_TRUE(uplink->Send(batch));
  inner.listener_->OnAcknowledged({kMap, 4});
  SharedUpdate update;
  update.revision = 9;
  inner.listener_->OnShared(update);
  inner.listener_->OnSessionClosed(absl::UnavailableError("gone"));
  EXPECT_THAT(notes, ElementsAre("opening", "opened", "acknowledged 3", "agent opened", "sent 4",
                                 "acknowledged 4", "agent acknowledged 4", "agent shared 9",
                                 "closed", "agent closed"));
  EXPECT_EQ(uplink->bytes_up(), 11u);
  EXPECT_EQ(uplink->bytes_down(), 22u);
}

TEST(ObservedUplinkTest, WhatNobodyObservesGoesThroughToo) {
  ScriptedUplink inner;
  const auto uplink = MakeObservedUplink(&inner, {});
  LocalisedFrames localised;
  localised.run = 5;
  EXPECT_TRUE(uplink->SendLocalised(localised));
  EXPECT_TRUE(uplink->SendPicture({.keyframe = {kMap, 1}, .jpeg = "a picture"}));
  EXPECT_TRUE(uplink->SendReport({.frames = 6}));
  EXPECT_EQ(inner.localised_run_, 5u);
  EXPECT_EQ(inner.picture_, "a picture");
  EXPECT_EQ(inner.report_frames_, 6u);
  inner.has_room_ = false;
  EXPECT_FALSE(uplink->SendLocalised({}));
  EXPECT_FALSE(uplink->SendPicture({}));
  EXPECT_FALSE(uplink->SendReport({}));
}

TEST(PendingBatchesTest, AnAcknowledgementCoversAllBefore) {
  PendingBatches<int> pending;
  EXPECT_THAT(pending.Sent(kMap, 1, 10), IsEmpty());
  EXPECT_THAT(pending.Sent(kMap, 2, 20), IsEmpty());
  EXPECT_THAT(pending.Sent({8}, 1, 99), IsEmpty());
  EXPECT_THAT(pending.Acknowledged({kMap, 2}), ElementsAre(10, 20));
  EXPECT_THAT(pending.Acknowledged({kMap, 2}), IsEmpty()) << "once";
}

TEST(PendingBatchesTest, TheAcknowledgementMayBeHeardFirst) {
  PendingBatches<int> pending;
  EXPECT_THAT(pending.Acknowledged({kMap, 1}), IsEmpty());
  EXPECT_THAT(pending.Sent(kMap, 1, 10), ElementsAre(10));
}

TEST(PendingBatchesTest, WhatIsSentAgainIsNotedAnew) {
  PendingBatches<int> pending;
  EXPECT_THAT(pending.Sent(kMap, 1, 10), IsEmpty());
  EXPECT_THAT(pending.Sent(kMap, 1, 11), IsEmpty());
  EXPECT_THAT(pending.Acknowledged({kMap, 1}), ElementsAre(11));
}

}  // namespace
}  // namespace corbslam::services
