#include <gmock/gmock.h>
#include <grpcpp/server_builder.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "fusion_worker/local_fusion_worker.h"
#include "services/fusion_worker_service/fusion_worker_service.h"
#include "services/programs/default_vocabulary.h"
#include "services/security/finding.h"
#include "services/security/testing/test_certificates.h"
#include "services/simulated_source/simulated_source.h"
#include "services/testing/test_path.h"
#include "services/tool/doctor/fusion_check.h"
#include "services/tool/doctor/local_checks.h"
#include "services/tool/doctor/server_checks.h"

namespace corbslam::services {

using fusion_worker::MakeLocalFusionWorker;

namespace {

[[maybe_unused]] const bool registered = RegisterSimulatedSources();

namespace fs = std::filesystem;
using test_data::TestCertificates;
using ::testing::HasSubstr;

// Nobody listens on port 1: it is reserved for tcpmux, which nobody runs.
constexpr char kNobody[] = "127.0.0.1:1";
constexpr char kWorker[] = "corbslam.v1.FusionWorker";

Level LevelOf(const Findings& findings, const std::string& text) {
  for (const Finding& finding : findings) {
    if (finding.text.find(text) != std::string::npos) return finding.level;
  }
  ADD_FAILURE() << "nothing of \"" << text << "\" in\n" << FormatFindings(findings);
  return Level::kOk;
}

TEST(DoctorTest, FormatsALineEachAndAdvice) {
  const Findings findings = {{Level::kOk, "clock", "ticks", ""},
                             {Level::kFail, "source", "is gone", "look for it"}};
  EXPECT_EQ(FormatFindings(findings),
            "ok    clock         ticks\n"
            "fail  source        is gone\n"
            "                    look for it\n");
  EXPECT_EQ(ToJson(findings)[1]["level"], "fail");
  EXPECT_EQ(ToJson(findings)[1]["advice"], "look for it");
  EXPECT_TRUE(AnyFailed(findings));
  EXPECT_FALSE(AnyFailed({findings[0]}));
}

TEST(DoctorTest, NoticesAClockOfThePast) {
  EXPECT_FALSE(AnyFailed(CheckClock(absl::Now())));
  EXPECT_EQ(LevelOf(CheckClock(absl::FromCivil(absl::CivilDay(1970, 1, 2), absl::UTCTimeZone())),
                    "before this program"),
            Level::kFail);
}

TEST(DoctorTest, ReadsVocabularies) {
  EXPECT_EQ(CheckVocabularyFile(DefaultVocabularyPath()).level, Level::kOk);
  EXPECT_EQ(CheckVocabularyFile("/nowhere.voc").level, Level::kFail);
}

TEST(DoctorTest, LooksIntoDataFolders) {
  const fs::path folder = TestPath("folder");
  fs::remove_all(folder);
  fs::create_directories(folder);
  EXPECT_FALSE(AnyFailed(CheckDataFolder(folder / "new/deep")));
  EXPECT_TRUE(fs::is_empty(folder));
  std::ofstream(folder / "file") << "x";
  EXPECT_TRUE(AnyFailed(CheckDataFolder(folder / "file")));
  // Nobody can make a file in /proc, not even root.
  EXPECT_TRUE(AnyFailed(CheckDataFolder("/proc")));
}

TEST(DoctorTest, ReadsSources) {
  EXPECT_FALSE(AnyFailed(CheckSource("sim:city?length=40", true)));
  EXPECT_TRUE(AnyFailed(CheckSource("tum:/nowhere", false)));
  EXPECT_TRUE(AnyFailed(CheckSource("nonsense", false)));
}

class ServerChecksTest : public ::testing::Test {
 protected:
  // Starts a worker that computes nothing: the checks ask only for what all servers share.
  void Start(const SecurityOptions& options) {
    auto security = MakeServerSecurity(options);
    ASSERT_TRUE(security.ok()) << security.status();
    auto server = Server::Start("127.0.0.1:0", {&service_}, security->server);
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
  }
  Findings Check(const SecurityOptions& options, const std::string& service = kWorker) {
    return CheckServer("worker", server_->address(), service, options, absl::Now());
  }

