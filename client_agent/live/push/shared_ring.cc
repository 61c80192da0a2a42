#include "client_agent/live/push/shared_ring.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>

#include <cerrno>
#include <cstring>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client_agent/push_client/corbslam/push.h"

namespace corbslam::client_agent {
namespace {

absl::Status CheckMemory(const UniqueFd& memory, uint64_t bytes) {
  const int seals = fcntl(memory.get(), F_GET_SEALS);
  if (seals < 0) {
    return absl::InvalidArgumentError(
        "memory is no file that can be sealed: make it by memfd_create with MFD_ALLOW_SEALING");
  }
  if ((seals & F_SEAL_SHRINK) == 0) {
    return absl::InvalidArgumentError(
        "memory is not sealed by F_SEAL_SHRINK: a robot reads none that may shrink");
  }
  struct stat about = {};
  if (fstat(memory.get(), &about) != 0 || about.st_size < 0) {
    return absl::InvalidArgumentError(absl::StrCat("memory: ", std::strerror(errno)));
  }
  if (static_cast<uint64_t>(about.st_size) >= bytes) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat("memory has ", about.st_size, " bytes, memory_bytes says ", bytes));
}

int TypeOf(uint32_t format) {
  return format == CORBSLAM_PUSH_GREY8  ? CV_8UC1
         : format == CORBSLAM_PUSH_BGR8 ? CV_8UC3
                                        : CV_16UC1;
}

}  // namespace

absl::StatusOr<SharedRing> SharedRing::Map(const UniqueFd& memory, const PushLayout& layout) {
  if (absl::Status status = CheckMemory(memory, layout.memory_bytes); !status.ok()) return status;
  void* const mapped = mmap(nullptr, layout.memory_bytes, PROT_READ, MAP_SHARED, memory.get(), 0);
  if (mapped == MAP_FAILED) {
    return absl::InvalidArgumentError(absl::StrCat(
        "memory of ", layout.memory_bytes, " bytes can't be mapped: ", std::strerror(errno)));
  }
  return SharedRing(static_cast<uint8_t*>(mapped), layout);
}

SharedRing::SharedRing(SharedRing&& other) noexcept
    : bytes_(std::exchange(other.bytes_, nullptr)), layout_(other.layout_) {}

SharedRing& SharedRing::operator=(SharedRing&& other) noexcept {
  std::swap(bytes_, other.bytes_);
  std::swap(layout_, other.layout_);
  return *this;
}

SharedRing::~SharedRing() {
  if (bytes_ != nullptr) munmap(bytes_, layout_.memory_bytes);
}

cv::Mat SharedRing::Copy(uint32_t slot, const push_wire::Picture& picture) const {
  const cv::Mat view(static_cast<int>(picture.height_px), static_cast<int>(picture.width_px),
                     TypeOf(picture.format),
                     bytes_ + slot * layout_.slot_bytes + picture.offset_bytes,
                     picture.stride_bytes);
  cv::Mat copy;
  if (picture.format == CORBSLAM_PUSH_BGR8) {
    cv::cvtColor(view, copy, cv::COLOR_BGR2GRAY);
  } else {
    copy = view.clone();
  }
  return copy;
}

}  // namespace corbslam::client_agent
