// dds_peer plays messages over DDS, or writes down what it hears, by Fast DDS and with ROS 2's
// names: the other side of corbslam_ros2 in tests.
//
//   dds_peer play MESSAGES [--map /from=/to]... [--reliable] [--speed S] [--shift-s N] [--await S]
//   [--sent FILE] dds_peer hear OUT TOPIC=TYPE[,best_effort][,latched]... --seconds S
#include <CLI/CLI.hpp>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/Topic.hpp>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "tests/ros2/message_file.h"
#include "tests/ros2/raw_type.h"

namespace corbslam::tests {
namespace {

namespace dds = eprosima::fastdds::dds;
using eprosima::fastrtps::types::ReturnCode_t;

constexpr int32_t kNsOfSecond = 1'000'000'000;
constexpr char kClock[] = "rosgraph_msgs/msg/Clock";

std::atomic<bool> stopped = false;
void OnSignal(int) { stopped = true; }

// ROS 2's topics have "rt" before their name; others are named as they are by "dds:".
std::string DdsTopicOf(const std::string& topic) {
  return absl::StartsWith(topic, "dds:") ? topic.substr(4) : "rt" + topic;
}

class Peer {
 public:
  explicit Peer(int domain) {
    dds::DomainParticipantQos qos = dds::PARTICIPANT_QOS_DEFAULT;
    qos.name("dds_peer");
    participant_ = dds::DomainParticipantFactory::get_instance()->create_participant(
        static_cast<dds::DomainId_t>(domain), qos);
    publisher_ = participant_->create_publisher(dds::PUBLISHER_QOS_DEFAULT);
    subscriber_ = participant_->create_subscriber(dds::SUBSCRIBER_QOS_DEFAULT);
  }
  ~Peer() {
    participant_->delete_contained_entities();
    dds::DomainParticipantFactory::get_instance()->delete_participant(participant_);
  }

  dds::DataWriter* Write(const std::string& topic, const std::string& type, bool reliable,
                         bool latched) {
    dds::DataWriterQos qos = dds::DATAWRITER_QOS_DEFAULT;
    qos.reliability().kind =
        reliable ? dds::RELIABLE_RELIABILITY_QOS : dds::BEST_EFFORT_RELIABILITY_QOS;
    qos.durability().kind =
        latched ? dds::TRANSIENT_LOCAL_DURABILITY_QOS : dds::VOLATILE_DURABILITY_QOS;
    qos.history().depth = 10;
    // As ROS 2's middleware has it.
    qos.publish_mode().kind = dds::ASYNCHRONOUS_PUBLISH_MODE;
    qos.endpoint().history_memory_policy =
        eprosima::fastrtps::rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    return publisher_->create_datawriter(MakeTopic(topic, type), qos);
  }
  dds::DataReader* Read(const std::string& topic, const std::string& type, bool reliable,
                        bool latched) {
    dds::DataReaderQos qos = dds::DATAREADER_QOS_DEFAULT;
    qos.reliability().kind =
        reliable ? dds::RELIABLE_RELIABILITY_QOS : dds::BEST_EFFORT_RELIABILITY_QOS;
    qos.durability().kind =
        latched ? dds::TRANSIENT_LOCAL_DURABILITY_QOS : dds::VOLATILE_DURABILITY_QOS;
    qos.history().kind = dds::KEEP_ALL_HISTORY_QOS;
    qos.endpoint().history_memory_policy =
        eprosima::fastrtps::rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    return subscriber_->create_datareader(MakeTopic(topic, type), qos);
  }

 private:
  dds::Topic* MakeTopic(const std::string& topic, const std::string& type) {
    const std::string dds_type = DdsTypeOf(type);
    if (types_.count(dds_type) == 0) {
      types_.emplace(dds_type, dds::TypeSupport(new RawType(dds_type)));
      types_.at(dds_type).register_type(participant_);
    }
    return participant_->create_topic(DdsTopicOf(topic), dds_type, dds::TOPIC_QOS_DEFAULT);
  }

