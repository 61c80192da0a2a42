// Tests keyframes' pictures and overlaps' matches through the real stubs: from a robot's uplink to
// who looks.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <random>
#include <string>

#include "absl/time/clock.h"
#include "map_store/testing/byte_journal.h"
#include "map_store/testing/grey_jpeg.h"
#include "map_store/testing/small_mission.h"
#include "services/client/remote/remote_uplink.h"
#include "services/convert/testing/test_data.h"
#include "services/map_store_service/map_store_service.h"
#include "services/programs/default_vocabulary.h"
#include "services/server/server.h"
#include "services/testing/uplink_notes.h"

namespace corbslam::services {

using map_store::InMemoryJournal;
using map_store::Journal;
using map_store::MapStore;
using map_store::MapStoreOptions;

namespace {

using test_data::kMap;
using test_data::kOtherMap;
using test_data::MakeBatch;
using ::testing::HasSubstr;
using testing::MakeGreyJpeg;

class PicturesServiceTest : public ::testing::Test {
 protected:
  void Start(std::unique_ptr<Journal> journal, const MapStoreOptions& options = {}) {
    auto vocabulary = Vocabulary::Load(DefaultVocabularyPath());
    ASSERT_TRUE(vocabulary.ok()) << vocabulary.status();
    store_ = std::make_unique<MapStore>(options, *vocabulary, std::move(journal), nullptr);
    ASSERT_TRUE(store_->Recover().ok());
    service_ = std::make_unique<MapStoreService>(store_.get());
    auto server = Server::Start("", {service_.get()});
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
    stub_ = v1::MapStore::NewStub(server_->InProcessChannel());
  }
  void TearDown() override { server_->Shutdown(absl::ZeroDuration()); }

  void Open(const std::string& agent) {
    uplink_ = MakeRemoteUplink(server_->InProcessChannel());
    notes_ = std::make_unique<UplinkNotes>();
    uplink_->Open({.mission = "m", .agent = agent, .last_revision = 0, .local_maps = {}},
                  notes_.get());
    const auto grant = notes_->WaitForGrant();
    ASSERT_TRUE(grant.has_value());
    takes_pictures_ = grant->capabilities.keyframe_pictures;
  }
  KeyframeId SendBatch(LocalMapId local_map) {
    std::mt19937 random(7);
    const MapUpdateBatch batch = MakeBatch(random, local_map, 1);
    EXPECT_TRUE(uplink_->Send(batch));
    EXPECT_EQ(notes_->WaitForAcknowledgements(1), 1u);
    return batch.full_keyframes[0].payload->id;
  }
  grpc::Status Get(KeyframeId id, v1::KeyframeView view, v1::Keyframe* keyframe) {
    grpc::ClientContext context;
    v1::GetKeyframeRequest request;
    request.set_name("missions/m/localMaps/" + ToString(id.local_map) + "/keyframes/" +
                     std::to_string(id.index));
    request.set_view(view);
    return stub_->GetKeyframe(&context, request, keyframe);
  }
  // Waits, as nobody answers a picture.
  std::string WaitForPicture(KeyframeId id) {
    v1::Keyframe keyframe;
    for (int i = 0; i < 500 && keyframe.picture().empty(); ++i) {
      EXPECT_TRUE(Get(id, v1::KEYFRAME_VIEW_PICTURE, &keyframe).ok());
      absl::SleepFor(absl::Milliseconds(10));
    }
    scale_ = keyframe.picture_scale();
    return keyframe.picture();
  }

