#include "tests/fault/fault_fixture.h"

#include <string_view>
#include <utility>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "tests/integration/mission_fixture.h"

namespace corbslam::tests {

using services::ChildProcess;

namespace {

namespace fs = std::filesystem;

fs::path MakeEmptyFolder() {
  const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
  const std::string leaf = absl::StrCat("corbslam_", test->test_suite_name(), "_", test->name());
  const fs::path folder = fs::path(::testing::TempDir()) / absl::StrReplaceAll(leaf, {{"/", "_"}});
  fs::remove_all(folder);
  fs::create_directories(folder);
  return folder;
}

}  // namespace

bool WantsLongFaults() { return std::getenv("CORBSLAM_LONG_FAULTS") != nullptr; }

std::string LongSource() {
  const auto recordings = RecordingsFolder();
  EXPECT_TRUE(recordings.has_value()) << "the long form needs CORBSLAM_DATA_DIR";
  return absl::StrCat("tum:", recordings.value_or(""), "/tum_fr1_xyz_15hz");
}

int CountFromEnvironment(const char* variable, int otherwise) {
  int count = otherwise;
  const char* text = std::getenv(variable);
  const bool is_number = text == nullptr || absl::SimpleAtoi(text, &count);
  EXPECT_TRUE(is_number) << variable << " is " << text;
  return count;
}

FaultTest::FaultTest() : folder_(MakeEmptyFolder()), programs_(CORBSLAM_PROGRAMS_DIR) {}

std::unique_ptr<ChildProcess> FaultTest::Start(const std::string& name, const std::string& program,
                                               std::vector<std::string> arguments,
                                               const std::vector<std::string>& security) {
  arguments.insert(arguments.begin(), absl::StrCat(programs_, "/", program));
  arguments.insert(arguments.end(), security.begin(), security.end());
  for (const auto& [variable, value] : variables_) {
    arguments.insert(arguments.begin(), absl::StrCat(variable, "=", value));
  }
  if (!variables_.empty()) arguments.insert(arguments.begin(), "/usr/bin/env");
  auto process = ChildProcess::Start(name, arguments, LogOf(name));
  EXPECT_TRUE(process.ok()) << process.status();
  return process.ok() ? *std::move(process) : nullptr;
}

std::string FaultTest::AddressOf(ChildProcess* process) {
  if (process == nullptr) return "";
  const auto address = process->WaitForAddress(absl::Seconds(60));
  EXPECT_TRUE(address.ok()) << address.status();
  return address.value_or("");
}

std::string FaultTest::MetricsAddressOf(const std::string& name) const {
  const std::string log = ReadText(LogOf(name));
  constexpr std::string_view kWords = "metrics on ";
  const size_t at = log.find(kWords);
  EXPECT_NE(at, std::string::npos) << name << " says nowhere where its metrics are";
  if (at == std::string::npos) return "";
  const size_t begin = at + kWords.size();
  return log.substr(begin, log.find('\n', begin) - begin);
}

nlohmann::json FaultTest::ReadStatistics(const std::string& path) {
  const nlohmann::json read = nlohmann::json::parse(ReadText(path), nullptr, false);
  EXPECT_TRUE(read.is_object()) << path;
  return read.is_object() ? read : nlohmann::json();
}

}  // namespace corbslam::tests
