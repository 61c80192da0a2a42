// Runs every call of docs/grpcurl.md and tests/docs/grpcurl_answers.md as it is written, by a
// client that knows no proto, against a store, a worker and two robots that were started as the
// first page says, and compares what they answer with what the pages say. With
// CORBSLAM_GRPCURL_ANSWERS=FILE it also writes the answers there, for the pages.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <regex>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/str_split.h"
#include "absl/time/clock.h"
#include "services/client/reflection/generic_client.h"
#include "services/client/remote/channel.h"
#include "tests/integration/grpcurl_page.h"
#include "tests/integration/mission_fixture.h"

namespace corbslam::tests {

using services::ChildProcess;
using services::GenericCallOptions;
using services::GenericClient;
using services::MakeChannel;

namespace {

using ::testing::HasSubstr;

// Starts a robot on a part of the demo's sequence; `seed` decides the ids of its local maps.
std::unique_ptr<ChildProcess> StartRobot(const std::string& name, const std::string& frames,
                                         const std::string& seed, const std::string& store,
                                         std::vector<std::string> more) {
  std::vector<std::string> command = {absl::StrCat(CORBSLAM_PROGRAMS_DIR, "/client_agent"),
                                      "--insecure",
                                      "--source",
                                      absl::StrCat(DemoSource(), "?frames=", frames),
                                      "--server",
                                      store,
                                      "--mission",
                                      "lab",
                                      "--agent",
                                      name,
                                      "--seed",
                                      seed};
  command.insert(command.end(), more.begin(), more.end());
  auto robot = ChildProcess::Start(
      name, command, absl::StrCat(::testing::TempDir(), "/corbslam_grpcurl_", name, ".log"));
  EXPECT_TRUE(robot.ok()) << robot.status();
  return robot.ok() ? *std::move(robot) : nullptr;
}

class GrpcurlTest : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_FALSE(servers_.store_address().empty());
    alpha_ = StartRobot("alpha", "0:85", "1", servers_.store_address(),
                        {"--stay", "--pace", "sensor", "--listen", "127.0.0.1:0"});
    ASSERT_NE(alpha_, nullptr);
    const auto address = alpha_->WaitForAddress(absl::Seconds(60));
    ASSERT_TRUE(address.ok()) << address.status();
    alpha_address_ = *address;
    bravo_ = StartRobot("bravo", "46:131", "2", servers_.store_address(), {});
    ASSERT_NE(bravo_, nullptr);
    ASSERT_TRUE(bravo_->WaitForEnd(absl::Minutes(8)));
    ASSERT_TRUE(alpha_->WaitUntilFinished(absl::Minutes(8)));
    WaitUntilFused();
  }

  void WaitUntilFused() {
    GenericClient client(ChannelTo("localhost:50051"));
    for (int i = 0; i < 600; ++i) {
      const auto mission =
          client.Call("corbslam.v1.MapStore/GetMission", R"({"name": "missions/lab"})");
      ASSERT_TRUE(mission.ok()) << mission.status();
      if (nlohmann::json::parse((*mission)[0])["fusionIdle"] == true) return;
      absl::SleepFor(absl::Milliseconds(200));
    }
    FAIL() << "fusion is not idle";
  }

  // The page's addresses are examples.
  std::shared_ptr<grpc::Channel> ChannelTo(const std::string& address) {
    return MakeChannel(address == "localhost:50061" ? alpha_address_ : servers_.store_address(),
                       grpc::InsecureChannelCredentials());
  }

  // Overlaps are numbered in the order of their verification, which differs from run to run.
  std::string WithRealOverlap(const std::string& request) {
    if (!absl::StrContains(request, "/overlaps/")) return request;
    GenericClient client(ChannelTo("localhost:50051"));
    const auto overlaps = client.Call("corbslam.v1.MapStore/ListOverlaps",
                                      R"({"parent": "missions/lab", "acceptedOnly": true})");
    EXPECT_TRUE(overlaps.ok()) << overlaps.status();
    const auto json = nlohmann::json::parse(overlaps.ok() ? (*overlaps)[0] : "{}");
    EXPECT_FALSE(json["overlaps"].empty()) << "the two robots' maps were not fused";
    if (json["overlaps"].empty()) return request;
    return std::regex_replace(request, std::regex("missions/lab/overlaps/[0-9]+"),
                              json["overlaps"][0]["name"].get<std::string>());
  }

  void CheckList(const GrpcurlCall& call) {
    GenericClient client(ChannelTo(call.address));
    auto names = call.target.empty() ? client.ListServices() : client.ListMethods(call.target);
    ASSERT_TRUE(names.ok()) << names.status();
    if (!call.target.empty()) {
      for (std::string& name : *names) name = absl::StrCat(call.target, ".", name);
    }
    std::sort(names->begin(), names->end());
    const std::vector<std::string> written = absl::StrSplit(call.answer, '\n', absl::SkipEmpty());
    EXPECT_EQ(*names, written);
  }

