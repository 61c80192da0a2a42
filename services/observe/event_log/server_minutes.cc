#include "services/observe/event_log/server_minutes.h"

#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"

namespace corbslam::services {
namespace {

std::string Count(uint64_t count, const char* what) {
  return absl::StrCat(count, " ", what, count == 1 ? "" : "s");
}

std::vector<std::string> TroublesOf(const StoreMinute& minute) {
  std::vector<std::string> troubles;
  if (!minute.writable.ok()) {
    troubles.push_back(absl::StrCat("takes nothing in: ", minute.writable.message()));
  }
  if (minute.damaged_missions > 0) {
    troubles.push_back(absl::StrCat(Count(minute.damaged_missions, "mission"), " damaged"));
  }
  if (minute.outage.has_value()) {
    troubles.push_back(
        absl::StrCat("no fusion worker for ",
                     absl::FormatDuration(absl::Trunc(minute.outage->lasts, absl::Seconds(1))),
                     ": ", minute.outage->cause));
  } else if (!minute.has_worker) {
    troubles.push_back("has no fusion worker");
  }
  if (minute.refused > 0) {
    troubles.push_back(
        absl::StrCat(Count(minute.refused, "time"), " something was refused for want of memory"));
  }
  return troubles;
}

std::string DescribeKeyframes(const StoreMinute& minute) {
  return absl::StrCat(Count(minute.keyframes, "keyframe"), " (",
                      absl::StrFormat("%+d", minute.new_keyframes), ") in ",
                      Count(minute.missions, "mission"));
}

std::string DescribeMemory(const StoreMinute& minute) {
  return absl::StrCat(
      "memory ", FormatBytes(minute.rss_bytes),
      minute.memory_budget_bytes == 0
          ? ""
          : absl::StrFormat(" of %s (%.0f %%)", FormatBytes(minute.memory_budget_bytes),
                            100.0 * static_cast<double>(minute.rss_bytes) /
                                static_cast<double>(minute.memory_budget_bytes)));
}

}  // namespace

std::string FormatBytes(uint64_t bytes) {
  const double mib = static_cast<double>(bytes) / (1 << 20);
  return mib < 10000 ? absl::StrFormat("%.1f MiB", mib) : absl::StrFormat("%.1f GiB", mib / 1024);
}

std::string FormatMinute(const StoreMinute& minute) {
  std::vector<std::string> parts = TroublesOf(minute);
  parts.push_back(absl::StrCat(Count(minute.robots, "robot"), " connected"));
  parts.push_back(DescribeKeyframes(minute));
  parts.push_back(Count(minute.waiting_requests, "fusion request") +
                  (minute.waiting_requests == 1 ? " waits" : " wait"));
  parts.push_back(DescribeMemory(minute));
  if (minute.disk.has_value()) {
    parts.push_back(absl::StrCat("disk ", FormatBytes(minute.disk->used_bytes), ", ",
                                 FormatBytes(minute.disk->free_bytes), " free"));
  }
  return absl::StrJoin(parts, "; ");
}

std::string FormatMinute(const WorkerMinute& minute) {
  const double took_s = absl::ToDoubleSeconds(minute.took);
  std::vector<std::string> parts;
  if (minute.failed > 0) parts.push_back(Count(minute.failed, "request") + " failed");
  parts.push_back(Count(minute.done, "request") + " done");
  if (minute.cancelled > 0) parts.push_back(Count(minute.cancelled, "request") + " cancelled");
  parts.push_back(absl::StrCat(minute.held, " held, of which ", minute.waiting,
                               minute.waiting == 1 ? " waits" : " wait"));
  parts.push_back(
      absl::StrFormat("%.1f processors busy", took_s > 0 ? minute.cpu_s / took_s : 0.0));
  parts.push_back("memory " + FormatBytes(minute.rss_bytes));
  return absl::StrJoin(parts, "; ");
}

std::string FormatMinute(const ViewerMinute& minute) {
  return absl::StrCat(minute.store_answers ? "" : "the map store is not reached; ",
                      Count(minute.pages, "page"), " open; ", Count(minute.missions, "mission"),
                      " followed; memory ", FormatBytes(minute.rss_bytes));
}

}  // namespace corbslam::services
