#include "tests/integration/observed_mission.h"

#include <filesystem>
#include <numeric>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "services/client/reflection/generic_client.h"
#include "services/client/remote/channel.h"
#include "tests/integration/mission_fixture.h"

namespace corbslam::tests {

using services::ChildProcess;
using services::GenericClient;
using services::MakeChannel;

namespace {

using nlohmann::json;

constexpr absl::Duration kPatience = absl::Minutes(5);

bool Has(const json& sample, const std::map<std::string, std::string>& labels) {
  for (const auto& [name, value] : labels) {
    if (sample["labels"].value(name, "") != value) return false;
  }
  return true;
}

// Returns the address behind this text in a log.
std::string FindAddress(const std::string& log, const std::string& text) {
  const size_t at = log.find(text);
  if (at == std::string::npos) return "";
  const size_t begin = at + text.size();
  return log.substr(begin, log.find('\n', begin) - begin);
}

}  // namespace

std::vector<double> ObservedMissionTest::Scrape::Values(
    const std::string& name, const std::map<std::string, std::string>& labels) const {
  std::vector<double> values;
  for (const auto& [family, content] : families_.items()) {
    for (const json& sample : content["samples"]) {
      if (sample["name"] == name && Has(sample, labels)) values.push_back(sample["value"]);
    }
  }
  return values;
}

double ObservedMissionTest::Scrape::Value(const std::string& name,
                                          const std::map<std::string, std::string>& labels) const {
  const std::vector<double> values = Values(name, labels);
  EXPECT_EQ(values.size(), 1u) << name << " " << json(labels);
  return values.size() == 1 ? values.front() : -1e9;
}

double ObservedMissionTest::Scrape::Sum(const std::string& name,
                                        const std::map<std::string, std::string>& labels) const {
  const std::vector<double> values = Values(name, labels);
  return std::accumulate(values.begin(), values.end(), 0.0);
}

size_t ObservedMissionTest::Scrape::Count(const std::string& name,
                                          const std::map<std::string, std::string>& labels) const {
  return Values(name, labels).size();
}

void ObservedMissionTest::SetUp() {
  const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
  folder_ = absl::StrCat(::testing::TempDir(), "/corbslam_observed_", test->name());
  std::filesystem::remove_all(folder_);
  std::filesystem::create_directories(folder_);
  Start("worker", "fusion_worker", {"--listen", "127.0.0.1:0"});
  Start("store", "map_store",
        {"--listen", "127.0.0.1:0", "--worker", AddressOf("worker"), "--data-dir",
         FileOf("missions"), "--log-format", "json"});
  store_address_ = AddressOf("store");
  ASSERT_FALSE(store_address_.empty());
  StartRobot("alpha", "0:85");
  StartRobot("bravo", "46:131");
  for (size_t i = 2; i < processes_.size(); ++i) {
    ASSERT_TRUE(processes_[i]->WaitUntilFinished(kPatience)) << ReadText(LogOf("alpha"));
    ASSERT_FALSE(processes_[i]->end().has_value()) << processes_[i]->EndStatus();
  }
  WaitUntilFused();
}

void ObservedMissionTest::TearDown() { StopAll(); }

void ObservedMissionTest::StopAll() {
  while (!processes_.empty()) {
    EXPECT_EQ(processes_.back()->Stop(absl::Seconds(30)).exit_code, 0)
        << processes_.back()->EndStatus();
    processes_.pop_back();
  }
}

void ObservedMissionTest::Start(const std::string& name, const std::string& program,
                                std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), absl::StrCat(CORBSLAM_PROGRAMS_DIR, "/", program));
  arguments.insert(arguments.end(), {"--insecure", "--metrics-listen", "127.0.0.1:0"});
  auto process = ChildProcess::Start(name, arguments, LogOf(name));
  ASSERT_TRUE(process.ok()) << process.status();
  processes_.push_back(std::move(*process));
}

void ObservedMissionTest::StartRobot(const std::string& name, const std::string& frames) {
  Start(
      name, "client_agent",
      {"--source", DemoSource(), "--frames", frames, "--server", store_address_, "--mission", "lab",
       "--agent", name, "--listen", "127.0.0.1:0", "--record", FileOf(name + ".drive"), "--stay"});
}

std::string ObservedMissionTest::AddressOf(const std::string& name) {
  for (const auto& process : processes_) {
    if (process->name() != name) continue;
    const auto address = process->WaitForAddress(absl::Minutes(1));
    EXPECT_TRUE(address.ok()) << address.status();
    return address.value_or("");
  }
  return "";
}

void ObservedMissionTest::WaitUntilFused() {
  const absl::Time deadline = absl::Now() + kPatience;
  while (absl::Now() < deadline) {
    const json mission =
        Ask("corbslam.v1.MapStore/GetStatistics", {{"mission", "missions/lab"}})["mission"];
    const bool fused = mission.value("islands", json::array()).size() == 1;
    if (fused && mission.value("fusionIdle", false)) return;
    absl::SleepFor(absl::Milliseconds(200));
  }
  FAIL() << "the robots' maps are not one island after " << kPatience;
}

json ObservedMissionTest::Ask(const std::string& method, const json& request) {
  GenericClient client(MakeChannel(store_address_));
  const auto answers = client.Call(method, request.dump());
  EXPECT_TRUE(answers.ok()) << answers.status();
  return answers.ok() && answers->size() == 1 ? json::parse(answers->front()) : json::object();
}

std::string ObservedMissionTest::RunScript(const std::string& script,
                                           const std::vector<std::string>& arguments) {
  const std::string output = FileOf(script + ".log");
  std::vector<std::string> command = {
      CORBSLAM_PYTHON, "-B", absl::StrCat(CORBSLAM_SOURCE_DIR, "/tests/integration/", script)};
  command.insert(command.end(), arguments.begin(), arguments.end());
  const auto process = ChildProcess::Start(script, command, output);
  EXPECT_TRUE(process.ok()) << process.status();
  if (!process.ok()) return "";
  EXPECT_TRUE((*process)->WaitForEnd(absl::Minutes(1))) << script << " still runs";
  EXPECT_TRUE((*process)->EndStatus().ok()) << (*process)->EndStatus();
  return ReadText(output);
}

std::string ObservedMissionTest::MetricsAddressOf(const std::string& name) const {
  const std::string address = FindAddress(ReadText(LogOf(name)), "metrics on ");
  EXPECT_FALSE(address.empty()) << name << " says nowhere where its metrics are";
  return address;
}

ObservedMissionTest::Scrape ObservedMissionTest::ScrapeOf(const std::string& name) {
  json families = json::parse(RunScript("scrape.py", {MetricsAddressOf(name)}), nullptr, false);
  EXPECT_FALSE(families.is_discarded()) << name;
  return Scrape(families.is_discarded() ? json::object() : std::move(families));
}

}  // namespace corbslam::tests
