#include "client_agent/source/bag/bag_frames.h"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client_agent/source/lists/timeline.h"
#include "slam/util/status_macros.h"
#include "slam/util/text_file.h"

namespace corbslam::client_agent {
namespace {

// A message with the time that counts.
struct Stamped {
  int64_t time_ns = 0;
  int drive = 0;
  const PictureMessage* message = nullptr;
};
using StampedList = std::vector<Stamped>;

constexpr size_t kMostToldJumps = 5;
constexpr int64_t kEarlySecond_ns = 20'000'000;

void Warn(absl::string_view code, std::string text, SourceRemarks& remarks) {
  remarks.findings.push_back({FindingLevel::kWarning, std::string(code), std::move(text)});
}

void LeaveOut(absl::string_view code, const std::string& text, SourceRemarks& remarks) {
  remarks.left_out.push_back(text);
  Warn(code, text, remarks);
}

std::string NameOf(const BagPublisher& publisher) {
  return absl::StrCat(publisher.node.empty() ? "" : absl::StrCat("node ", publisher.node, ", "),
                      "frame '", publisher.frame_id, "', ", publisher.messages, " messages");
}

bool AreAtOnce(const BagPublisher& a, const BagPublisher& b) {
  return a.messages > 0 && b.messages > 0 && a.first_ns < b.last_ns && b.first_ns < a.last_ns;
}

// Returns which publishers are left out: those that send at the same time as one with more
// messages.
std::vector<bool> LeftOutPublishers(const FramePairing& pairing, const BagTopic& topic,
                                    SourceRemarks& remarks) {
  const std::vector<BagPublisher>& all = topic.publishers;
  std::vector<size_t> order(all.size());
  for (size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return all[a].messages > all[b].messages; });
  std::vector<bool> left_out(all.size(), false);
  for (size_t i = 0; i < order.size(); ++i) {
    for (size_t k = 0; k < i && !left_out[order[i]]; ++k) {
      if (left_out[order[k]] || !AreAtOnce(all[order[i]], all[order[k]])) continue;
      left_out[order[i]] = true;
      LeaveOut("bag-two-publishers",
               absl::StrCat(pairing.bag, ": ", topic.name, ": two publishers at the same time (",
                            NameOf(all[order[k]]), "; ", NameOf(all[order[i]]),
                            "): the second one's pictures are left out"),
               remarks);
    }
  }
  return left_out;
}

StampedList TakePublished(const FramePairing& pairing, const BagTopic& topic,
                          SourceRemarks& remarks) {
  const std::vector<bool> left_out = LeftOutPublishers(pairing, topic, remarks);
  StampedList list;
  for (const PictureMessage& message : topic.pictures) {
    if (!left_out[message.publisher]) list.push_back({message.stamp_ns, 0, &message});
  }
  std::stable_sort(list.begin(), list.end(), [](const Stamped& a, const Stamped& b) {
    return a.message->recorded_ns < b.message->recorded_ns;
  });
  return list;
}

bool IsUnstamped(const StampedList& list) {
  const auto zeros =
      std::count_if(list.begin(), list.end(), [](const Stamped& one) { return one.time_ns == 0; });
  return list.size() > 1 && 2 * static_cast<size_t>(zeros) > list.size();
}

void TellJump(const FramePairing& pairing, int64_t from_ns, int64_t to_ns, SourceRemarks& remarks) {
  Warn("times-jump-back",
       absl::StrCat(pairing.bag, ": the time jumps back from ", FormatSeconds(from_ns), " s to ",
                    FormatSeconds(to_ns),
                    " s (a bag that was recorded while another one was played twice?): a new local "
                    "map begins here"),
       remarks);
}

void StampByRecording(StampedList& list) {
  for (Stamped& one : list) one.time_ns = one.message->recorded_ns;
}

// Numbers the drives by the first topic's times. The second one's may be of another clock: they are
// of the drive that was recorded when they came.
void NumberDrives(const FramePairing& pairing, StampedList& first, StampedList& second,
                  SourceRemarks& remarks) {
  std::vector<int64_t> began_ns;  // When each drive but the first began, by the recorder's time.
  int64_t latest_ns = first.empty() ? 0 : first.front().time_ns;
  for (Stamped& next : first) {
    if (next.time_ns < latest_ns - kJumpBack_ns) {
      if (began_ns.size() < kMostToldJumps) TellJump(pairing, latest_ns, next.time_ns, remarks);
      began_ns.push_back(next.message->recorded_ns);
      latest_ns = next.time_ns;
    }
    latest_ns = std::max(latest_ns, next.time_ns);
    next.drive = static_cast<int>(began_ns.size());
  }
  for (Stamped& next : second) {
    // A pair's second picture may come before its first one.
    const auto drives = std::upper_bound(began_ns.begin(), began_ns.end(),
                                         next.message->recorded_ns + kEarlySecond_ns);
    next.drive = static_cast<int>(drives - began_ns.begin());
  }
}

bool IsBefore(const Stamped& a, const Stamped& b) {
  return std::pair(a.drive, a.time_ns) < std::pair(b.drive, b.time_ns);
}

bool IsRepeated(const Stamped& a, const Stamped& b) {
  return a.drive == b.drive && a.time_ns == b.time_ns;
}

// Puts each drive in the order of time, each time once.
void PutInOrder(const FramePairing& pairing, const BagTopic& topic, StampedList& list,
                SourceRemarks& remarks) {
  size_t late = 0;
  for (size_t i = 1; i < list.size(); ++i) late += IsBefore(list[i], list[i - 1]) ? 1 : 0;
  if (late > 0) {
    std::stable_sort(list.begin(), list.end(), IsBefore);
    Warn("times-out-of-order",
         absl::StrCat(pairing.bag, ": ", topic.name, ": ", late, " of ", list.size(),
                      " pictures came behind a later one; they are played in the order of time"),
         remarks);
  }
  const size_t all = list.size();
  list.erase(std::unique(list.begin(), list.end(), IsRepeated), list.end());
  if (list.size() < all) {
    LeaveOut("times-repeat",
             absl::StrCat(pairing.bag, ": ", topic.name, ": ", all - list.size(), " of ", all,
                          " pictures have the time of the one before: these are left out"),
             remarks);
  }
  const size_t negative = std::erase_if(list, [](const Stamped& one) { return one.time_ns < 0; });
  if (negative == 0) return;
  LeaveOut("times-negative",
           absl::StrCat(pairing.bag, ": ", topic.name, ": ", negative, " of ", all,
                        " pictures have a time before 1970: these are left out"),
           remarks);
}

// Pairs what is nearest in time. Both lists are in order.
std::vector<BagFrame> PairInTime(const StampedList& first, const StampedList& second,
                                 const FramePairing& pairing) {
  // Another drive is further off than any time.
  const auto gap_ns = [&](size_t i, size_t k) {
    const int64_t apart_ns = first[i].time_ns - second[k].time_ns - pairing.second_offset_ns;
    constexpr int64_t kDrive_ns = INT64_MAX / 4;
    const auto drives = int64_t{std::min(std::abs(first[i].drive - second[k].drive), 2)};
    return std::min(std::abs(apart_ns), kDrive_ns) + drives * kDrive_ns;
  };
  std::vector<BagFrame> frames;
  size_t k = 0;
  for (size_t i = 0; i < first.size() && k < second.size(); ++i) {
    while (k + 1 < second.size() && gap_ns(i, k + 1) < gap_ns(i, k)) ++k;
    // The next first picture is nearer to this second one.
    if (i + 1 < first.size() && gap_ns(i + 1, k) < gap_ns(i, k)) continue;
    if (gap_ns(i, k) > pairing.within_ns) continue;
    frames.push_back(
        {first[i].time_ns, first[i].drive, first[i].message->place, second[k].message->place});
    ++k;
  }
  return frames;
}

std::string SpanOf(const StampedList& list) {
  if (list.empty()) return "none";
  return absl::StrCat(list.size(), " from ", FormatSeconds(list.front().time_ns), " to ",
                      FormatSeconds(list.back().time_ns), " s");
}

absl::Status NoFrames(const FramePairing& pairing, const BagTopic& first_topic,
                      const StampedList& first, const BagTopic& second_topic,
                      const StampedList& second) {
  return absl::InvalidArgumentError(absl::StrCat(
      pairing.bag, ": no picture of ", first_topic.name, " has one of ", second_topic.name,
      " within ", 1e-6 * static_cast<double>(pairing.within_ns), " ms: ", first_topic.name, " has ",
      SpanOf(first), ", ", second_topic.name, " has ", SpanOf(second), "; try ?time=",
      pairing.by_recording_time ? "header" : "recording", ", or a larger ?pair-within-ms"));
}

void TellUnpaired(const FramePairing& pairing, const BagTopic& first_topic, size_t first,
                  const BagTopic& second_topic, size_t second, size_t frames,
                  SourceRemarks& remarks) {
  if (first == frames && second == frames) return;
  LeaveOut("pairs-incomplete",
           absl::StrCat(first - frames, " of ", first, " pictures of ", first_topic.name, " and ",
                        second - frames, " of ", second, " of ", second_topic.name,
                        " have no counterpart within ",
                        1e-6 * static_cast<double>(pairing.within_ns), " ms (?pair-within-ms)"),
           remarks);
}

void TellUnreadable(const FramePairing& pairing, const BagTopic& topic, SourceRemarks& remarks) {
  if (topic.unreadable == 0) return;
  LeaveOut("pictures-unreadable",
           absl::StrCat(pairing.bag, ": ", topic.name, ": of ", topic.unreadable, " of ",
                        topic.messages, " messages the header can't be read"),
           remarks);
}

void TellUnstamped(const FramePairing& pairing, const BagTopic& topic, SourceRemarks& remarks) {
  Warn("bag-unstamped",
       absl::StrCat(pairing.bag, ": ", topic.name,
                    ": headers have the time 0: the recorder's times are taken, which hold what "
                    "the way from the camera took"),
       remarks);
}

}  // namespace