  // For whoever writes the page.
  static void KeepAnswers(const GrpcurlCall& call, const std::vector<std::string>& answers) {
    const char* path = std::getenv("CORBSLAM_GRPCURL_ANSWERS");
    if (path == nullptr) return;
    std::ofstream file(path, std::ios::app);
    file << call.line << '\n';
    for (const std::string& answer : answers) {
      file << nlohmann::ordered_json::parse(answer).dump(2) << '\n';
    }
  }

  void CheckCall(const GrpcurlCall& call) {
    GenericClient client(ChannelTo(call.address));
    GenericCallOptions options;
    if (call.max_time_s > 0) {
      options.max_time = absl::Seconds(call.max_time_s);
      options.may_be_cut = true;
    }
    const auto answers = client.Call(call.target, WithRealOverlap(call.request), options);
    if (absl::StartsWith(call.answer, "ERROR:")) {
      CheckError(call, answers.status());
      return;
    }
    ASSERT_TRUE(answers.ok()) << answers.status();
    KeepAnswers(call, *answers);
    const auto written = ParseDocuments(call.answer);
    ASSERT_TRUE(written.ok()) << written.status();
    ASSERT_FALSE(written->empty()) << call.answer;
    std::vector<nlohmann::json> documents;
    for (const std::string& answer : *answers) documents.push_back(nlohmann::json::parse(answer));
    ASSERT_FALSE(documents.empty()) << "no answer";
    const std::set<std::string> live = FieldPaths(documents);
    const std::set<std::string> shown = FieldPaths(*written);
    for (const std::string& path : shown) {
      EXPECT_TRUE(live.contains(path)) << "the page shows " << path << ", which is not answered:\n"
                                       << (*answers)[0].substr(0, 2000);
    }
    // An answer has few fields on top: all that are not default are shown.
    for (const auto& [name, value] : documents[0].items()) {
      const bool is_unspecified =
          value.is_string() && absl::EndsWith(value.get<std::string>(), "_UNSPECIFIED");
      const bool is_default = value.empty() || value == 0 || value == false || value == "0" ||
                              value == "" || is_unspecified;
      // Whether there is a next page depends on how much was found, what the store has let go of on
      // how much the robots' maps are alike, and dropped frames on how busy the machine is.
      const bool may_come = is_default || name == "nextPageToken" || name == "retiredKeyframes" ||
                            name == "fadedMapPoints" || name == "dropped";
      EXPECT_TRUE(may_come || shown.contains(name)) << "the page does not show " << name;
    }
  }

  // Parses "ERROR:
  //   Code: NotFound
  //   Message: ...".
  void CheckError(const GrpcurlCall& call, const absl::Status& status) {
    // "NOT_FOUND" here is "NotFound" there.
    const std::string code =
        absl::StrReplaceAll(absl::StatusCodeToString(status.code()), {{"_", ""}});
    EXPECT_THAT(absl::AsciiStrToLower(call.answer),
                HasSubstr(absl::StrCat("code: ", absl::AsciiStrToLower(code), "\n")))
        << status;
    EXPECT_THAT(call.answer, HasSubstr(std::string(status.message())));
  }

  RunningServers servers_;
  std::unique_ptr<ChildProcess> alpha_;
  std::unique_ptr<ChildProcess> bravo_;
  std::string alpha_address_;
};

TEST_F(GrpcurlTest, ThePagesSayWhatIsAnswered) {
  const std::string root = CORBSLAM_SOURCE_DIR;
  const auto calls = ReadGrpcurlCalls(absl::StrCat(
      ReadText(root + "/docs/grpcurl.md"), ReadText(root + "/tests/docs/grpcurl_answers.md")));
  ASSERT_TRUE(calls.ok()) << calls.status();
  EXPECT_GE(calls->size(), 20u);
  for (const GrpcurlCall& call : *calls) {
    SCOPED_TRACE(call.line);
    if (call.is_list) {
      CheckList(call);
    } else {
      CheckCall(call);
    }
  }
}

TEST(GrpcurlPageTest, ReadsCallsAndAnswers) {
  const auto calls = ReadGrpcurlCalls(
      "text\n```\ngrpcurl -plaintext -max-time 2 -d '{\"a b\": 1}' h:1 p.S/M\n```\nmore\n"
      "```\n{\n  \"x\": [\n    {\"y\": 1}\n  ]\n}\n```\n```\nls\n```\n"
      "```\ngrpcurl -plaintext h:1 list p.S\n```\n```\np.S.M\n```\n");
  ASSERT_TRUE(calls.ok()) << calls.status();
  ASSERT_EQ(calls->size(), 2u);
  EXPECT_EQ((*calls)[0].request, "{\"a b\": 1}");
  EXPECT_EQ((*calls)[0].address, "h:1");
  EXPECT_EQ((*calls)[0].target, "p.S/M");
  EXPECT_EQ((*calls)[0].max_time_s, 2);
  EXPECT_EQ(FieldPaths(*ParseDocuments((*calls)[0].answer)), (std::set<std::string>{"x", "x[].y"}));
  EXPECT_TRUE((*calls)[1].is_list);
  EXPECT_EQ((*calls)[1].answer, "p.S.M\n");
  EXPECT_FALSE(ReadGrpcurlCalls("```\ngrpcurl -plaintext h:1 p.S/M\n```\n").ok());
}

}  // namespace
}  // namespace corbslam::tests
