// Tests a viewer before a map store of its own, as browsers see it.
#include "services/viewer/viewer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/time/clock.h"
#include "map_store/testing/grey_jpeg.h"
#include "map_store/testing/told_directory.h"
#include "services/client/remote/remote_uplink.h"
#include "services/convert/testing/test_data.h"
#include "services/http/browser_options.h"
#include "services/http/testing/raw_http.h"
#include "services/http/testing/web_client.h"
#include "services/map_store_service/map_store_service.h"
#include "services/programs/default_vocabulary.h"
#include "services/security/testing/token_keys.h"
#include "services/server/server.h"
#include "services/testing/uplink_notes.h"

namespace corbslam::services {
namespace {

using map_store::InMemoryJournal;
using map_store::MapStore;
using map_store::MapStoreOptions;
using nlohmann::json;
using test_data::kMap;
using test_data::kOtherMap;
using testing::Ask;
using testing::BodyOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::MakeRequest;
using testing::StatusOf;
using testing::WebSocketClient;

// A map store and a viewer before it.
class ViewerTest : public ::testing::Test {
 protected:
  void SetUp() override {
    auto vocabulary = Vocabulary::Load(DefaultVocabularyPath());
    ASSERT_TRUE(vocabulary.ok()) << vocabulary.status();
    store_ = std::make_unique<MapStore>(MapStoreOptions(), *vocabulary,
                                        std::make_unique<InMemoryJournal>(), nullptr);
    service_ = std::make_unique<MapStoreService>(store_.get());
    auto server = Server::Start("", {service_.get()});
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
    channel_ = server_->InProcessChannel();
    folder_ = std::filesystem::temp_directory_path() / absl::StrCat("viewer_test.", getpid());
    std::filesystem::create_directories(folder_);
    Write("index.html", "<p>the page");
    Write("app.js", "1");
    Write("app.js.gz", "compressed");
  }
  void TearDown() override {
    web_.reset();
    viewer_.reset();
    server_->Shutdown(absl::ZeroDuration());
    std::filesystem::remove_all(folder_);
  }

  void Write(const std::string& name, const std::string& content) const {
    std::ofstream(folder_ / name) << content;
  }
  void Start(std::shared_ptr<const AccessControl> access = nullptr,
             const ViewerOptions& options = {}) {
    viewer_ = std::make_unique<Viewer>(channel_, MissionFeeds::Robots(), std::move(access),
                                       PageFiles::Load(folder_), options);
    auto web = WebServer::Start("127.0.0.1:0", viewer_.get(), BrowserOptions());
    ASSERT_TRUE(web.ok()) << web.status();
    web_ = *std::move(web);
  }
  // Returns the access of tokens that these keys sign.
  static std::shared_ptr<const AccessControl> AccessOf(const test_data::TokenKeys& keys) {
    AccessControlOptions options;
    options.tokens = *TokenVerifier::FromPem(keys.public_pem);
    return std::make_shared<const AccessControl>(options);
  }
  static std::string TokenFor(const std::string& grant, const test_data::TokenKeys& keys) {
    return *SignToken({{*ParseGrant(grant)}, absl::Now() + absl::Hours(1)}, keys.private_pem);
  }

  void Upload(const std::string& mission, const std::string& agent, LocalMapId local_map) {
    std::mt19937 random(7);
    const auto uplink = MakeRemoteUplink(channel_);
    UplinkNotes notes;
    uplink->Open({.mission = mission, .agent = agent, .last_revision = 0, .local_maps = {}},
                 &notes);
    ASSERT_TRUE(notes.WaitForGrant().has_value());
    ASSERT_TRUE(uplink->Send(test_data::MakeBatch(random, local_map, 1)));
    ASSERT_EQ(notes.WaitForAcknowledgements(1), 1U);
    uplink->Close();
  }

