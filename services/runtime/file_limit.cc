#include "services/runtime/file_limit.h"

#include <sys/resource.h>

#include <algorithm>

namespace corbslam::services {
namespace {

// Some systems know no bound, which is more than anybody needs.
constexpr rlim_t kEnough = 1 << 20;
constexpr size_t kLeastOfHost = 64;

}  // namespace

void RaiseFileLimit() {
  rlimit limit = {};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  const rlim_t most = std::min(limit.rlim_max, std::max(kEnough, limit.rlim_cur));
  if (limit.rlim_cur >= most) return;
  limit.rlim_cur = most;
  // Where it can't be, the limits below are smaller.
  static_cast<void>(setrlimit(RLIMIT_NOFILE, &limit));
}

size_t FileLimit() {
  rlimit limit = {};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return 1024;
  return static_cast<size_t>(std::min(limit.rlim_cur, kEnough));
}

ConnectionLimits LimitsWithin(size_t file_limit, const ConnectionLimits& wanted) {
  const size_t all = std::max<size_t>(4, std::min(wanted.all, file_limit / 2));
  const size_t of_host = std::max(all / 4, std::min(all, kLeastOfHost));
  return {.all = all, .of_host = std::min(wanted.of_host, of_host)};
}

}  // namespace corbslam::services
