// A type of Fast DDS whose samples are the bytes that go over the network.
#ifndef CORBSLAM_TESTS_ROS2_RAW_TYPE_H_
#define CORBSLAM_TESTS_ROS2_RAW_TYPE_H_

#include <fastdds/dds/topic/TopicDataType.hpp>
#include <functional>
#include <string>

namespace corbslam::tests {

// Samples are std::string: CDR, its four bytes of representation first. Nothing is interpreted, so
// that what others encoded and decode is what was sent.
class RawType : public eprosima::fastdds::dds::TopicDataType {
 public:
  explicit RawType(const std::string& dds_type);

  bool serialize(void* sample, eprosima::fastrtps::rtps::SerializedPayload_t* payload) override;
  bool deserialize(eprosima::fastrtps::rtps::SerializedPayload_t* payload, void* sample) override;
  std::function<uint32_t()> getSerializedSizeProvider(void* sample) override;
  void* createData() override { return new std::string(); }
  void deleteData(void* sample) override { delete static_cast<std::string*>(sample); }
  bool getKey(void*, eprosima::fastrtps::rtps::InstanceHandle_t*, bool) override { return false; }
};

}  // namespace corbslam::tests

#endif  // CORBSLAM_TESTS_ROS2_RAW_TYPE_H_
