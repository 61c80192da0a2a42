// Tests what the real programs say of servers that are not reached, robots of one name, and workers
// that are away.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "services/runtime/child_process.h"
#include "services/security/testing/test_certificates.h"
#include "services/testing/test_path.h"
#include "tests/integration/mission_fixture.h"

namespace corbslam::tests {

using services::ChildProcess;
using services::TestPath;

namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

// Nobody listens there: it is reserved for tcpmux, which nobody runs.
constexpr char kNobody[] = "127.0.0.1:1";
constexpr absl::Duration kPatience = absl::Seconds(120);
// EX_TEMPFAIL: not everything was acknowledged.
constexpr int kUnfinished = 75;

// One of our programs and what it says.
class Program {
 public:
  Program(const std::string& name, std::vector<std::string> arguments,
          const std::string& log = "program")
      : log_(TestPath(log + ".txt")) {
    arguments.insert(arguments.begin(), absl::StrCat(CORBSLAM_PROGRAMS_DIR, "/", name));
    std::filesystem::remove(log_);  // An earlier run's words are not this one's.
    auto process = ChildProcess::Start(name, arguments, log_);
    EXPECT_TRUE(process.ok()) << process.status();
    if (process.ok()) process_ = *std::move(process);
  }
  ~Program() {
    if (process_ != nullptr) process_->Stop(absl::Seconds(10));
  }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  std::string Address() { return process_->WaitForAddress(kPatience).value_or(""); }
  // Returns whether its log comes to have the text.
  bool Says(const std::string& text) {
    const absl::Time deadline = absl::Now() + kPatience;
    while (!absl::StrContains(Log(), text) && absl::Now() < deadline) {
      if (process_->WaitForEnd(absl::Milliseconds(50))) break;
    }
    return absl::StrContains(Log(), text);
  }
  // Returns its exit code, once it has ended by itself; else -1.
  int End() {
    if (!process_->WaitForEnd(kPatience)) return -1;
    return process_->Stop(absl::ZeroDuration()).exit_code;
  }
  std::string Log() const { return ReadText(log_); }
  ChildProcess& process() { return *process_; }

