// Sentences about a file, of which a damaged one could give millions.
#ifndef CORBSLAM_CLIENT_AGENT_SOURCE_BAG_FILES_BAG_NOTES_H_
#define CORBSLAM_CLIENT_AGENT_SOURCE_BAG_FILES_BAG_NOTES_H_

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"

namespace corbslam::client_agent {

class BagNotes {
 public:
  void Add(std::string note) {
    if (notes_.size() < kMost) {
      notes_.push_back(std::move(note));
    } else if (notes_.size() == kMost) {
      notes_.push_back("and more of the kind");
    }
  }
  void Add(const absl::Status& error) { Add(std::string(error.message())); }
  const std::vector<std::string>& all() const { return notes_; }

 private:
  static constexpr size_t kMost = 8;
  std::vector<std::string> notes_;
};

}  // namespace corbslam::client_agent

#endif  // CORBSLAM_CLIENT_AGENT_SOURCE_BAG_FILES_BAG_NOTES_H_
