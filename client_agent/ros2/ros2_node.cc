#include "client_agent/ros2/ros2_node.h"

#include <glog/logging.h>

#include <cstdlib>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client_agent/ros2/ros2_discovery.h"
#include "slam/util/named_thread.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

constexpr int kMostAtOnce = 8;
constexpr char kEnclave[] = "enclave=/;";  // Whose, ROS 2 reads from participants.
constexpr char kOnlyThisHost[] =
    "<CycloneDDS><Domain id=\"any\"><General><Interfaces><NetworkInterface address=\"127.0.0.1\" "
    "multicast=\"true\"/></Interfaces></General></Domain></CycloneDDS>";

absl::Status DdsError(absl::string_view what, dds_return_t code) {
  return absl::UnavailableError(absl::StrCat("DDS: ", what, ": ", dds_strretcode(code)));
}

// CYCLONEDDS_URI goes before what is set here.
std::string DomainConfiguration() {
  const char* const uri = std::getenv("CYCLONEDDS_URI");
  return absl::StrCat(kOnlyThisHost, uri != nullptr && *uri != '\0' ? "," : "",
                      uri != nullptr ? uri : "");
}

std::string PolicyName(uint32_t policy) {
  switch (policy) {
    case DDS_RELIABILITY_QOS_POLICY_ID:
      return "reliability";
    case DDS_DURABILITY_QOS_POLICY_ID:
      return "durability";
    case DDS_DEADLINE_QOS_POLICY_ID:
      return "deadline";
    case DDS_LIVELINESS_QOS_POLICY_ID:
      return "liveliness";
    default:
      return absl::StrCat("policy ", policy);
  }
}

}  // namespace

Ros2Hearing Ros2Subscription::Hearing() const {
  Ros2Hearing hearing;
  dds_subscription_matched_status_t matched = {};
  dds_requested_incompatible_qos_status_t incompatible = {};
  dds_get_subscription_matched_status(reader_.get(), &matched);
  dds_get_requested_incompatible_qos_status(reader_.get(), &incompatible);
  hearing.publishers = matched.current_count;
  hearing.incompatible = incompatible.total_count;
  if (incompatible.total_count > 0) hearing.lacking = PolicyName(incompatible.last_policy_id);
  hearing.messages = messages_.load();
  return hearing;
}

void Ros2Subscription::TakeAll() {
  for (;;) {
    void* samples[kMostAtOnce] = {nullptr};
    dds_sample_info_t infos[kMostAtOnce];
    const dds_return_t count = dds_take(reader_.get(), samples, infos, kMostAtOnce, kMostAtOnce);
    if (count <= 0) return;
    for (dds_return_t i = 0; i < count; ++i) {
      if (!infos[i].valid_data) continue;
      ++messages_;
      handler_(samples[i]);
    }
    dds_return_loan(reader_.get(), samples, count);
  }
}

void Ros2Publisher::Publish(const void* sample) {
  const dds_return_t code = dds_write(writer_.get(), sample);
  if (code == DDS_RETCODE_OK || has_failed_.exchange(true)) return;
  LOG(WARNING) << "ros2: a message of " << topic_ << " was not sent: " << dds_strretcode(code)
               << "; further ones are not logged";
}

bool Ros2Publisher::HasReaders() const {
  dds_publication_matched_status_t matched = {};
  dds_get_publication_matched_status(writer_.get(), &matched);
  return matched.current_count > 0;
}

absl::StatusOr<std::unique_ptr<Ros2Node>> Ros2Node::Create(const Ros2NodeOptions& options) {
  std::unique_ptr<Ros2Node> node(new Ros2Node(options));
  RETURN_IF_ERROR(node->Begin());
  return node;
}

absl::Status Ros2Node::Begin() {
  if (options_.only_this_host) {
    domain_ = DdsEntity(dds_create_domain(options_.domain, DomainConfiguration().c_str()));
    // Another node of this process has made it.
    if (domain_.get() < 0 && domain_.get() != DDS_RETCODE_PRECONDITION_NOT_MET) {
      return DdsError("the domain", domain_.get());
    }
  }
  const DdsQos qos(dds_create_qos(), &dds_delete_qos);
  dds_qset_userdata(qos.get(), kEnclave, sizeof(kEnclave) - 1);
  participant_ = DdsEntity(dds_create_participant(options_.domain, qos.get(), nullptr));
  if (participant_.get() < 0) {
    return DdsError(absl::StrCat("no participant of domain ", options_.domain,
                                 " (ROS_DOMAIN_ID); is there a network, and is CYCLONEDDS_URI "
                                 "right?"),
                    participant_.get());
  }
  waitset_ = DdsEntity(dds_create_waitset(participant_.get()));
  wake_ = DdsEntity(dds_create_guardcondition(participant_.get()));
  dds_waitset_attach(waitset_.get(), wake_.get(), 0);
  ASSIGN_OR_RETURN(const DdsEntity topic,
                   MakeTopic(kDiscoveryTopic, DiscoveryType(options_.is_humble)));
  discovery_ = DdsEntity(
      dds_create_writer(participant_.get(), topic.get(), MakeDdsQos(kLatched).get(), nullptr));
  if (discovery_.get() < 0) return DdsError("the writer of ros_discovery_info", discovery_.get());
  {
    const absl::MutexLock lock(&mutex_);
    Announce();
  }
  thread_ = StartThread("ros2 node", [this] { Run(); });
  return absl::OkStatus();
}