 private:
  const std::string log_;
  std::unique_ptr<ChildProcess> process_;
};

std::vector<std::string> Robot(const std::string& server, const std::string& frames,
                               std::vector<std::string> more = {}) {
  std::vector<std::string> arguments = {"--source", DemoSource() + "?frames=" + frames, "--server",
                                        server, "--insecure"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

struct AddressCase {
  const char* name;
  const char* address;
  const char* says;
};

class WrongAddressTest : public ::testing::TestWithParam<AddressCase> {};

// The programs are the tool, the doctor, and a robot before its first frame.
TEST_P(WrongAddressTest, IsNamedByEveryProgram) {
  const std::string address = GetParam().address;
  Program list("corbslam", {"mission", "list", "--insecure", "--server", address});
  EXPECT_EQ(list.End(), 1);
  EXPECT_THAT(list.Log(), HasSubstr(GetParam().says));
  Program doctor("corbslam", {"doctor", "--insecure", "--server", address});
  EXPECT_EQ(doctor.End(), 1);
  EXPECT_THAT(doctor.Log(), HasSubstr(GetParam().says));
  Program robot("client_agent", Robot(address, "0:9"));
  EXPECT_EQ(robot.End(), 2);
  EXPECT_THAT(robot.Log(), AllOf(HasSubstr("--server"), HasSubstr(GetParam().says)));
}

INSTANTIATE_TEST_SUITE_P(
    Addresses, WrongAddressTest,
    ::testing::Values(AddressCase{"NoPort", "127.0.0.1", "has no port"},
                      AddressCase{"Scheme", "http://127.0.0.1:56299", "begins with http://"},
                      AddressCase{"LargePort", "127.0.0.1:99999", "must be a number of 1 to 65535"},
                      AddressCase{"NoNumber", "localhost:grpc", "has port \"grpc\""},
                      AddressCase{"AnyPort", "localhost:0", "listening on"},
                      AddressCase{"BareIpv6", "::1:56299", "give [::1]:56299"}),
    [](const auto& info) { return std::string(info.param.name); });

TEST(ReachTest, AnUnknownHostIsNamed) {
  // The name is reserved never to be found (RFC 6761); where DNS is away, nobody can say so.
  Program list("corbslam",
               {"mission", "list", "--insecure", "--server", "no-such-host.invalid:50051"});
  EXPECT_EQ(list.End(), 1);
  EXPECT_THAT(list.Log(), AllOf(HasSubstr("UNAVAILABLE: no map store answers"),
                                HasSubstr("no-such-host.invalid")));
}

TEST(ReachTest, ARobotSaysWhileItMapsThatItsStoreIsNotReached) {
  Program robot("client_agent", Robot(kNobody, "0:9", {"--finish", "0.5"}));
  EXPECT_EQ(robot.End(), kUnfinished);
  EXPECT_THAT(robot.Log(),
              AllOf(HasSubstr("no session with the map store"), HasSubstr("Connection refused"),
                    HasSubstr("maps on"), HasSubstr("done: 10 of 10 frames tracked")));
}

TEST(ReachTest, TlsOnOneSideAndAnotherServersPortAreNamed) {
  const test_data::TestCertificates certificates("lab");
  Program worker("fusion_worker", {"--listen", "127.0.0.1:0", "--insecure"}, "worker");
  std::vector<std::string> secure = certificates.Flags("worker");
  secure.insert(secure.end(), {"--listen", "127.0.0.1:0"});
  Program secure_worker("fusion_worker", secure, "secure");
  const std::string address = worker.Address();
  Program wrong("corbslam", {"mission", "list", "--insecure", "--server", address});
  EXPECT_EQ(wrong.End(), 1);
  EXPECT_THAT(wrong.Log(), HasSubstr("a fusion worker does, which does not offer"));
  Program robot("client_agent", Robot(address, "0:9", {"--finish", "0.5"}));
  EXPECT_EQ(robot.End(), kUnfinished);
  EXPECT_THAT(robot.Log(), HasSubstr("a fusion worker does, which does not offer"));
  Program plain("corbslam", {"mission", "list", "--insecure", "--server", secure_worker.Address()});
  EXPECT_EQ(plain.End(), 1);
  EXPECT_THAT(plain.Log(), HasSubstr("the server there speaks TLS"));
  std::vector<std::string> list = {"mission", "list", "--server", address};
  const std::vector<std::string> flags = certificates.Flags("operator");
  list.insert(list.end(), flags.begin(), flags.end());
  Program encrypted("corbslam", list);
  EXPECT_EQ(encrypted.End(), 1);
  EXPECT_THAT(encrypted.Log(), HasSubstr("the server there speaks no TLS"));
}

TEST(ReachTest, TwoRobotsOfOneNameAreToldApart) {
  Program store("map_store", {"--listen", "127.0.0.1:0", "--insecure", "--in-process-worker"},
                "store");
  const std::string address = store.Address();
  Program first("client_agent", Robot(address, "0:9", {"--stay"}), "first");
  ASSERT_TRUE(first.Says("a session with the map store stands"));
  Program second("client_agent", Robot(address, "0:9", {"--finish", "0.5"}), "second");
  EXPECT_EQ(second.End(), kUnfinished);
  EXPECT_THAT(second.Log(),
              AllOf(HasSubstr("agent agent of mission default is connected already"),
                    HasSubstr("--take-over"), HasSubstr("done: 10 of 10 frames tracked")));
  EXPECT_THAT(store.Log(), HasSubstr("session refused"));
  EXPECT_THAT(first.Log(), Not(HasSubstr("no session")));
  Program third("client_agent", Robot(address, "0:9", {"--take-over"}), "third");
  EXPECT_EQ(third.End(), 0) << third.Log();
  EXPECT_TRUE(first.Says("asks again every two minutes"));
}

TEST(ReachTest, ANormalEndIsNoBrokenStream) {
  Program store("map_store", {"--listen", "127.0.0.1:0", "--insecure", "--in-process-worker"},
                "store");
  Program robot("client_agent", Robot(store.Address(), "0:9"), "robot");
  EXPECT_EQ(robot.End(), 0) << robot.Log();
  EXPECT_TRUE(store.Says("session ended by the robot"));
  for (const std::string& log : {store.Log(), robot.Log()}) {
    EXPECT_THAT(log, AllOf(Not(HasSubstr("broke")), Not(HasSubstr("CANCELLED"))));
  }
}

TEST(ReachTest, AWorkerThatIsAwayIsToldEverywhere) {
  Program store("map_store", {"--listen", "127.0.0.1:0", "--insecure", "--worker", kNobody},
                "store");
  const std::string address = store.Address();
  for (const char* name : {"alpha", "bravo"}) {
    Program robot("client_agent", Robot(address, "0:60", {"--agent", name, "--mission", "lab"}),
                  name);
    EXPECT_EQ(robot.End(), 0) << robot.Log();
  }
  EXPECT_TRUE(store.Says("no fusion worker takes requests"));
  EXPECT_THAT(store.Log(), HasSubstr("no fusion worker answers at 127.0.0.1:1"));
  Program show("corbslam",
               {"mission", "show", "--insecure", "--server", address, "--mission", "lab"}, "show");
  EXPECT_EQ(show.End(), 0);
  EXPECT_THAT(show.Log(), AllOf(HasSubstr("fusion waits for a worker"),
                                HasSubstr("waiting: no fusion worker takes requests since"),
                                HasSubstr("waiting for a fusion worker"),
                                Not(HasSubstr("share enough words"))));
  Program doctor("corbslam", {"doctor", "--insecure", "--server", address}, "doctor");
  EXPECT_EQ(doctor.End(), 1);
  EXPECT_THAT(doctor.Log(), AllOf(HasSubstr("no fusion worker takes its requests since"),
                                  HasSubstr("Connection refused")));
}

}  // namespace
}  // namespace corbslam::tests