  const std::unique_ptr<FusionWorker> worker_ = MakeLocalFusionWorker();
  FusionWorkerService service_{worker_.get()};
  std::unique_ptr<Server> server_;
  SecurityOptions insecure_ = [] {
    SecurityOptions options;
    options.insecure = true;
    return options;
  }();
};

TEST_F(ServerChecksTest, PraisesAGoodOne) {
  const TestCertificates certificates("lab");
  Start(certificates.Options("worker"));
  const Findings findings = Check(certificates.Options("store"));
  for (const Finding& finding : findings) EXPECT_EQ(finding.level, Level::kOk) << finding.text;
  EXPECT_EQ(LevelOf(findings, "issued by an authority"), Level::kOk);
  EXPECT_EQ(LevelOf(findings, "is for 127.0.0.1"), Level::kOk);
  EXPECT_EQ(LevelOf(findings, "is ready"), Level::kOk);
  EXPECT_EQ(LevelOf(findings, "speaks the same interface"), Level::kOk);
}

TEST_F(ServerChecksTest, SaysThatNobodyListens) {
  EXPECT_EQ(
      LevelOf(CheckServer("store", kNobody, kWorker, insecure_, absl::Now()), "Connection refused"),
      Level::kFail);
  EXPECT_TRUE(
      AnyFailed(CheckServer("store", "no.such.host.invalid:1", kWorker, insecure_, absl::Now())));
}

TEST_F(ServerChecksTest, SaysThatTheServerIsNotReady) {
  Start(insecure_);
  server_->SetReady(false);
  EXPECT_EQ(LevelOf(Check(insecure_), "is not ready"), Level::kFail);
}

TEST_F(ServerChecksTest, SaysThatOneSideSpeaksNoTls) {
  const TestCertificates certificates("lab");
  Start(insecure_);
  EXPECT_EQ(LevelOf(Check(certificates.Options("store")), "speaks no TLS"), Level::kFail);
}

TEST_F(ServerChecksTest, SaysWhoseAuthorityIsAnother) {
  const TestCertificates certificates("lab");
  const TestCertificates others("lab");
  Start(certificates.Options("worker"));
  EXPECT_EQ(LevelOf(Check(others.Options("store")), "does not lead to an authority"), Level::kFail);
}

TEST_F(ServerChecksTest, NoticesAnotherService) {
  Start(insecure_);
  EXPECT_EQ(
      LevelOf(Check(insecure_, "corbslam.v1.MapStore"), "does not offer corbslam.v1.MapStore"),
      Level::kFail);
}

TEST_F(ServerChecksTest, CantCompareWithoutReflection) {
  SecurityOptions silent = insecure_;
  silent.reflection = false;
  Start(silent);
  EXPECT_EQ(LevelOf(Check(insecure_), "does not say what it offers"), Level::kWarn);
}

TEST(DoctorTest, NoticesThatNobodyFuses) {
  EXPECT_TRUE(CheckFusionOf("store", {}).empty());
  std::vector<v1::Mission> missions(2);
  EXPECT_EQ(LevelOf(CheckFusionOf("store", missions), "no request to them has failed"), Level::kOk);
  for (v1::Mission& mission : missions) {
    mission.set_waiting_queries(6);
    mission.set_worker_away_since_ns(1'700'000'000'000'000'000);
    mission.set_worker_error("Connection refused");
  }
  EXPECT_EQ(LevelOf(CheckFusionOf("store", missions), "look-ups waiting: 12 (Connection refused)"),
            Level::kFail);
  missions[0].set_lacks_fusion_worker(true);
  EXPECT_EQ(LevelOf(CheckFusionOf("store", missions), "never fused"), Level::kWarn);
}

TEST(DoctorTest, AsksTheMissionsThatAreNotDamagedWhetherAnybodyFuses) {
  std::vector<v1::Mission> missions(2);
  missions[0].set_damage("mission lab is damaged, and takes nothing in");
  EXPECT_TRUE(CheckFusionOf("store", {missions[0]}).empty());
  missions[1].set_waiting_queries(3);
  missions[1].set_worker_away_since_ns(1'700'000'000'000'000'000);
  EXPECT_EQ(LevelOf(CheckFusionOf("store", missions), "look-ups waiting: 3"), Level::kFail);
}

// Serves as many missions as it is told, a page at a time; the last one is damaged.
class PagedStore : public v1::MapStore::Service {
 public:
  explicit PagedStore(int missions) : missions_(missions) {}
  grpc::Status ListMissions(grpc::ServerContext* /*context*/,
                            const v1::ListMissionsRequest* request,
                            v1::ListMissionsResponse* response) override {
    int first = 0;
    if (!request->page_token().empty() && !absl::SimpleAtoi(request->page_token(), &first)) {
      return {grpc::StatusCode::INVALID_ARGUMENT, "no page"};
    }
    if (first >= fails_from) return {grpc::StatusCode::UNAVAILABLE, "the store is stopping"};
    const int end = std::min(first + 100, missions_);
    for (int i = first; i < end; ++i) {
      v1::Mission* mission = response->add_missions();
      if (i == missions_ - 1) mission->set_damage("mission last is damaged");
      if (i == missions_ - 2) mission->set_worker_away_since_ns(1'700'000'000'000'000'000);
    }
    if (end < missions_) response->set_next_page_token(absl::StrCat(end));
    return grpc::Status::OK;
  }