absl::StatusOr<BagFrames> MakeBagFrames(const BagTopic& first_topic, const BagTopic& second_topic,
                                        const FramePairing& pairing, SourceRemarks& remarks) {
  StampedList first = TakePublished(pairing, first_topic, remarks);
  StampedList second = TakePublished(pairing, second_topic, remarks);
  TellUnreadable(pairing, first_topic, remarks);
  TellUnreadable(pairing, second_topic, remarks);
  BagFrames made;
  made.by_recording_time = pairing.by_recording_time;
  if (!made.by_recording_time && (IsUnstamped(first) || IsUnstamped(second))) {
    made.by_recording_time = true;
    TellUnstamped(pairing, IsUnstamped(first) ? first_topic : second_topic, remarks);
  }
  if (made.by_recording_time) {
    StampByRecording(first);
    StampByRecording(second);
  }
  NumberDrives(pairing, first, second, remarks);
  PutInOrder(pairing, first_topic, first, remarks);
  PutInOrder(pairing, second_topic, second, remarks);
  made.frames = PairInTime(first, second, pairing);
  if (made.frames.empty()) return NoFrames(pairing, first_topic, first, second_topic, second);
  TellUnpaired(pairing, first_topic, first.size(), second_topic, second.size(), made.frames.size(),
               remarks);
  return made;
}

}  // namespace corbslam::client_agent
