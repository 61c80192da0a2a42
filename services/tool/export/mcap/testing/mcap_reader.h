// Reads MCAP files for tests, and checks what a reader may rely on.
#ifndef CORBSLAM_SERVICES_TOOL_EXPORT_MCAP_TESTING_MCAP_READER_H_
#define CORBSLAM_SERVICES_TOOL_EXPORT_MCAP_TESTING_MCAP_READER_H_

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace corbslam::testing {

struct McapFile {
  struct Schema {
    std::string name;
    std::string data;
  };
  struct Message {
    std::string topic;
    std::string schema;
    uint64_t time_ns = 0;
    std::string data;
  };
  std::map<uint16_t, Schema> schemas;
  std::vector<Message> messages;  // As they stand in the file.
  std::map<std::string, std::map<std::string, std::string>> metadata;
  std::vector<uint64_t> chunk_bytes;
  uint64_t message_count = 0;  // As the statistics say; so are the next two.
  uint64_t first_ns = 0;
  uint64_t last_ns = 0;

  std::vector<Message> On(const std::string& topic) const;
};

// Reads the file from its beginning to its end. DATA_LOSS says what is wrong: a checksum, a length,
// an index that leads to something else, counts that don't agree.
absl::StatusOr<McapFile> ReadMcap(const std::string& path);

}  // namespace corbslam::testing

#endif  // CORBSLAM_SERVICES_TOOL_EXPORT_MCAP_TESTING_MCAP_READER_H_