  std::string Get(const std::string& target, const std::string& headers = "") const {
    return Ask(web_->address(), MakeRequest("GET", target, headers + "Connection: close\r\n"));
  }
  json GetJson(const std::string& target, const std::string& headers = "") const {
    return json::parse(BodyOf(Get(target, headers)), nullptr, false);
  }
  static std::string Bearer(const std::string& token) {
    return absl::StrCat("Authorization: Bearer ", token, "\r\n");
  }
  // Reads until `wanted` says so of a message; nullopt: none came.
  template <typename Wanted>
  static std::optional<v1::ViewerMessage> ReadUntil(WebSocketClient& client, Wanted wanted) {
    while (const auto bytes = client.Read()) {
      v1::ViewerMessage message;
      EXPECT_TRUE(message.ParseFromString(*bytes));
      if (wanted(message)) return message;
    }
    return std::nullopt;
  }
  static bool HasKeyframes(const v1::ViewerMessage& message) {
    return message.map().islands_size() > 0 && message.map().islands(0).keyframes_size() > 0;
  }

  std::filesystem::path folder_;
  std::unique_ptr<MapStore> store_;
  std::unique_ptr<MapStoreService> service_;
  std::unique_ptr<Server> server_;
  std::shared_ptr<grpc::Channel> channel_;
  std::unique_ptr<Viewer> viewer_;
  std::unique_ptr<WebServer> web_;
};

TEST_F(ViewerTest, AMissionThatAnotherStoreHasIsShownFromThere) {
  Upload("lab", "alpha", {0xa});
  testing::ToldDirectory directory;
  directory.Place("lab", "there:1");
  MapStore asked(MapStoreOptions(), *Vocabulary::Load(DefaultVocabularyPath()),
                 std::make_unique<testing::JournalOfToldDirectory>(&directory), nullptr);
  MapStoreService service(&asked);
  const auto server = Server::Start("", {&service});
  ASSERT_TRUE(server.ok()) << server.status();
  ViewerOptions options;
  options.connect =
      [this](const std::string& address) -> absl::StatusOr<std::shared_ptr<grpc::Channel>> {
    EXPECT_EQ(address, "there:1");
    return channel_;
  };
  viewer_ = std::make_unique<Viewer>((*server)->InProcessChannel(), MissionFeeds::Robots(), nullptr,
                                     PageFiles::Load(folder_), options);
  auto web = WebServer::Start("127.0.0.1:0", viewer_.get(), BrowserOptions());
  ASSERT_TRUE(web.ok()) << web.status();
  web_ = *std::move(web);
  EXPECT_EQ(GetJson("/api/missions/lab").value("name", ""), "missions/lab");
  WebSocketClient page(web_->address(), "/stream/missions/lab");
  EXPECT_TRUE(ReadUntil(page, HasKeyframes).has_value());
  web_.reset();
  viewer_.reset();
  (*server)->Shutdown(absl::ZeroDuration());
}

TEST_F(ViewerTest, TellsTheTruthOfMissionsThatHaveOne) {
  Write("truth.tum", "# comment\n1.5 1 2 3 0 0 0 1\n2.5 4 5 6 0 0 0 1\n");
  const std::string path = (folder_ / "truth.tum").string();
  ViewerOptions options;
  const auto truths = ReadTruths({absl::StrCat("m=", path)});
  ASSERT_TRUE(truths.ok()) << truths.status();
  options.truths = *truths;
  Start(nullptr, options);
  const std::string rows = BodyOf(Get("/api/missions/m/truth"));
  EXPECT_THAT(rows, ::testing::StartsWith("1.5"));
  EXPECT_EQ(std::count(rows.begin(), rows.end(), '\n'), 2);
  EXPECT_EQ(StatusOf(Get("/api/missions/other/truth")), 200);
  EXPECT_EQ(BodyOf(Get("/api/missions/other/truth")), "");
}

TEST_F(ViewerTest, RefusesTruthsThatItCantRead) {
  Write("bad.tum", "1.5 1 2 x 0 0 0 1\n");
  Write("good.tum", "1.5 1 2 3 0 0 0 1\n");
  const std::string bad = (folder_ / "bad.tum").string();
  const std::string good = (folder_ / "good.tum").string();
  for (const auto& [flags, words] : std::vector<std::pair<std::vector<std::string>, std::string>>{
           {{"m"}, "must be MISSION=FILE"},
           {{"m="}, "must be MISSION=FILE"},
           {{"no name=" + good}, "mission"},
           {{"m=" + bad}, "bad.tum"},
           {{"m=/nowhere.tum"}, "/nowhere.tum"},
           {{"m=" + good, "m=" + good}, "twice"}}) {
    const absl::Status status = ReadTruths(flags).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << status;
    EXPECT_THAT(std::string(status.message()), HasSubstr(words));
    EXPECT_THAT(std::string(status.message()), HasSubstr("--truth"));
  }
}

TEST_F(ViewerTest, ServesThePage) {
  Start();
  const std::string page = Get("/");
  EXPECT_EQ(StatusOf(page), 200);
  EXPECT_EQ(BodyOf(page), "<p>the page");
  EXPECT_THAT(page, HasSubstr("Content-Security-Policy: default-src 'self'"));
  EXPECT_THAT(Get("/app.js"), HasSubstr("Content-Type: text/javascript"));
  EXPECT_THAT(Get("/app.js", "Accept-Encoding: gzip\r\n"), HasSubstr("Content-Encoding: gzip"));
  const std::string tag = page.substr(page.find("ETag: ") + 6, 40);
  const std::string same = tag.substr(0, tag.find('\r'));
  EXPECT_EQ(StatusOf(Get("/", absl::StrCat("If-None-Match: ", same, "\r\n"))), 304);
  EXPECT_EQ(StatusOf(Get("/../../etc/passwd")), 404);
  EXPECT_EQ(StatusOf(Get("/app.js.gz")), 404);
  EXPECT_EQ(StatusOf(Get("/healthz")), 200);
  EXPECT_EQ(StatusOf(Ask(web_->address(),
                         MakeRequest("DELETE", "/api/missions/m", "Connection: close\r\n"))),
            405);
}

TEST_F(ViewerTest, SaysThatThePageWasNotBuilt) {
  std::filesystem::remove(folder_ / "index.html");
  Start();
  EXPECT_EQ(StatusOf(Get("/")), 503);
  EXPECT_THAT(BodyOf(Get("/")), HasSubstr("has no page"));
}

TEST_F(ViewerTest, AnswersAboutMissions) {
  Start();
  Upload("m", "alpha", kMap);
  EXPECT_EQ(GetJson("/api/missions")["missions"][0]["name"], "missions/m");
  EXPECT_EQ(GetJson("/api/missions/m")["keyframes"], "2");
  EXPECT_EQ(GetJson("/api/missions/m/agents")["agents"][0]["name"], "missions/m/agents/alpha");
  json maps = GetJson("/api/missions/m/localMaps");
  const std::string local_map = maps["localMaps"][0]["name"];
  EXPECT_THAT(GetJson("/api/missions/m/overlaps?pageSize=5")["overlaps"], IsEmpty());
  json keyframe = GetJson(absl::StrCat("/api/", local_map, "/keyframes/10?view=full"));
  EXPECT_FALSE(keyframe["payload"]["features"]["xPx64"].empty()) << keyframe;
  const std::string trajectory = BodyOf(Get("/api/missions/m/trajectory?frame=local"));
  EXPECT_GT(trajectory.size(), 4U);
}

TEST_F(ViewerTest, ShowsWhatAKeyframesCameraSaw) {
  const test_data::TokenKeys keys = test_data::MakeTokenKeys();
  Start(AccessOf(keys));
  const std::string with = Bearer(TokenFor("missions/m/viewers/eve", keys));
  std::mt19937 random(7);
  const auto uplink = MakeRemoteUplink(channel_);
  UplinkNotes notes;
  uplink->Open({.mission = "m", .agent = "alpha", .last_revision = 0, .local_maps = {}}, &notes);
  ASSERT_TRUE(notes.WaitForGrant().has_value());
  const MapUpdateBatch batch = test_data::MakeBatch(random, kMap, 1);
  ASSERT_TRUE(uplink->Send(batch));
  ASSERT_EQ(notes.WaitForAcknowledgements(1), 1U);
  const KeyframeId id = batch.full_keyframes[0].payload->id;
  const std::string path =
      absl::StrCat("/api/missions/m/localMaps/", ToString(kMap), "/keyframes/", id.index);
  const std::string none = Get(path + "/picture", with);
  EXPECT_EQ(StatusOf(none), 200);
  EXPECT_EQ(BodyOf(none), "");
  EXPECT_THAT(none, HasSubstr("Cache-Control: no-store"));
  const std::string jpeg = testing::MakeGreyJpeg(320, 97, 500);
  ASSERT_TRUE(uplink->SendPicture({id, jpeg, 3.875}));
  std::string picture;
  for (int i = 0; i < 500 && BodyOf(picture).empty(); ++i) {
    picture = Get(path + "/picture", with);
    absl::SleepFor(absl::Milliseconds(10));
  }
  EXPECT_EQ(BodyOf(picture), jpeg);
  for (const char* header :
       {"Content-Type: image/jpeg", "Picture-Scale: 3.875", "Cache-Control: private, max-age=600",
        "Vary: Authorization", "X-Content-Type-Options: nosniff"}) {
    EXPECT_THAT(picture, HasSubstr(header));
  }
  // It is as secret as the map.
  EXPECT_EQ(StatusOf(Get(path + "/picture")), 401);
  EXPECT_EQ(StatusOf(Get(path + "/picture", Bearer(TokenFor("missions/other/viewers/eve", keys)))),
            403);
  EXPECT_EQ(StatusOf(Get("/api/missions/m/localMaps/xyz/keyframes/0/picture", with)), 400);
  EXPECT_EQ(StatusOf(Get(path + "9999/picture", with)), 404);
  EXPECT_EQ(StatusOf(Get(path + "/pictures", with)), 404);
  EXPECT_EQ(StatusOf(Get("/api/missions/m/overlaps/1", with)), 404);
  EXPECT_EQ(StatusOf(Get("/api/missions/m/overlaps/x", with)), 400);
  EXPECT_EQ(StatusOf(Get("/api/missions/m/overlaps/1")), 401);
}

TEST_F(ViewerTest, SaysWhatIsWrongInARequest) {
  Start();
  EXPECT_EQ(StatusOf(Get("/api/missions/nobody")), 404);
  EXPECT_EQ(StatusOf(Get("/api/missions/no%20name")), 400);
  EXPECT_EQ(StatusOf(Get("/api/nothing")), 404);
  EXPECT_EQ(StatusOf(Get("/api/missions/m/localMaps/xyz/keyframes/0")), 400);
  EXPECT_EQ(StatusOf(Get("/api/missions/m/agents?pageSize=many")), 400);
  EXPECT_THAT(GetJson("/api/missions/m/agents?pageSize=many")["error"],
              HasSubstr("pageSize is \"many\""));
  EXPECT_EQ(StatusOf(Get("/api/missions/m/trajectory?frame=up")), 400);
}

TEST_F(ViewerTest, StreamsTheMapAndHowTheMissionIs) {
  Start();
  Upload("m", "alpha", kMap);
  WebSocketClient client(web_->address(), "/stream/missions/m");
  ASSERT_TRUE(client.stands());
  const auto map = ReadUntil(client, HasKeyframes);
  ASSERT_TRUE(map);
  EXPECT_EQ(map->map().local_map_agents(0), "alpha");
  const auto pulse =
      ReadUntil(client, [](const auto& message) { return message.pulse().store_answers(); });
  ASSERT_TRUE(pulse);
  EXPECT_FALSE(pulse->pulse().mission_missing());
  EXPECT_EQ(pulse->pulse().mission().name(), "missions/m");
  EXPECT_EQ(pulse->pulse().agents_size(), 1);
  EXPECT_EQ(pulse->pulse().statistics().keyframes(), 2U);
  // Another robot comes while somebody looks.
  Upload("m", "bravo", kOtherMap);
  const auto more = ReadUntil(client, HasKeyframes);
  ASSERT_TRUE(more);
  EXPECT_THAT(more->map().DebugString(), HasSubstr("bravo"));
}

TEST_F(ViewerTest, WaitsForAMissionThatIsNotThereYet) {
  Start();
  WebSocketClient client(web_->address(), "/stream/missions/later");
  const auto missing = ReadUntil(client, [](const auto& message) { return message.has_pulse(); });
  ASSERT_TRUE(missing);
  EXPECT_FALSE(missing->pulse().store_answers());
  EXPECT_TRUE(missing->pulse().mission_missing());
  EXPECT_THAT(missing->pulse().store_error(), HasSubstr("later"));
  Upload("later", "alpha", kMap);
  EXPECT_TRUE(ReadUntil(client, HasKeyframes));
}

TEST_F(ViewerTest, AMissionIsFollowedOnceForAllPages) {
  Start();
  Upload("m", "alpha", kMap);
  std::vector<std::unique_ptr<WebSocketClient>> clients;
  for (int i = 0; i < 10; ++i) {
    clients.push_back(std::make_unique<WebSocketClient>(web_->address(), "/stream/missions/m"));
    EXPECT_TRUE(ReadUntil(*clients.back(), HasKeyframes));
  }
  EXPECT_EQ(viewer_->missions(), 1U);
  EXPECT_EQ(web_->streams(), 10U);
}

TEST_F(ViewerTest, MissionsThatAreFollowedAreBounded) {
  ViewerOptions options;
  options.feeds.max_missions = 1;
  Start(nullptr, options);
  Upload("m", "alpha", kMap);
  Upload("n", "alpha", kOtherMap);
  auto first = std::make_unique<WebSocketClient>(web_->address(), "/stream/missions/m");
  EXPECT_TRUE(ReadUntil(*first, HasKeyframes));
  WebSocketClient refused(web_->address(), "/stream/missions/n");
  EXPECT_FALSE(refused.Read());
  EXPECT_EQ(refused.close_code(), 4429);
  // One that nobody looks at any more makes room.
  first.reset();
  while (web_->streams() > 0) absl::SleepFor(absl::Milliseconds(5));
  WebSocketClient next(web_->address(), "/stream/missions/n");
  EXPECT_TRUE(ReadUntil(next, HasKeyframes));
}

TEST_F(ViewerTest, ATokenOpensItsMissionsAlone) {
  const test_data::TokenKeys keys = test_data::MakeTokenKeys();
  Start(AccessOf(keys));
  Upload("m", "alpha", kMap);
  Upload("secret", "alpha", kOtherMap);
  const std::string token = TokenFor("missions/m/viewers/eve", keys);
  EXPECT_EQ(StatusOf(Get("/api/missions")), 401);
  EXPECT_EQ(StatusOf(Get("/api/missions/m")), 401);
  EXPECT_EQ(StatusOf(Get("/api/missions/m", Bearer("nonsense"))), 401);
  EXPECT_EQ(StatusOf(Get("/api/missions/m", Bearer(token))), 200);
  EXPECT_EQ(StatusOf(Get("/api/missions/secret", Bearer(token))), 403);
  const json listed = GetJson("/api/missions", Bearer(token));
  ASSERT_EQ(listed["missions"].size(), 1U);
  EXPECT_EQ(listed["missions"][0]["name"], "missions/m");
  const std::string all = TokenFor("missions/-/viewers/eve", keys);
  EXPECT_EQ(GetJson("/api/missions", Bearer(all))["missions"].size(), 2U);
  // The page itself holds no secret.
  EXPECT_EQ(StatusOf(Get("/")), 200);
}

TEST_F(ViewerTest, AStreamWantsATokenToo) {
  const test_data::TokenKeys keys = test_data::MakeTokenKeys();
  Start(AccessOf(keys));
  Upload("m", "alpha", kMap);
  WebSocketClient stranger(web_->address(), "/stream/missions/m");
  EXPECT_FALSE(stranger.Read());
  EXPECT_EQ(stranger.close_code(), 4401);
  const std::string token = TokenFor("missions/m/viewers/eve", keys);
  const testing::SocketOptions with{.protocols = absl::StrCat("corbslam, token.", token)};
  WebSocketClient other(web_->address(), "/stream/missions/n", with);
  EXPECT_FALSE(other.Read());
  EXPECT_EQ(other.close_code(), 4403);
  WebSocketClient viewer(web_->address(), "/stream/missions/m", with);
  EXPECT_TRUE(ReadUntil(viewer, HasKeyframes));
}

}  // namespace
}  // namespace corbslam::services
