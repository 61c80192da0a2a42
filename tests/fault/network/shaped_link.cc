#include "tests/fault/network/shaped_link.h"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <optional>
#include <utility>

#include "absl/cleanup/cleanup.h"
#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "slam/util/status_macros.h"
#include "tests/fault/network/interface.h"

namespace corbslam::tests {
namespace {

constexpr size_t kMaxPacketBytes = 2048;

// Reads all that has come to a device into the queue.
void ReadPackets(int device, LinkQueue& queue) {
  std::array<char, kMaxPacketBytes> buffer;
  while (true) {
    const ssize_t bytes = read(device, buffer.data(), buffer.size());
    if (bytes <= 0) return;
    queue.Push(std::string(buffer.data(), static_cast<size_t>(bytes)), absl::Now());
  }
}

void WritePackets(LinkQueue& queue, int device) {
  while (const std::optional<std::string> packet = queue.Pop(absl::Now())) {
    // A device that takes no more has lost the packet, as networks do.
    if (write(device, packet->data(), packet->size()) < 0) continue;
  }
}

absl::StatusOr<int> OpenEnd(NetworkNamespace* place, const std::string& name,
                            const std::string& address, const std::string& peer) {
  absl::StatusOr<int> file = -1;
  const auto open = [&] {
    file = OpenTunnel(name, address, peer);
    return file.status();
  };
  RETURN_IF_ERROR(place == nullptr ? open() : place->Run(open));
  return file;
}

// Returns the name of a device. Each link has other names, also in a namespace of many links.
std::string NameOf(const std::string& peer) { return absl::StrCat("t", peer); }

}  // namespace

absl::StatusOr<std::unique_ptr<ShapedLink>> ShapedLink::Create(const Ends& ends,
                                                               const LinkShape& shape) {
  RETURN_IF_ERROR(shape.Validate());
  ASSIGN_OR_RETURN(const int here, OpenEnd(ends.here, NameOf(ends.address_there), ends.address_here,
                                           ends.address_there));
  absl::Cleanup close_here = [here] { close(here); };
  ASSIGN_OR_RETURN(const int there, OpenEnd(ends.there, NameOf(ends.address_here),
                                            ends.address_there, ends.address_here));
  absl::Cleanup close_there = [there] { close(there); };
  const int stop = eventfd(0, EFD_CLOEXEC);
  if (stop < 0) return absl::UnavailableError(absl::StrCat("eventfd: ", std::strerror(errno)));
  std::move(close_here).Cancel();
  std::move(close_there).Cancel();
  return std::unique_ptr<ShapedLink>(new ShapedLink(here, there, stop, shape));
}

ShapedLink::ShapedLink(int here, int there, int stop, const LinkShape& shape)
    : here_(here), there_(there), stop_(stop), thread_([this, shape] { Carry(shape); }) {}

ShapedLink::~ShapedLink() {
  eventfd_write(stop_, 1);
  thread_.join();
  for (const int file : {here_, there_, stop_}) close(file);
}

LinkCounts ShapedLink::counts() const {
  absl::MutexLock lock(&mutex_);
  return counts_;
}

void ShapedLink::Carry(const LinkShape& shape) {
  const absl::Time start = absl::Now();
  LinkQueue out(shape, 1, start);
  LinkQueue back(shape, 2, start);
  std::array<pollfd, 3> files = {{{here_, POLLIN, 0}, {there_, POLLIN, 0}, {stop_, POLLIN, 0}}};
  while ((files[2].revents & POLLIN) == 0) {
    const absl::Time due = std::min(out.NextDue(), back.NextDue());
    const absl::Duration wait =
        std::clamp(due - absl::Now(), absl::ZeroDuration(), absl::Seconds(60));
    const timespec timeout = absl::ToTimespec(wait);
    ppoll(files.data(), files.size(), &timeout, nullptr);
    ReadPackets(here_, out);
    ReadPackets(there_, back);
    WritePackets(out, there_);
    WritePackets(back, here_);
    absl::MutexLock lock(&mutex_);
    counts_.passed = out.counts().passed + back.counts().passed;
    counts_.lost = out.counts().lost + back.counts().lost;
  }
}

}  // namespace corbslam::tests
