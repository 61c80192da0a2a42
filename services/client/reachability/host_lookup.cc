#include "services/client/reachability/host_lookup.h"

#include <netdb.h>

#include <cstring>
#include <map>
#include <memory>
#include <thread>
#include <utility>

#include "absl/base/thread_annotations.h"
#include "absl/cleanup/cleanup.h"
#include "absl/strings/str_cat.h"
#include "absl/synchronization/mutex.h"
#include "slam/util/named_thread.h"

namespace corbslam::services {
namespace {

using Addresses = std::vector<SocketAddress>;

// One look-up. Its thread and the callers that wait for it share its ownership.
class Lookup {
 public:
  void Finish(absl::StatusOr<Addresses> found) {
    absl::MutexLock lock(&mutex_);
    found_ = std::move(found);
    done_ = true;
  }
  absl::StatusOr<Addresses> Wait(absl::Duration timeout) {
    absl::MutexLock lock(&mutex_);
    if (mutex_.AwaitWithTimeout(absl::Condition(&done_), timeout)) return found_;
    return absl::DeadlineExceededError("no answer");
  }

 private:
  absl::Mutex mutex_;
  bool done_ ABSL_GUARDED_BY(mutex_) = false;
  absl::StatusOr<Addresses> found_ ABSL_GUARDED_BY(mutex_);
};

struct RunningLookups {
  absl::Mutex mutex;
  std::map<std::string, std::shared_ptr<Lookup>> by_host ABSL_GUARDED_BY(mutex);
};

// The map is never destroyed: a look-up may outlive the end of main.
RunningLookups& Running() {
  static auto& running = *new RunningLookups;
  return running;
}

// Returns the look-up of this host that runs, or starts a new one.
std::shared_ptr<Lookup> Start(const HostPort& address, const ResolveHost& resolve) {
  RunningLookups& running = Running();
  const std::string key = ToString(address);
  absl::MutexLock lock(&running.mutex);
  std::shared_ptr<Lookup>& lookup = running.by_host[key];
  if (lookup != nullptr) return lookup;
  lookup = std::make_shared<Lookup>();
  StartThread("host look-up", [address, resolve, key, lookup = lookup] {
    lookup->Finish(resolve(address));
    RunningLookups& all = Running();
    absl::MutexLock ending(&all.mutex);
    all.by_host.erase(key);
  }).detach();
  return lookup;
}

absl::Status ToStatus(int error, const std::string& host) {
  const std::string message = absl::StrCat(host, ": ", gai_strerror(error));
  const bool is_unknown = error == EAI_NONAME || error == EAI_NODATA;
  return is_unknown ? absl::NotFoundError(message) : absl::UnavailableError(message);
}

}  // namespace

absl::StatusOr<Addresses> ResolveBySystem(const HostPort& address) {
  addrinfo hints = {};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_NUMERICSERV;
  addrinfo* found = nullptr;
  const int error =
      getaddrinfo(address.host.c_str(), absl::StrCat(address.port).c_str(), &hints, &found);
  if (error != 0) return ToStatus(error, address.host);
  const absl::Cleanup release = [found] { freeaddrinfo(found); };
  Addresses addresses;
  for (const addrinfo* one = found; one != nullptr; one = one->ai_next) {
    SocketAddress& added = addresses.emplace_back();
    std::memcpy(&added.bytes, one->ai_addr, one->ai_addrlen);
    added.size = one->ai_addrlen;
  }
  return addresses;
}

absl::StatusOr<Addresses> LookUpHost(const HostPort& address, absl::Duration timeout,
                                     const ResolveHost& resolve) {
  return Start(address, resolve)->Wait(timeout);
}

}  // namespace corbslam::services
