// A node of ROS 2 on DDS: its topics, and a thread that hears them.
#ifndef CORBSLAM_CLIENT_AGENT_ROS2_ROS2_NODE_H_
#define CORBSLAM_CLIENT_AGENT_ROS2_ROS2_NODE_H_

#include <dds/dds.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "absl/synchronization/mutex.h"
#include "client_agent/ros2/ros2_qos.h"

namespace corbslam::client_agent {

// An entity of DDS, with all that was made of it.
class DdsEntity {
 public:
  DdsEntity() = default;
  explicit DdsEntity(dds_entity_t entity) : entity_(entity) {}
  DdsEntity(DdsEntity&& other) noexcept : entity_(std::exchange(other.entity_, 0)) {}
  DdsEntity& operator=(DdsEntity&& other) noexcept {
    std::swap(entity_, other.entity_);
    return *this;
  }
  ~DdsEntity() {
    if (entity_ > 0) dds_delete(entity_);
  }
  dds_entity_t get() const { return entity_; }

 private:
  dds_entity_t entity_ = 0;
};

// How a topic that is read is doing.
struct Ros2Hearing {
  uint32_t publishers = 0;  // That match.
  // Publishers of the topic and the type that offer another quality than is wanted; what they
  // lack: "reliability", "durability".
  uint32_t incompatible = 0;
  std::string lacking;
  uint64_t messages = 0;
};

// Thread-safe.
class Ros2Subscription {
 public:
  using Handler = std::function<void(const void* sample)>;

  const std::string& topic() const { return topic_; }  // DDS's name of it.
  const std::string& type() const { return type_; }    // Likewise.
  const Ros2Qos& qos() const { return qos_; }
  Ros2Hearing Hearing() const;

 private:
  friend class Ros2Node;
  // Hands over what waits. Only the node's thread calls it.
  void TakeAll();

  std::string topic_;
  std::string type_;
  Ros2Qos qos_;
  Handler handler_;
  DdsEntity reader_;
  std::atomic<uint64_t> messages_ = 0;
};

// Thread-safe.
class Ros2Publisher {
 public:
  // `sample` is of the type that the topic was advertised with. What can't be sent is logged once.
  void Publish(const void* sample);
  bool HasReaders() const;
  const std::string& topic() const { return topic_; }  // DDS's name of it.

 private:
  friend class Ros2Node;
  std::string topic_;
  DdsEntity writer_;
  std::atomic<bool> has_failed_ = false;
};

struct Ros2NodeOptions {
  std::string name = "visual_slam";
  std::string node_namespace = "/";
  uint32_t domain = 0;          // ROS_DOMAIN_ID.
  bool only_this_host = false;  // ROS_LOCALHOST_ONLY.
  // ROS_DISTRO is humble, whose ids of nodes have another size.
  bool is_humble = false;
};

// Tells all participants of ROS 2 that it is there (ros_discovery_info). Thread-safe. Handlers are
// called one after the other on the node's thread, from Subscribe until the node's end, and must
// return soon.
class Ros2Node {
 public:
  // UNAVAILABLE where DDS finds no network, with its words.
  static absl::StatusOr<std::unique_ptr<Ros2Node>> Create(const Ros2NodeOptions& options);
  ~Ros2Node();

  // `topic` is DDS's name (ros2_names.h). What is returned is the node's.
  absl::StatusOr<Ros2Subscription*> Subscribe(const std::string& topic,
                                              const dds_topic_descriptor_t& type,
                                              const Ros2Qos& qos, Ros2Subscription::Handler handler)
      ABSL_LOCKS_EXCLUDED(mutex_);
  absl::StatusOr<Ros2Publisher*> Advertise(const std::string& topic,
                                           const dds_topic_descriptor_t& type, const Ros2Qos& qos)
      ABSL_LOCKS_EXCLUDED(mutex_);

  // Ends the thread: no handler is called any more.
  void Stop();
  const Ros2NodeOptions& options() const { return options_; }
  dds_entity_t participant() const { return participant_.get(); }

 private:
  explicit Ros2Node(const Ros2NodeOptions& options) : options_(options) {}
  absl::Status Begin();
  absl::StatusOr<DdsEntity> MakeTopic(const std::string& topic, const dds_topic_descriptor_t& type);
  // Says anew which topics the node has.
  void Announce() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Run();

  const Ros2NodeOptions options_;
  DdsEntity domain_;
  DdsEntity participant_;
  DdsEntity waitset_;
  DdsEntity wake_;
  DdsEntity discovery_;
  std::atomic<bool> stops_ = false;
  std::thread thread_;

  absl::Mutex mutex_;
  std::vector<std::unique_ptr<Ros2Subscription>> subscriptions_ ABSL_GUARDED_BY(mutex_);
  std::vector<std::unique_ptr<Ros2Publisher>> publishers_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_ROS2_ROS2_NODE_H_
