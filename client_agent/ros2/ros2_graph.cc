#include "client_agent/ros2/ros2_graph.h"

#include <algorithm>
#include <set>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "client_agent/ros2/ros2_names.h"

namespace corbslam::client_agent {
namespace {

constexpr size_t kMostEndpoints = 4096;
constexpr size_t kMostNamed = 6;

std::string OtherQuality(const Ros2Subscription& subscription, const Ros2Hearing& hearing,
                         const std::vector<Ros2Endpoint>& of_topic) {
  const std::string topic = Ros2Topic(subscription.topic());
  const bool is_durability = hearing.lacking == "durability";
  return absl::StrCat(topic, " is published with another quality of service (", hearing.lacking,
                      "): its publisher offers ",
                      of_topic.empty() ? "less" : Describe(of_topic[0].qos), ", this node wants ",
                      Describe(subscription.qos()), ": take what is offered by -p qos_overrides.",
                      topic, ".subscription.", hearing.lacking,
                      ":=", is_durability ? "volatile" : "best_effort");
}

std::string NoPublisher(const Ros2Subscription& subscription, const std::string& name,
                        const std::vector<Ros2Endpoint>& all) {
  std::set<std::string> candidates;
  for (const Ros2Endpoint& endpoint : all) {
    const std::string topic = Ros2Topic(endpoint.topic);
    if (endpoint.type == subscription.type() && !topic.empty()) candidates.insert(topic);
  }
  const std::string wanted = Ros2Topic(subscription.topic());
  const std::string type = Ros2Type(subscription.type());
  if (candidates.empty()) {
    return absl::StrCat("nobody publishes ", wanted, " (", type,
                        "), nor any topic of that type: "
                        "does its driver run, with the same ROS_DOMAIN_ID, on a network that "
                        "carries multicast?");
  }
  std::vector<std::string> named(candidates.begin(), candidates.end());
  const size_t more = named.size() - std::min(named.size(), kMostNamed);
  named.resize(std::min(named.size(), kMostNamed));
  return absl::StrCat("nobody publishes ", wanted, " (", type, "); published are ",
                      absl::StrJoin(named, ", "), more > 0 ? " and others" : "",
                      ": name one by -r ", name, ":=TOPIC");
}

}  // namespace

Ros2Graph::Ros2Graph(const Ros2Node& node)
    : publications_(dds_create_reader(node.participant(), DDS_BUILTIN_TOPIC_DCPSPUBLICATION,
                                      nullptr, nullptr)) {}

std::vector<Ros2Endpoint> Ros2Graph::Publishers() const {
  std::vector<Ros2Endpoint> endpoints;
  std::vector<void*> samples(kMostEndpoints, nullptr);
  std::vector<dds_sample_info_t> infos(kMostEndpoints);
  const dds_return_t count =
      dds_read(publications_.get(), samples.data(), infos.data(), kMostEndpoints, kMostEndpoints);
  for (size_t i = 0; count > 0 && i < static_cast<size_t>(count); ++i) {
    if (!infos[i].valid_data || infos[i].instance_state != DDS_ALIVE_INSTANCE_STATE) continue;
    const auto& endpoint = *static_cast<const dds_builtintopic_endpoint_t*>(samples[i]);
    endpoints.push_back({endpoint.topic_name, endpoint.type_name, ReadDdsQos(endpoint.qos)});
  }
  if (count > 0) dds_return_loan(publications_.get(), samples.data(), count);
  return endpoints;
}

std::string Ros2Graph::WhyNothing(const Ros2Subscription& subscription,
                                  const std::string& name) const {
  const Ros2Hearing hearing = subscription.Hearing();
  if (hearing.messages > 0) return "";
  const std::vector<Ros2Endpoint> all = Publishers();
  std::vector<Ros2Endpoint> of_topic;
  std::set<std::string> other_types;
  for (const Ros2Endpoint& endpoint : all) {
    if (endpoint.topic != subscription.topic()) continue;
    if (endpoint.type == subscription.type()) {
      of_topic.push_back(endpoint);
    } else {
      other_types.insert(Ros2Type(endpoint.type));
    }
  }
  const std::string topic = Ros2Topic(subscription.topic());
  if (hearing.publishers > 0) {
    return absl::StrCat(topic, " has ", hearing.publishers,
                        " publishers and no message came: does the driver send, and are large "
                        "messages lost on the way (docs/ros2.md, net.core.rmem_max)?");
  }
  if (hearing.incompatible > 0) return OtherQuality(subscription, hearing, of_topic);
  if (of_topic.empty() && !other_types.empty()) {
    return absl::StrCat(topic, " is published as ", absl::StrJoin(other_types, ", "),
                        ", this node reads it as ", Ros2Type(subscription.type()),
                        ": name another topic by -r ", name,
                        ":=TOPIC; compressed pictures by -p image_transport:=compressed");
  }
  return NoPublisher(subscription, name, all);
}

}  // namespace corbslam::client_agent
