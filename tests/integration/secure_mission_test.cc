// Tests a small mission by the real programs, each with a certificate of its own, and what happens
// to those without.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <memory>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "services/client/reflection/generic_client.h"
#include "services/client/remote/channel.h"
#include "services/client/store/store_reader.h"
#include "services/runtime/child_process.h"
#include "services/security/testing/test_certificates.h"
#include "tests/integration/mission_fixture.h"

namespace corbslam::tests {

using services::ChildProcess;
using services::GenericClient;
using services::MakeChannel;
using services::MakeChannelCredentials;
using services::ServedMap;
using services::StoreReader;

namespace {

using test_data::TestCertificates;
using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr absl::Duration kStart = absl::Seconds(60);
constexpr absl::Duration kEnd = absl::Seconds(240);
// A program that is asked to stop has this long: its drain, and a busy machine.
constexpr absl::Duration kStop = absl::Seconds(30);

class SecureMissionTest : public ::testing::Test {
 protected:
  std::unique_ptr<ChildProcess> Start(const std::string& name, const std::string& program,
                                      std::vector<std::string> arguments,
                                      const std::vector<std::string>& more = {}) {
    arguments.insert(arguments.begin(), absl::StrCat(CORBSLAM_PROGRAMS_DIR, "/", program));
    arguments.insert(arguments.end(), more.begin(), more.end());
    auto process = ChildProcess::Start(name, arguments, Log(name));
    EXPECT_TRUE(process.ok()) << process.status();
    return process.ok() ? *std::move(process) : nullptr;
  }
  std::string Log(const std::string& name) const { return certificates_.Path(name + ".log"); }

  // Starts a worker and a store; sets the store's address.
  void StartServers() {
    worker_ = Start("worker", "fusion_worker", {"--listen", "127.0.0.1:0"},
                    certificates_.Flags("worker"));
    ASSERT_NE(worker_, nullptr);
    const auto worker = worker_->WaitForAddress(kStart);
    ASSERT_TRUE(worker.ok()) << worker.status();
    store_ = Start("store", "map_store",
                   {"--listen", "127.0.0.1:0", "--worker", *worker, "--token-key",
                    certificates_.Path("token.pub")},
                   certificates_.Flags("store"));
    ASSERT_NE(store_, nullptr);
    const auto store = store_->WaitForAddress(kStart);
    ASSERT_TRUE(store.ok()) << store.status();
    address_ = *store;
  }

  std::unique_ptr<ChildProcess> StartAgent(const std::string& agent, const std::string& frames,
                                           const std::vector<std::string>& identity) {
    return Start(agent, "client_agent",
                 {"--source", DemoSource(), "--frames", frames, "--server", address_, "--mission",
                  "lab", "--agent", agent},
                 identity);
  }

  // Expects the exit code, and returns what the program said.
  std::string Complaint(ChildProcess& process, int exit_code = 1) {
    EXPECT_TRUE(process.WaitForEnd(kEnd)) << process.name() << " still runs";
    EXPECT_EQ(process.Stop(absl::ZeroDuration()).exit_code, exit_code) << process.name();
    return std::string(process.EndStatus().message());
  }

  static void ExpectStopsInOrder(ChildProcess& process) {
    const absl::Time start = absl::Now();
    EXPECT_EQ(process.Stop(kStop).exit_code, 0) << process.name();
    EXPECT_LT(absl::Now() - start, kStop);
  }

