#include "services/client/store/store_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <random>
#include <utility>

#include "absl/time/clock.h"
#include "map_store/map_store.h"
#include "services/convert/testing/test_data.h"
#include "services/map_store_service/map_store_service.h"
#include "services/programs/default_vocabulary.h"
#include "services/server/server.h"

namespace corbslam::services {

using map_store::InMemoryJournal;
using map_store::MapStore;
using map_store::MapStoreOptions;

namespace {

using ::testing::HasSubstr;

// Nobody listens on port 1: it is reserved for tcpmux, which nobody runs.
constexpr char kNobody[] = "127.0.0.1:1";

class StoreReaderTest : public ::testing::Test {
 protected:
  void SetUp() override {
    auto vocabulary = Vocabulary::Load(DefaultVocabularyPath());
    ASSERT_TRUE(vocabulary.ok()) << vocabulary.status();
    store_ = std::make_unique<MapStore>(MapStoreOptions(), *vocabulary,
                                        std::make_unique<InMemoryJournal>(), nullptr);
    service_ = std::make_unique<MapStoreService>(store_.get());
    auto server = Server::Start("127.0.0.1:0", {service_.get()});
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
  }

  std::unique_ptr<MapStore> store_;
  std::unique_ptr<MapStoreService> service_;
  std::unique_ptr<Server> server_;
};

TEST(ConnectToStoreTest, SaysSoonThatNobodyAnswers) {
  const absl::Time start = absl::Now();
  const absl::Status status =
      ConnectToStore(kNobody, WithoutTls(), absl::Milliseconds(500)).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(std::string(status.message()), HasSubstr(kNobody));
  EXPECT_LT(absl::Now() - start, absl::Seconds(20));
}

TEST_F(StoreReaderTest, ReadsTheGlobalMap) {
  std::mt19937 random(7);
  SessionRequest request;
  request.mission = "m";
  request.agent = "alpha";
  const auto session = store_->OpenSession(request);
  ASSERT_TRUE(session.ok()) << session.status();
  const auto channel = ConnectToStore(server_->address(), WithoutTls());
  ASSERT_TRUE(channel.ok()) << channel.status();
  StoreReader reader(*channel, "m");
  ASSERT_TRUE(
      store_->Apply(session->session_id, test_data::MakeBatch(random, test_data::kMap, 1)).ok());
  const absl::StatusOr<ServedMap> map = reader.ReadGlobalMap();
  ASSERT_TRUE(map.ok()) << map.status();
  ASSERT_EQ(map->keyframes.size(), 2u);
  EXPECT_EQ(map->keyframes[0].agent, "alpha");
}

TEST_F(StoreReaderTest, HandsOnThatThereIsNoSuchMission) {
  const auto channel = ConnectToStore(server_->address(), WithoutTls());
  ASSERT_TRUE(channel.ok()) << channel.status();
  StoreReader reader(*channel, "nowhere");
  for (const absl::Status& status :
       {reader.ReadGlobalMap().status(), reader.Statistics().status()}) {
    EXPECT_EQ(status.code(), absl::StatusCode::kNotFound) << status;
    EXPECT_THAT(std::string(status.message()), HasSubstr("there is no mission nowhere"));
  }
}

}  // namespace
}  // namespace corbslam::services
