#include "client_agent/source/bag/files/unpack_file.h"

#include <unistd.h>
#include <zstd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <memory>

#include "absl/strings/str_cat.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

constexpr uint64_t kUnpackBlock = uint64_t{1} << 20;
constexpr uint64_t kMostGrowth = 200;

// A new file, which is removed unless it is kept.
class NewFile {
 public:
  NewFile() {
    std::error_code ignored;
    path_ = (std::filesystem::temp_directory_path(ignored) / "corbslam_bag_XXXXXX").string();
    file_ = mkstemp(path_.data());
  }
  ~NewFile() {
    if (file_ < 0) return;
    close(file_);
    if (!kept_) unlink(path_.c_str());
  }
  NewFile(const NewFile&) = delete;
  NewFile& operator=(const NewFile&) = delete;

  absl::Status Write(const char* bytes, size_t size) {
    while (size > 0) {
      const ssize_t done = file_ < 0 ? -1 : write(file_, bytes, size);
      if (done < 0 && errno == EINTR) continue;
      if (done < 0) {
        return absl::UnavailableError(absl::StrCat("can't be unpacked to ", path_, ": ",
                                                   std::strerror(errno),
                                                   ": name another folder by TMPDIR"));
      }
      bytes += done;
      size -= static_cast<size_t>(done);
    }
    return absl::OkStatus();
  }
  std::string Keep() {
    kept_ = true;
    return path_;
  }

 private:
  std::string path_;
  int file_ = -1;
  bool kept_ = false;
};

// Unpacks one block after the other into `out`.
absl::Status UnpackBlocks(const BagBytes& packed, NewFile& out) {
  const std::unique_ptr<ZSTD_DCtx, size_t (*)(ZSTD_DCtx*)> state(ZSTD_createDCtx(), &ZSTD_freeDCtx);
  std::string room(kUnpackBlock, '\0');
  uint64_t given = 0;
  size_t left = 0;
  for (uint64_t at = 0; at < packed.size(); at += kUnpackBlock) {
    ASSIGN_OR_RETURN(const std::string block, packed.ReadUpTo(at, kUnpackBlock));
    ZSTD_inBuffer in{block.data(), block.size(), 0};
    ZSTD_outBuffer unpacked{room.data(), room.size(), 0};
    do {
      unpacked.pos = 0;
      left = ZSTD_decompressStream(state.get(), &unpacked, &in);
      if (ZSTD_isError(left)) return packed.ErrorAt(at, ZSTD_getErrorName(left));
      RETURN_IF_ERROR(out.Write(room.data(), unpacked.pos));
      given += unpacked.pos;
      if (given > kMostGrowth * packed.size()) {
        return packed.ErrorAt(at, absl::StrCat("it unpacks to more than ", kMostGrowth,
                                               " times its size: unpack it by unzstd if that is "
                                               "right"));
      }
    } while (in.pos < in.size || unpacked.pos == unpacked.size);
  }
  return left == 0 ? absl::OkStatus()
                   : packed.ErrorAt(packed.size(), "the packed file is cut short");
}

}  // namespace

absl::StatusOr<std::string> UnpackZstdFile(const BagBytes& packed) {
  NewFile out;
  if (const absl::Status done = UnpackBlocks(packed, out); !done.ok()) {
    if (absl::IsInvalidArgument(done)) return done;  // It names the file.
    return absl::Status(done.code(), absl::StrCat(packed.name(), ": ", done.message()));
  }
  return out.Keep();
}

}  // namespace corbslam::client_agent
