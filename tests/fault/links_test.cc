// Real robots on bad links: tracking must not notice, and afterwards the map store must have
// everything once. Each robot is in a network of its own; beside the one on the bad link another
// one does the same on a perfect one.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/time/clock.h"
#include "services/client/remote/channel.h"
#include "services/client/store/store_reader.h"
#include "services/security/security_options.h"
#include "services/security/testing/test_certificates.h"
#include "slam/util/status_macros.h"
#include "tests/fault/fault_fixture.h"
#include "tests/fault/network/interface.h"
#include "tests/fault/network/network_namespace.h"
#include "tests/fault/network/shaped_link.h"
#include "tests/integration/mission_fixture.h"

namespace corbslam::tests {

using services::ChildProcess;
using services::ConnectToStore;
using services::SecurityOptions;
using services::StoreReader;
using services::WithoutTls;

namespace {

using nlohmann::json;
using nlohmann::ordered_json;

constexpr char kMission[] = "links";

struct LinkCase {
  std::string name;
  LinkShape shape;
  bool tls = false;  // True: everybody shows a certificate.
};

LinkShape Delayed(int ms, double loss = 0) {
  LinkShape shape;
  // Both ways make the latency of a question and its answer.
  shape.delay = absl::Milliseconds(ms) / 2;
  shape.loss = loss;
  return shape;
}

LinkShape Lossy(double loss) { return Delayed(20, loss); }

LinkShape BlackOut(absl::Duration length) {
  LinkShape shape = Delayed(20);
  shape.outage_begin = absl::Seconds(3);  // The robot has begun to stream.
  shape.outage = length;
  return shape;
}

LinkShape Flapping() {
  LinkShape shape = Delayed(20);
  shape.up = shape.down = absl::Seconds(2);
  return shape;
}

LinkShape Narrow(double rate) {
  LinkShape shape = Delayed(20);
  shape.rate = rate;
  return shape;
}

LinkShape WithLoss(LinkShape shape, double loss) {
  shape.loss = loss;
  return shape;
}

std::vector<LinkCase> AllCases() {
  if (!WantsLongFaults()) {
    return {{"100 ms, 5 % loss", Delayed(100, 0.05)},
            {"black-out of 8 s", BlackOut(absl::Seconds(8))},
            {"2 s up, 2 s down", Flapping()},
            {"256 kbit/s, TLS", Narrow(256e3), true}};
  }
  return {{"20 ms", Delayed(20)},
          {"100 ms", Delayed(100)},
          {"200 ms", Delayed(200)},
          {"1 % loss", Lossy(0.01)},
          {"5 % loss", Lossy(0.05)},
          {"black-out of 30 s", BlackOut(absl::Seconds(30))},
          {"2 s up, 2 s down", Flapping()},
          {"2 s up, 2 s down, 5 % loss, TLS", WithLoss(Flapping(), 0.05), true},
          {"256 kbit/s", Narrow(256e3)},
          {"256 kbit/s, TLS", Narrow(256e3), true},
          {"black-out of 10 min", BlackOut(absl::Minutes(10))}};
}

// CORBSLAM_LINKS: only those with this in their name.
std::vector<LinkCase> Cases() {
  std::vector<LinkCase> cases = AllCases();
  const char* part = std::getenv("CORBSLAM_LINKS");
  if (part != nullptr) {
    std::erase_if(cases, [part](const LinkCase& c) { return !absl::StrContains(c.name, part); });
  }
  return cases;
}

// 15 frames a second: two robots have room for that on two cores.
std::string Source() {
  return WantsLongFaults() ? LongSource() : absl::StrCat(DemoSource(), "?stride=2");
}

absl::Status EnterOwnNetwork() {
  RETURN_IF_ERROR(NetworkNamespace::Enter());
  ASSIGN_OR_RETURN(const int tunnel, OpenTunnel("probe", "10.77.255.1", "10.77.255.2"));
  close(tunnel);
  return absl::OkStatus();
}

// Members are destroyed in reverse order: the process ends before its link and its network.
struct Robot {
  std::string name;
  std::unique_ptr<NetworkNamespace> place;
  std::unique_ptr<ShapedLink> link;
  std::unique_ptr<ChildProcess> process;
  json statistics;
};

struct Outcome {
  std::string link;
  double seconds = 0;          // Time from the robots' start until the store had everything.
  LinkCounts packets;          // Counts of the bad link.
  std::array<json, 2> robots;  // Statistics on the bad link, and on the perfect one.
};

// Returns the store's address as a robot's network sees it.
std::string AddressOfStore(int network) { return absl::StrCat("10.77.", network, ".1"); }

std::string HostsOfStores() {
  std::string hosts;
  const auto networks = static_cast<int>(2 * Cases().size());
  for (int i = 0; i < networks; ++i) absl::StrAppend(&hosts, AddressOfStore(i), " ");
  return hosts;
}

class LinksTest : public FaultTest {
 protected:
  void SetUp() override { SKIP_UNLESS_PERMITTED(EnterOwnNetwork()); }

