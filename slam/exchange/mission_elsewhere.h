// Says that another map store has a mission, and where that one is, in a way that a robot can
// follow.
#ifndef CORBSLAM_SLAM_EXCHANGE_MISSION_ELSEWHERE_H_
#define CORBSLAM_SLAM_EXCHANGE_MISSION_ELSEWHERE_H_

#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/strings/cord.h"
#include "absl/strings/string_view.h"

namespace corbslam {

// Where a mission is that this store does not serve.
struct MissionElsewhere {
  std::string address;  // HOST:PORT of the store that has it; empty: nobody knows.
};

inline constexpr char kElsewherePayload[] = "corbslam/mission_elsewhere";

// Returns the error with where the mission is added to it.
inline absl::Status WithElsewhere(absl::Status error, absl::string_view address) {
  if (!error.ok()) error.SetPayload(kElsewherePayload, absl::Cord(address));
  return error;
}

// Returns where the mission is that was asked for; nullopt: the error has another reason.
inline std::optional<MissionElsewhere> FindElsewhere(const absl::Status& status) {
  if (status.ok()) return std::nullopt;
  const auto address = status.GetPayload(kElsewherePayload);
  if (!address.has_value()) return std::nullopt;
  return MissionElsewhere{std::string(*address)};
}

// Returns an error with another message, and with what else the first one says.
inline absl::Status WithMessage(const absl::Status& error, absl::string_view message) {
  absl::Status said(error.code(), message);
  error.ForEachPayload([&said](absl::string_view type, const absl::Cord& payload) {
    said.SetPayload(type, payload);
  });
  return said;
}

}  // namespace corbslam

#endif  // CORBSLAM_SLAM_EXCHANGE_MISSION_ELSEWHERE_H_