  dds::DomainParticipant* participant_ = nullptr;
  dds::Publisher* publisher_ = nullptr;
  dds::Subscriber* subscriber_ = nullptr;
  std::map<std::string, dds::TypeSupport> types_;
};

struct PlayOptions {
  std::string messages;
  std::vector<std::string> maps;
  bool reliable = false;
  bool clock = false;
  double speed = 1;
  int64_t shift_s = 0;
  double await_s = 30;
  std::string sent;
};

// Adds seconds to a message whose first field is a header; little-endian, as Foxglove writes.
void ShiftStamp(int64_t shift_s, CdrMessage& message) {
  if (message.type == "tf2_msgs/msg/TFMessage" || message.bytes.size() < 12) return;
  int32_t seconds = 0;
  std::memcpy(&seconds, &message.bytes[4], sizeof(seconds));
  seconds += static_cast<int32_t>(shift_s);
  std::memcpy(&message.bytes[4], &seconds, sizeof(seconds));
}

int64_t StampOf(const CdrMessage& message) {
  int32_t seconds = 0;
  uint32_t nanoseconds = 0;
  std::memcpy(&seconds, &message.bytes[4], sizeof(seconds));
  std::memcpy(&nanoseconds, &message.bytes[8], sizeof(nanoseconds));
  return int64_t{seconds} * kNsOfSecond + nanoseconds;
}

std::string ClockMessage(int64_t time_ns) {
  std::string bytes(12, '\0');
  bytes[1] = 1;
  const auto seconds = static_cast<int32_t>(time_ns / kNsOfSecond);
  const auto rest = static_cast<uint32_t>(time_ns % kNsOfSecond);
  std::memcpy(&bytes[4], &seconds, 4);
  std::memcpy(&bytes[8], &rest, 4);
  return bytes;
}

bool AwaitReaders(const std::map<std::string, dds::DataWriter*>& writers, double await_s) {
  const absl::Time deadline = absl::Now() + absl::Seconds(await_s);
  for (const auto& [topic, writer] : writers) {
    dds::PublicationMatchedStatus status;
    do {
      writer->get_publication_matched_status(status);
      if (status.current_count > 0) break;
      absl::SleepFor(absl::Milliseconds(50));
    } while (absl::Now() < deadline && !stopped);
    if (status.current_count == 0) std::fprintf(stderr, "nobody reads %s\n", topic.c_str());
  }
  return absl::Now() < deadline;
}

int Play(Peer& peer, const PlayOptions& options) {
  auto messages = ReadMessages(options.messages);
  if (!messages.ok()) {
    std::fprintf(stderr, "%s\n", messages.status().ToString().c_str());
    return 1;
  }
  std::map<std::string, std::string> maps;
  for (const std::string& map : options.maps) {
    const std::pair<std::string, std::string> parts = absl::StrSplit(map, absl::MaxSplits('=', 1));
    maps.insert(parts);
  }
  std::map<std::string, dds::DataWriter*> writers;
  for (CdrMessage& message : *messages) {
    if (const auto mapped = maps.find(message.topic); mapped != maps.end()) {
      message.topic = mapped->second;
    }
    ShiftStamp(options.shift_s, message);
    dds::DataWriter*& writer = writers[message.topic];
    const bool latched = absl::EndsWith(message.topic, "tf_static");
    if (writer == nullptr) {
      writer = peer.Write(message.topic, message.type, options.reliable || latched, latched);
    }
  }
  AwaitReaders(writers, options.await_s);
  // Readers know their writers, too, by then: what comes before has to wait for a heartbeat.
  absl::SleepFor(absl::Milliseconds(500));
  dds::DataWriter* const clock =
      options.clock ? peer.Write("/clock", kClock, true, false) : nullptr;
  std::ofstream sent(options.sent.empty() ? "/dev/null" : options.sent);
  const absl::Time begin = absl::Now();
  const int64_t first_ns = messages->front().time_ns;
  for (CdrMessage& message : *messages) {
    if (stopped) return 0;
    const absl::Duration after =
        absl::Nanoseconds(static_cast<double>(message.time_ns - first_ns) / options.speed);
    absl::SleepFor(begin + after - absl::Now());
    if (clock != nullptr && message.type != "tf2_msgs/msg/TFMessage") {
      std::string now = ClockMessage(StampOf(message));
      clock->write(&now);
    }
    writers[message.topic]->write(&message.bytes);
    sent << message.topic << " " << StampOf(message) << " " << absl::GetCurrentTimeNanos() << "\n";
  }
  // What is on its way arrives before the writers go.
  absl::SleepFor(absl::Seconds(1));
  return 0;
}

struct Heard {
  std::string topic;
  std::string type;
  dds::DataReader* reader = nullptr;
};

int Hear(Peer& peer, const std::string& out, const std::vector<std::string>& topics,
         double seconds) {
  std::vector<Heard> heard;
  for (const std::string& text : topics) {
    const std::pair<std::string, std::string> parts = absl::StrSplit(text, absl::MaxSplits('=', 1));
    const std::vector<std::string> words = absl::StrSplit(parts.second, ',');
    bool reliable = true;
    bool latched = false;
    for (const std::string& word : words) {
      reliable &= word != "best_effort";
      latched |= word == "latched";
    }
    heard.push_back({parts.first, words[0], peer.Read(parts.first, words[0], reliable, latched)});
  }
  MessageFile file(out);
  std::map<std::string, uint64_t> counts;
  const absl::Time deadline = absl::Now() + absl::Seconds(seconds);
  while (absl::Now() < deadline && !stopped) {
    for (Heard& one : heard) {
      std::string sample;
      dds::SampleInfo info;
      while (one.reader->take_next_sample(&sample, &info) == ReturnCode_t::RETCODE_OK) {
        if (!info.valid_data) continue;
        ++counts[one.topic];
        file.Add({one.topic, one.type, absl::GetCurrentTimeNanos(), sample});
      }
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  for (const Heard& one : heard) {
    std::printf("%s %llu\n", one.topic.c_str(), static_cast<unsigned long long>(counts[one.topic]));
  }
  return 0;
}

int Main(int argc, char** argv) {
  CLI::App app("Plays and hears messages of ROS 2 by Fast DDS");
  int domain = 0;
  if (const char* const id = std::getenv("ROS_DOMAIN_ID"); id != nullptr) domain = std::atoi(id);
  app.require_subcommand(1);
  PlayOptions options;
  CLI::App* const play = app.add_subcommand("play", "publishes a file's messages at their pace");
  play->add_option("messages", options.messages)->required();
  play->add_option("--map", options.maps, "/from=/to");
  play->add_flag("--reliable", options.reliable);
  play->add_flag("--clock", options.clock, "publishes /clock");
  play->add_option("--speed", options.speed);
  play->add_option("--shift-s", options.shift_s, "is added to the stamps of headers");
  play->add_option("--await", options.await_s, "seconds to wait for readers");
  play->add_option("--sent", options.sent, "file: topic, stamp, time of sending");
  std::string out;
  std::vector<std::string> topics;
  double seconds = 10;
  CLI::App* const hear = app.add_subcommand("hear", "writes down what comes");
  hear->add_option("out", out)->required();
  hear->add_option("topics", topics, "TOPIC=TYPE[,best_effort][,latched]")->required();
  hear->add_option("--seconds", seconds);
  CLI11_PARSE(app, argc, argv);
  std::signal(SIGTERM, OnSignal);
  std::signal(SIGINT, OnSignal);
  Peer peer(domain);
  return play->parsed() ? Play(peer, options) : Hear(peer, out, topics, seconds);
}

}  // namespace
}  // namespace corbslam::tests

int main(int argc, char** argv) { return corbslam::tests::Main(argc, argv); }
