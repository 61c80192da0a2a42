#include "client_agent/agent/others_words.h"

#include <string>

#include "absl/strings/str_format.h"

namespace corbslam::client_agent {

SourceFinding DescribeOthers(const OthersNews& news) {
  const std::string local_map = ToString(news.local_map);
  if (!news.contradicts) {
    return {FindingLevel::kWarning, "others-fit-again",
            absl::StrFormat("what local map %s has of this place fits what the robot sees again, "
                            "and is used",
                            local_map)};
  }
  return {FindingLevel::kWarning, "others-contradict",
          absl::StrFormat("what local map %s has of this place contradicts what the robot sees: "
                          "its points miss the pictures by %.1f times as much as own ones. The "
                          "robot does not drive by it until it fits",
                          local_map, news.deviations)};
}

}  // namespace corbslam::client_agent
