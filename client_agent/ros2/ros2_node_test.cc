#include "client_agent/ros2/ros2_node.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <ros2_types.h>

#include <string>

#include "absl/synchronization/notification.h"
#include "client_agent/ros2/ros2_clock.h"
#include "client_agent/ros2/ros2_graph.h"
#include "client_agent/ros2/ros2_names.h"
#include "client_agent/ros2/ros2_service.h"
#include "client_agent/ros2/testing/ros2_test_node.h"

namespace corbslam::client_agent {
namespace {

using ::testing::HasSubstr;
using Clock = rosgraph_msgs_msg_dds__Clock_;

std::unique_ptr<Ros2Node> MakeNode(const std::string& name) {
  auto node = Ros2Node::Create(TestNode(name));
  EXPECT_TRUE(node.ok()) << node.status();
  return node.ok() ? *std::move(node) : nullptr;
}

TEST(Ros2NodeTest, AMessageIsHeard) {
  const auto talker = MakeNode("talker");
  const auto listener = MakeNode("listener");
  ASSERT_TRUE(talker != nullptr && listener != nullptr);
  std::atomic<int64_t> heard_ns = 0;
  const auto subscription = listener->Subscribe(
      "rt/clock", rosgraph_msgs_msg_dds__Clock__desc, kDefaultQos, [&](const void* sample) {
        heard_ns = Nanoseconds(static_cast<const Clock*>(sample)->clock);
      });
  ASSERT_TRUE(subscription.ok()) << subscription.status();
  const auto publisher =
      talker->Advertise("rt/clock", rosgraph_msgs_msg_dds__Clock__desc, kDefaultQos);
  ASSERT_TRUE(publisher.ok()) << publisher.status();
  ASSERT_TRUE(Within10s([&] { return (*publisher)->HasReaders(); }));
  const Clock clock{Ros2Time(1'234'567'890'123)};
  (*publisher)->Publish(&clock);
  EXPECT_TRUE(Within10s([&] { return heard_ns == 1'234'567'890'123; }));
  EXPECT_EQ((*subscription)->Hearing().messages, 1u);
  listener->Stop();
}

TEST(Ros2NodeTest, ASilentTopicIsExplained) {
  const auto talker = MakeNode("talker");
  const auto listener = MakeNode("listener");
  ASSERT_TRUE(talker != nullptr && listener != nullptr);
  const auto wanted = listener->Subscribe("rt/a/clock", rosgraph_msgs_msg_dds__Clock__desc,
                                          kDefaultQos, [](const void*) {});
  ASSERT_TRUE(wanted.ok()) << wanted.status();
  const Ros2Graph graph(*listener);
  EXPECT_THAT(graph.WhyNothing(**wanted, "clock"), HasSubstr("does its driver run"));
  const auto other =
      talker->Advertise("rt/b/clock", rosgraph_msgs_msg_dds__Clock__desc, kDefaultQos);
  ASSERT_TRUE(other.ok());
  EXPECT_TRUE(Within10s([&] {
    const std::string why = graph.WhyNothing(**wanted, "clock");
    return why.find("published are /b/clock: name one by -r clock:=TOPIC") != std::string::npos;
  })) << graph.WhyNothing(**wanted, "clock");
  const auto worse =
      talker->Advertise("rt/a/clock", rosgraph_msgs_msg_dds__Clock__desc, kSensorData);
  ASSERT_TRUE(worse.ok());
  EXPECT_TRUE(Within10s([&] {
    const std::string why = graph.WhyNothing(**wanted, "clock");
    return why.find("qos_overrides./a/clock.subscription.reliability:=best_effort") !=
           std::string::npos;
  })) << graph.WhyNothing(**wanted, "clock");
}

TEST(Ros2NodeTest, ATopicOfAnotherTypeIsTold) {
  const auto talker = MakeNode("talker");
  const auto listener = MakeNode("listener");
  ASSERT_TRUE(talker != nullptr && listener != nullptr);
  const auto wanted = listener->Subscribe("rt/a", sensor_msgs_msg_dds__Image__desc, kSensorData,
                                          [](const void*) {});
  const auto other =
      talker->Advertise("rt/a", sensor_msgs_msg_dds__CompressedImage__desc, kSensorData);
  ASSERT_TRUE(wanted.ok() && other.ok());
  const Ros2Graph graph(*listener);
  EXPECT_TRUE(Within10s([&] {
    return graph.WhyNothing(**wanted, "a")
               .find("/a is published as sensor_msgs/msg/CompressedImage") != std::string::npos;
  })) << graph.WhyNothing(**wanted, "a");
}

TEST(Ros2NodeTest, AServiceAnswersWhoAsked) {
  using Request = std_srvs_srv_dds__SetBool_Request_;
  using Response = std_srvs_srv_dds__SetBool_Response_;
  const auto server = MakeNode("server");
  const auto client = MakeNode("client");
  ASSERT_TRUE(server != nullptr && client != nullptr);
  ASSERT_TRUE(ServeSetBool(*server, "/pause", [](bool pause) -> absl::StatusOr<std::string> {
                if (pause) return "paused";
                return absl::FailedPreconditionError("not paused");
              }).ok());
  std::atomic<int> answers = 0;
  const auto responses = client->Subscribe(
      "rr/pauseReply", std_srvs_srv_dds__SetBool_Response__desc, kDefaultQos,
      [&](const void* sample) {
        const auto& response = *static_cast<const Response*>(sample);
        EXPECT_EQ(response.client, 77u);
        EXPECT_EQ(response.success, response.number == 1);
        EXPECT_EQ(std::string(response.message), response.success ? "paused" : "not paused");
        ++answers;
      });
  const auto requests =
      client->Advertise("rq/pauseRequest", std_srvs_srv_dds__SetBool_Request__desc, kDefaultQos);
  ASSERT_TRUE(responses.ok() && requests.ok());
  ASSERT_TRUE(Within10s(
      [&] { return (*requests)->HasReaders() && (*responses)->Hearing().publishers > 0; }));
  for (const int64_t number : {1, 2}) {
    const Request request{77, number, number == 1};
    (*requests)->Publish(&request);
  }
  EXPECT_TRUE(Within10s([&] { return answers == 2; }));
  client->Stop();
}

TEST(Ros2NodeTest, SimulatedTimeIsUnknownUntilTheClockSaysIt) {
  const auto node = MakeNode("node");
  const auto simulator = MakeNode("simulator");
  ASSERT_TRUE(node != nullptr && simulator != nullptr);
  const auto names = Ros2Names::Make("node", {});
  const auto clock = Ros2Clock::Make(true, *names, *node);
  ASSERT_TRUE(clock.ok());
  EXPECT_FALSE((*clock)->Now_ns().has_value());
  const auto publisher =
      simulator->Advertise("rt/clock", rosgraph_msgs_msg_dds__Clock__desc, kDefaultQos);
  ASSERT_TRUE(publisher.ok());
  const Clock said{Ros2Time(5'000'000'001)};
  EXPECT_TRUE(Within10s([&] {
    (*publisher)->Publish(&said);
    return (*clock)->Now_ns() == 5'000'000'001;
  }));
  node->Stop();
}

}  // namespace
}  // namespace corbslam::client_agent