  int fails_from = std::numeric_limits<int>::max();

 private:
  const int missions_;
};

TEST(DoctorTest, AsksForMissionsBeyondTheFirstPage) {
  PagedStore store(250);
  grpc::ServerBuilder builder;
  builder.RegisterService(&store);
  const std::unique_ptr<grpc::Server> server = builder.BuildAndStart();
  const auto channel = server->InProcessChannel({});
  Findings findings = CheckFusion("store", channel, absl::Seconds(5));
  EXPECT_EQ(LevelOf(findings, "mission last is damaged"), Level::kFail);
  EXPECT_EQ(LevelOf(findings, "no fusion worker takes its requests"), Level::kFail);
  store.fails_from = 200;
  findings = CheckFusion("store", channel, absl::Seconds(5));
  EXPECT_EQ(
      LevelOf(findings, "does not list all of its missions (200 came): the store is stopping"),
      Level::kFail);
}

TEST(DoctorTest, NoticesDamagedMissions) {
  std::vector<v1::Mission> missions(3);
  EXPECT_TRUE(CheckDamageOf("store", missions).empty());
  missions[1].set_damage("mission lab is damaged, and takes nothing in");
  const Findings findings = CheckDamageOf("store", missions);
  EXPECT_EQ(findings.size(), 1u);
  EXPECT_EQ(LevelOf(findings, "mission lab is damaged"), Level::kFail);
}

TEST_F(ServerChecksTest, SaysWhatIsWrongWithAnAddress) {
  EXPECT_EQ(LevelOf(CheckServer("store", "http://127.0.0.1:1", kWorker, insecure_, absl::Now()),
                    "give 127.0.0.1:1"),
            Level::kFail);
}

TEST_F(ServerChecksTest, SaysThatTheOtherSideSpeaksTls) {
  const TestCertificates certificates("lab");
  Start(certificates.Options("worker"));
  EXPECT_EQ(LevelOf(Check(insecure_), "speaks TLS"), Level::kFail);
}

TEST(DoctorTest, NoticesAnotherVersion) {
  EXPECT_EQ(CompareMethods("store", {"A", "B"}, {"A", "B"}).level, Level::kOk);
  const Finding finding = CompareMethods("store", {"A", "B"}, {"B", "C"});
  EXPECT_EQ(finding.level, Level::kWarn);
  EXPECT_EQ(finding.text, "is of another version: it lacks A, this program lacks C");
}

}  // namespace
}  // namespace corbslam::services