  bool takes_pictures_ = false;
  double scale_ = 0;
  std::unique_ptr<MapStore> store_;
  std::unique_ptr<MapStoreService> service_;
  std::unique_ptr<Server> server_;
  std::unique_ptr<v1::MapStore::Stub> stub_;
  std::unique_ptr<UplinkNotes> notes_;
  std::unique_ptr<Uplink> uplink_;
};

TEST_F(PicturesServiceTest, WhatARobotSendsIsThereForWhoAsks) {
  Start(std::make_unique<InMemoryJournal>());
  Open("alpha");
  EXPECT_TRUE(takes_pictures_);
  const KeyframeId id = SendBatch(kMap);
  v1::Keyframe keyframe;
  ASSERT_TRUE(Get(id, v1::KEYFRAME_VIEW_PICTURE, &keyframe).ok());
  EXPECT_TRUE(keyframe.picture().empty());
  EXPECT_EQ(keyframe.picture_scale(), 0);
  const std::string jpeg = MakeGreyJpeg(320, 97, 7000);
  const uint64_t before = uplink_->bytes_up();
  ASSERT_TRUE(uplink_->SendPicture({id, jpeg, 3.878125}));
  EXPECT_EQ(WaitForPicture(id), jpeg);
  EXPECT_EQ(scale_, 3.878125);
  EXPECT_GT(uplink_->bytes_up(), before + 7000);
  // Other views have none, and this one no payload.
  ASSERT_TRUE(Get(id, v1::KEYFRAME_VIEW_FULL, &keyframe).ok());
  EXPECT_TRUE(keyframe.picture().empty());
  EXPECT_TRUE(keyframe.has_payload());
  ASSERT_TRUE(Get(id, v1::KEYFRAME_VIEW_PICTURE, &keyframe).ok());
  EXPECT_FALSE(keyframe.has_payload());
  EXPECT_GT(keyframe.keypoints(), 0u);
  EXPECT_FALSE(notes_->IsClosed());
  EXPECT_EQ(Get({kMap, 9999}, v1::KEYFRAME_VIEW_PICTURE, &keyframe).error_code(),
            grpc::StatusCode::NOT_FOUND);
}

TEST_F(PicturesServiceTest, AnUnknownViewIsRefusedWithThoseThereAre) {
  Start(std::make_unique<InMemoryJournal>());
  v1::Keyframe keyframe;
  const grpc::Status status = Get({kMap, 1}, static_cast<v1::KeyframeView>(4), &keyframe);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_THAT(status.error_message(), HasSubstr("must be 0 to 3"));
}

TEST_F(PicturesServiceTest, HostilePicturesEndTheSessionWithTheReason) {
  Start(std::make_unique<InMemoryJournal>());
  Open("alpha");
  const KeyframeId id = SendBatch(kMap);
  ASSERT_TRUE(uplink_->SendPicture({id, "<script>", 2}));
  const absl::Status closed = notes_->WaitForClose();
  EXPECT_TRUE(absl::IsInvalidArgument(closed)) << closed;
  EXPECT_THAT(std::string(closed.message()), HasSubstr("no grey JPEG"));
  // The next session goes on, and another robot's keyframe is not its own.
  Open("mallory");
  SendBatch(kOtherMap);
  ASSERT_TRUE(uplink_->SendPicture({id, MakeGreyJpeg(320, 97, 70), 2}));
  const absl::Status refused = notes_->WaitForClose();
  EXPECT_TRUE(absl::IsPermissionDenied(refused)) << refused;
  v1::Keyframe keyframe;
  ASSERT_TRUE(Get(id, v1::KEYFRAME_VIEW_PICTURE, &keyframe).ok());
  EXPECT_TRUE(keyframe.picture().empty());
}

TEST_F(PicturesServiceTest, AStoreThatKeepsNoneSaysSo) {
  Start(std::make_unique<InMemoryJournal>(), {.max_picture_bytes_per_mission = 0});
  Open("alpha");
  EXPECT_FALSE(takes_pictures_);
}

TEST_F(PicturesServiceTest, AFusedPairsKeypointsThatSeeOneLandmarkAreMatches) {
  auto bytes = std::make_shared<testing::JournalBytes>();
  testing::ByteJournal journal(bytes);
  for (const auto& record : testing::MakeSmallMission()) {
    ASSERT_TRUE(journal.Append("m", record).ok());
  }
  Start(std::make_unique<testing::ByteJournal>(bytes));
  grpc::ClientContext context;
  v1::GetOverlapRequest request;
  request.set_name("missions/m/overlaps/1");
  v1::Overlap overlap;
  const grpc::Status status = stub_->GetOverlap(&context, request, &overlap);
  ASSERT_TRUE(status.ok()) << status.error_message();
  EXPECT_EQ(overlap.name(), "missions/m/overlaps/1");
  EXPECT_EQ(overlap.verdict(), v1::OVERLAP_VERDICT_ACCEPTED);
  EXPECT_GE(overlap.matches_size(), 1);
}

TEST_F(PicturesServiceTest, WhatIsNoOverlapIsSaidSo) {
  Start(std::make_unique<InMemoryJournal>());
  Open("alpha");
  for (const auto& [name, code] : {std::pair("missions/m/overlaps/7", grpc::StatusCode::NOT_FOUND),
                                   {"missions/nobody/overlaps/7", grpc::StatusCode::NOT_FOUND},
                                   {"missions/m/overlaps/x", grpc::StatusCode::INVALID_ARGUMENT},
                                   {"missions/m", grpc::StatusCode::INVALID_ARGUMENT},
                                   {"", grpc::StatusCode::INVALID_ARGUMENT}}) {
    grpc::ClientContext context;
    v1::GetOverlapRequest request;
    request.set_name(name);
    v1::Overlap overlap;
    EXPECT_EQ(stub_->GetOverlap(&context, request, &overlap).error_code(), code) << name;
  }
}

}  // namespace
}  // namespace corbslam::services
