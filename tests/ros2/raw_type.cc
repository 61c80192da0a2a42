#include "tests/ros2/raw_type.h"

#include <cstring>

namespace corbslam::tests {

using eprosima::fastrtps::rtps::SerializedPayload_t;

namespace {

constexpr uint32_t kUsual = 64 * 1024;  // Larger samples are allocated as they come.

}  // namespace

RawType::RawType(const std::string& dds_type) {
  setName(dds_type.c_str());
  m_typeSize = kUsual;
  m_isGetKeyDefined = false;
  auto_fill_type_information(false);
  auto_fill_type_object(false);
}

bool RawType::serialize(void* sample, SerializedPayload_t* payload) {
  const auto& bytes = *static_cast<const std::string*>(sample);
  if (bytes.size() < 4 || bytes.size() > payload->max_size) return false;
  payload->encapsulation = bytes[1] == 0 ? CDR_BE : CDR_LE;
  std::memcpy(payload->data, bytes.data(), bytes.size());
  payload->length = static_cast<uint32_t>(bytes.size());
  return true;
}

bool RawType::deserialize(SerializedPayload_t* payload, void* sample) {
  static_cast<std::string*>(sample)->assign(reinterpret_cast<const char*>(payload->data),
                                            payload->length);
  return true;
}

std::function<uint32_t()> RawType::getSerializedSizeProvider(void* sample) {
  return
      [sample] { return static_cast<uint32_t>(static_cast<const std::string*>(sample)->size()); };
}

}  // namespace corbslam::tests
