#include "tests/fault/network/network_namespace.h"

#include <fcntl.h>
#include <sched.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "absl/strings/str_cat.h"
#include "slam/util/status_macros.h"
#include "tests/fault/network/interface.h"

namespace corbslam::tests {
namespace {

absl::Status Failed(absl::string_view what) {
  const int error = errno;
  const std::string message = absl::StrCat("network namespace: ", what, ": ", std::strerror(error));
  if (error == EPERM || error == EACCES) return absl::PermissionDeniedError(message);
  return absl::UnavailableError(message);
}

absl::StatusOr<int> OpenCurrent() {
  const int file = open("/proc/thread-self/ns/net", O_RDONLY | O_CLOEXEC);
  if (file < 0) return Failed("can't open this thread's");
  return file;
}

}  // namespace

absl::StatusOr<std::unique_ptr<NetworkNamespace>> NetworkNamespace::Create() {
  ASSIGN_OR_RETURN(const int outside, OpenCurrent());
  if (unshare(CLONE_NEWNET) != 0) {
    const absl::Status status = Failed("can't make one");
    close(outside);
    return status;
  }
  const absl::StatusOr<int> own = OpenCurrent();
  std::unique_ptr<NetworkNamespace> made(new NetworkNamespace(own.value_or(-1), outside));
  const absl::Status up = BringUp("lo");
  if (setns(outside, CLONE_NEWNET) != 0) return Failed("can't go back");
  RETURN_IF_ERROR(own.status());
  RETURN_IF_ERROR(up);
  return made;
}

absl::Status NetworkNamespace::Enter() {
  if (unshare(CLONE_NEWNET) != 0) return Failed("can't make one");
  return BringUp("lo");
}

NetworkNamespace::~NetworkNamespace() {
  if (own_ >= 0) close(own_);
  close(outside_);
}

absl::Status NetworkNamespace::Run(const std::function<absl::Status()>& function) {
  if (setns(own_, CLONE_NEWNET) != 0) return Failed("can't enter");
  absl::Status status = function();
  if (setns(outside_, CLONE_NEWNET) != 0) return Failed("can't go back");
  return status;
}

}  // namespace corbslam::tests