Ros2Node::~Ros2Node() {
  Stop();
  // Readers and writers go before their participant.
  const absl::MutexLock lock(&mutex_);
  subscriptions_.clear();
  publishers_.clear();
}

void Ros2Node::Stop() {
  stops_ = true;
  if (wake_.get() > 0) dds_set_guardcondition(wake_.get(), true);
  if (thread_.joinable()) thread_.join();
}

absl::StatusOr<DdsEntity> Ros2Node::MakeTopic(const std::string& topic,
                                              const dds_topic_descriptor_t& type) {
  DdsEntity made(dds_create_topic(participant_.get(), &type, topic.c_str(), nullptr, nullptr));
  if (made.get() >= 0) return made;
  return DdsError(absl::StrCat("the topic ", topic, " of ", type.m_typename), made.get());
}

absl::StatusOr<Ros2Subscription*> Ros2Node::Subscribe(const std::string& topic,
                                                      const dds_topic_descriptor_t& type,
                                                      const Ros2Qos& qos,
                                                      Ros2Subscription::Handler handler) {
  ASSIGN_OR_RETURN(const DdsEntity made, MakeTopic(topic, type));
  auto subscription = std::make_unique<Ros2Subscription>();
  subscription->topic_ = topic;
  subscription->type_ = type.m_typename;
  subscription->qos_ = qos;
  subscription->handler_ = std::move(handler);
  subscription->reader_ =
      DdsEntity(dds_create_reader(participant_.get(), made.get(), MakeDdsQos(qos).get(), nullptr));
  const dds_entity_t reader = subscription->reader_.get();
  if (reader < 0) return DdsError("a reader of " + topic, reader);
  const absl::MutexLock lock(&mutex_);
  Ros2Subscription* const added = subscription.get();
  subscriptions_.push_back(std::move(subscription));
  Announce();
  // From here on the node's thread may call the handler.
  dds_set_status_mask(reader, DDS_DATA_AVAILABLE_STATUS);
  dds_waitset_attach(waitset_.get(), reader, reinterpret_cast<dds_attach_t>(added));
  return added;
}

absl::StatusOr<Ros2Publisher*> Ros2Node::Advertise(const std::string& topic,
                                                   const dds_topic_descriptor_t& type,
                                                   const Ros2Qos& qos) {
  ASSIGN_OR_RETURN(const DdsEntity made, MakeTopic(topic, type));
  auto publisher = std::make_unique<Ros2Publisher>();
  publisher->topic_ = topic;
  publisher->writer_ =
      DdsEntity(dds_create_writer(participant_.get(), made.get(), MakeDdsQos(qos).get(), nullptr));
  if (publisher->writer_.get() < 0) {
    return DdsError("a writer of " + topic, publisher->writer_.get());
  }
  const absl::MutexLock lock(&mutex_);
  publishers_.push_back(std::move(publisher));
  Announce();
  return publishers_.back().get();
}

void Ros2Node::Announce() {
  Ros2NodeInfo info{options_.name, options_.node_namespace, {}, {}, {}};
  dds_get_guid(participant_.get(), &info.participant);
  for (const auto& subscription : subscriptions_) {
    dds_get_guid(subscription->reader_.get(), &info.readers.emplace_back());
  }
  for (const auto& publisher : publishers_) {
    dds_get_guid(publisher->writer_.get(), &info.writers.emplace_back());
  }
  const dds_return_t code = WriteDiscovery(discovery_.get(), options_.is_humble, info);
  if (code != DDS_RETCODE_OK) {
    LOG(WARNING) << "ros2: ros_discovery_info was not sent: " << dds_strretcode(code);
  }
}

void Ros2Node::Run() {
  constexpr size_t kMost = 64;
  while (!stops_) {
    dds_attach_t triggered[kMost];
    const dds_return_t count = dds_waitset_wait(waitset_.get(), triggered, kMost, DDS_SECS(1));
    if (count < 0) {
      LOG(ERROR) << "ros2: waiting for messages failed: " << dds_strretcode(count);
      return;
    }
    for (size_t i = 0; i < std::min(static_cast<size_t>(count), kMost) && !stops_; ++i) {
      // 0 is of the condition that wakes.
      auto* const subscription = reinterpret_cast<Ros2Subscription*>(triggered[i]);
      if (subscription != nullptr) subscription->TakeAll();
    }
  }
}

}  // namespace corbslam::client_agent