  const TestCertificates certificates_{"lab"};
  std::unique_ptr<ChildProcess> worker_;
  std::unique_ptr<ChildProcess> store_;
  std::string address_;
};

TEST_F(SecureMissionTest, TwoRobotsMakeOneMapOverMutualTls) {
  ASSERT_NO_FATAL_FAILURE(StartServers());
  const auto alpha = StartAgent("alpha", "0:60", certificates_.Flags("alpha"));
  // The robot has a token instead of a certificate.
  const std::string token = certificates_.Path("bravo.token");
  RunTool({"token", "--key", certificates_.Path("token.key"), "--mission", "lab", "--role", "agent",
           "--agent", "bravo", "--lifetime", "1h", "--out", token});
  const auto bravo = StartAgent("bravo", "40:100",
                                {"--tls-ca", certificates_.Path("ca.pem"), "--token-file", token});
  for (const auto* agent : {&alpha, &bravo}) {
    ASSERT_NE(*agent, nullptr);
    ASSERT_TRUE((*agent)->WaitForEnd(kEnd)) << (*agent)->name() << " still runs";
    EXPECT_TRUE((*agent)->EndStatus().ok()) << (*agent)->EndStatus();
  }

  const auto credentials = MakeChannelCredentials(certificates_.Options("viewer"));
  ASSERT_TRUE(credentials.ok()) << credentials.status();
  StoreReader reader(MakeChannel(address_, *credentials), "lab");
  ASSERT_TRUE(reader.WaitUntilFused(absl::Minutes(3)).ok());
  const auto map = reader.ReadGlobalMap();
  ASSERT_TRUE(map.ok()) << map.status();
  std::map<std::string, int> keyframes;
  for (const ServedMap::Keyframe& keyframe : map->keyframes) ++keyframes[keyframe.agent];
  EXPECT_GT(keyframes["alpha"], 0);
  // It is in alpha's frame: the worker had its say over TLS, too.
  EXPECT_GT(keyframes["bravo"], 0);

  const std::string picture = certificates_.Path("map.png");
  std::vector<std::string> render = {"render", "--server", address_, "--mission",
                                     "lab",    "--out",    picture};
  const std::vector<std::string> viewer = certificates_.Flags("viewer");
  render.insert(render.end(), viewer.begin(), viewer.end());
  RunTool(render);
  EXPECT_GT(std::filesystem::file_size(picture), 1000u);

  ExpectStopsInOrder(*store_);
  ExpectStopsInOrder(*worker_);
}

TEST_F(SecureMissionTest, AnAgentUnderAnotherNameGivesUpAndSaysWhy) {
  ASSERT_NO_FATAL_FAILURE(StartServers());
  const auto impostor = StartAgent("bravo", "0:10", certificates_.Flags("alpha"));
  ASSERT_NE(impostor, nullptr);
  EXPECT_THAT(Complaint(*impostor),
              AllOf(HasSubstr("PERMISSION_DENIED"),
                    HasSubstr("missions/lab/agents/alpha may not upload to missions/lab as agent "
                              "bravo")));
  const auto credentials = MakeChannelCredentials(certificates_.Options("operator"));
  ASSERT_TRUE(credentials.ok()) << credentials.status();
  const auto missions = GenericClient(MakeChannel(address_, *credentials))
                            .Call("corbslam.v1.MapStore/ListMissions", "{}");
  ASSERT_TRUE(missions.ok()) << missions.status();
  EXPECT_THAT((*missions)[0], ::testing::Not(HasSubstr("missions/lab")));
}

TEST_F(SecureMissionTest, WithoutCertificatesNothingStartsUnlessToldTo) {
  struct {
    std::string program;
    std::vector<std::string> arguments;
    std::string complaint;
  } const cases[] = {
      {"fusion_worker", {"--listen", "127.0.0.1:0"}, "a server needs --tls-cert and --tls-key"},
      {"map_store", {"--listen", "127.0.0.1:0"}, "a server needs --tls-cert and --tls-key"},
      {"client_agent",
       {"--source", DemoSource(), "--listen", "127.0.0.1:0"},
       "a server needs --tls-cert and --tls-key"},
      {"client_agent",
       {"--source", DemoSource(), "--server", "127.0.0.1:1"},
       "a client needs --tls-ca"},
      {"corbslam", {"render", "--server", "127.0.0.1:1"}, "a client needs --tls-ca"},
      {"corbslam",
       {"run", "--source", DemoSource(), "--server", "127.0.0.1:1"},
       "a client needs --tls-ca"},
      {"ask", {"127.0.0.1:1"}, "a client needs --tls-ca"},
  };
  for (const auto& [program, arguments, complaint] : cases) {
    const auto process = Start(program, program, arguments);
    ASSERT_NE(process, nullptr);
    const bool is_tool = program == "corbslam" || program == "ask";
    EXPECT_THAT(Complaint(*process, is_tool ? 1 : 2),
                AllOf(HasSubstr(complaint), HasSubstr("--insecure")))
        << program;
  }
}

TEST_F(SecureMissionTest, InsecurityIsLogged) {
  const auto worker = Start("worker", "fusion_worker", {"--listen", "127.0.0.1:0", "--insecure"});
  ASSERT_NE(worker, nullptr);
  ASSERT_TRUE(worker->WaitForAddress(kStart).ok());
  ExpectStopsInOrder(*worker);
  EXPECT_THAT(ReadText(Log("worker")), HasSubstr("--insecure: serving without TLS"));
}

}  // namespace
}  // namespace corbslam::tests