  // Returns the options by which a program of the case secures itself; `name` is its certificate's.
  std::vector<std::string> SecurityOf(const LinkCase& link_case, const std::string& name) const {
    return link_case.tls ? certificates_.Flags(name) : std::vector<std::string>{"--insecure"};
  }
  SecurityOptions OperatorOf(const LinkCase& link_case) const;
  // The robot's network is 10.77.NETWORK.x.
  Robot StartRobot(const LinkCase& link_case, const std::string& name, int network,
                   const LinkShape& shape, int port);
  // Runs servers and both robots, and checks what must be true afterwards.
  Outcome RunCase(const LinkCase& link_case, int number);
  void FinishRobots(const LinkCase& link_case, std::array<Robot, 2>& robots);
  static void CheckStore(StoreReader& reader, const std::array<Robot, 2>& robots);

  const test_data::TestCertificates certificates_{kMission, HostsOfStores()};
};

SecurityOptions LinksTest::OperatorOf(const LinkCase& link_case) const {
  return link_case.tls ? certificates_.Options("operator") : WithoutTls();
}

Robot LinksTest::StartRobot(const LinkCase& link_case, const std::string& name, int network,
                            const LinkShape& shape, int port) {
  Robot robot;
  robot.name = name;
  auto place = NetworkNamespace::Create();
  EXPECT_TRUE(place.ok()) << place.status();
  if (!place.ok()) return robot;
  robot.place = *std::move(place);
  const std::string address = AddressOfStore(network);
  auto link = ShapedLink::Create({.here = nullptr,
                                  .there = robot.place.get(),
                                  .address_here = address,
                                  .address_there = absl::StrCat("10.77.", network, ".2")},
                                 shape);
  EXPECT_TRUE(link.ok()) << link.status();
  if (!link.ok()) return robot;
  robot.link = *std::move(link);
  const double finish_s = absl::ToDoubleSeconds(shape.outage + absl::Minutes(10));
  const absl::Status started = robot.place->Run([&] {
    const std::string file = absl::StrCat(name, network);
    robot.process = Start(
        file, "client_agent",
        {"--source", Source(), "--server", absl::StrCat(address, ":", port), "--mission", kMission,
         "--agent", name, "--pace", "sensor", "--stats", FileOf(file + ".json"), "--spool-dir",
         FileOf(file + ".spool"), "--outbox-mb", "1", "--finish", absl::StrCat(finish_s)},
        SecurityOf(link_case, name));
    return absl::OkStatus();
  });
  EXPECT_TRUE(started.ok()) << started;
  return robot;
}

void LinksTest::FinishRobots(const LinkCase& link_case, std::array<Robot, 2>& robots) {
  const absl::Time deadline = absl::Now() + absl::Minutes(12) + link_case.shape.outage;
  for (Robot& robot : robots) {
    ASSERT_NE(robot.process, nullptr);
    ASSERT_TRUE(robot.process->WaitForEnd(deadline - absl::Now())) << robot.name;
    ASSERT_TRUE(robot.process->EndStatus().ok()) << robot.process->EndStatus();
    robot.statistics = ReadStatistics(FileOf(robot.process->name() + ".json"));
    ASSERT_TRUE(robot.statistics.is_object());
  }
  const json& shaped = robots[0].statistics;
  const json& perfect = robots[1].statistics;
  EXPECT_EQ(shaped["outbox"]["lost_local_maps"], 0);
  // Robots that can't keep up, as under a sanitizer, are lost where they dropped too many frames.
  if (2 * perfect["dropped"].get<uint64_t>() < perfect["frames"].get<uint64_t>()) {
    EXPECT_EQ(shaped["lost"], perfect["lost"]);
  }
  // A busy machine makes either robot drop a frame now and then.
  const auto tolerated = std::max<uint64_t>(2, perfect["frames"].get<uint64_t>() / 50);
  EXPECT_LE(shaped["dropped"].get<uint64_t>(), perfect["dropped"].get<uint64_t>() + tolerated);
}

void LinksTest::CheckStore(StoreReader& reader, const std::array<Robot, 2>& robots) {
  ASSERT_TRUE(reader.WaitUntilFused(absl::Seconds(300)).ok());
  const auto frames = reader.CountReportedFrames();
  ASSERT_TRUE(frames.ok()) << frames.status();
  uint64_t keyframes = 0;
  for (const Robot& robot : robots) {
    keyframes += robot.statistics["keyframes"].get<uint64_t>();
    const auto reported = frames->find(robot.name);
    ASSERT_NE(reported, frames->end()) << robot.name;
    EXPECT_EQ(reported->second, robot.statistics["tracked"].get<uint64_t>() +
                                    robot.statistics["lost"].get<uint64_t>())
        << robot.name;
  }
  const auto statistics = reader.Statistics();
  ASSERT_TRUE(statistics.ok()) << statistics.status();
  EXPECT_EQ(statistics->mission().keyframes(), keyframes);
}

Outcome LinksTest::RunCase(const LinkCase& link_case, int number) {
  Outcome outcome;
  outcome.link = link_case.name;
  const auto worker = Start(absl::StrCat("worker", number), "fusion_worker",
                            {"--listen", "127.0.0.1:0"}, SecurityOf(link_case, "worker"));
  const auto store =
      Start(absl::StrCat("store", number), "map_store",
            {"--listen", "0.0.0.0:0", "--worker", AddressOf(worker.get()), "--data-dir",
             FileOf(absl::StrCat("data", number)), "--keep-everything"},
            SecurityOf(link_case, "store"));
  const std::string address = AddressOf(store.get());
  int port = 0;
  EXPECT_TRUE(absl::SimpleAtoi(address.substr(address.rfind(':') + 1), &port)) << address;
  if (port == 0) return outcome;
  const absl::Time start = absl::Now();
  std::array<Robot, 2> robots = {StartRobot(link_case, "alpha", 2 * number, link_case.shape, port),
                                 StartRobot(link_case, "bravo", 2 * number + 1, LinkShape(), port)};
  FinishRobots(link_case, robots);
  if (HasFatalFailure()) return outcome;
  outcome.seconds = absl::ToDoubleSeconds(absl::Now() - start);
  outcome.packets = robots[0].link->counts();
  for (size_t i = 0; i < robots.size(); ++i) outcome.robots[i] = robots[i].statistics;
  const auto channel = ConnectToStore(absl::StrCat("127.0.0.1:", port), OperatorOf(link_case));
  EXPECT_TRUE(channel.ok()) << channel.status();
  if (!channel.ok()) return outcome;
  StoreReader reader(*channel, kMission);
  CheckStore(reader, robots);
  return outcome;
}

constexpr std::array<const char*, 2> kRobots = {"bad", "perfect"};

void PrintTable(const std::vector<Outcome>& outcomes) {
  std::cout
      << "| link | robot's link | frames | lost | dropped | frame ms median | p99 | keyframes "
         "| MB up | packets lost | s |\n|---|---|---|---|---|---|---|---|---|---|---|\n";
  for (const Outcome& outcome : outcomes) {
    for (size_t i = 0; i < kRobots.size(); ++i) {
      const json& robot = outcome.robots[i];
      if (!robot.is_object()) continue;
      std::cout << absl::StrFormat(
          "| %s | %s | %d | %d | %d | %.1f | %.1f | %d | %.2f | %s | %s |\n", outcome.link,
          kRobots[i], robot["frames"].get<int>(), robot["lost"].get<int>(),
          robot["dropped"].get<int>(), robot["tracking_ms"]["median"].get<double>(),
          robot["tracking_ms"]["p99"].get<double>(), robot["keyframes"].get<int>(),
          robot["bytes_up"].get<double>() / 1e6,
          i == 0 ? absl::StrCat(outcome.packets.lost, "/",
                                outcome.packets.lost + outcome.packets.passed)
                 : "",
          i == 0 ? absl::StrFormat("%.1f", outcome.seconds) : "");
    }
  }
}

void WriteJson(const std::vector<Outcome>& outcomes, const std::string& path) {
  ordered_json rows = ordered_json::array();
  for (const Outcome& outcome : outcomes) {
    rows.push_back({{"link", outcome.link},
                    {"seconds", outcome.seconds},
                    {"packets_passed", outcome.packets.passed},
                    {"packets_lost", outcome.packets.lost},
                    {"robot_on_bad_link", outcome.robots[0]},
                    {"robot_on_perfect_link", outcome.robots[1]}});
  }
  std::ofstream(path) << rows.dump(2) << "\n";
  std::cout << "written to " << path << "\n";
}

TEST_F(LinksTest, TrackingDoesNotNoticeAndEverythingArrivesOnce) {
  std::vector<Outcome> outcomes;
  for (const LinkCase& link_case : Cases()) {
    SCOPED_TRACE(link_case.name);
    outcomes.push_back(RunCase(link_case, static_cast<int>(outcomes.size())));
    const LinkShape& shape = link_case.shape;
    const bool loses =
        shape.loss > 0 || shape.outage > absl::ZeroDuration() || shape.down > absl::ZeroDuration();
    EXPECT_GT(outcomes.back().packets.passed, 0u);
    EXPECT_TRUE(!loses || outcomes.back().packets.lost > 0) << "the link was not bad";
    PrintTable({outcomes.back()});
  }
  ASSERT_FALSE(outcomes.empty()) << "CORBSLAM_LINKS names none";
  std::cout << "\n";
  PrintTable(outcomes);
  WriteJson(outcomes, FileOf("links.json"));
}

}  // namespace
}  // namespace corbslam::tests
