#include "client_agent/source/bag/files/unpack.h"

#include <bzlib.h>
#include <lz4frame.h>
#include <zstd.h>

#include <algorithm>
#include <memory>

#include "absl/functional/function_ref.h"
#include "absl/strings/str_cat.h"
#include "client_agent/source/bag/files/bag_bytes.h"
#include "slam/util/status_macros.h"

namespace corbslam::client_agent {
namespace {

constexpr size_t kFirstRoom = size_t{1} << 20;

// What one call of a library did.
struct UnpackStep {
  size_t taken = 0;
  size_t given = 0;
  bool at_end = false;
};
using StepUse =
    absl::FunctionRef<absl::StatusOr<UnpackStep>(absl::string_view from, char* to, size_t room)>;

absl::Status Broken(absl::string_view compression, absl::string_view why) {
  return absl::InvalidArgumentError(absl::StrCat("broken ", compression, ": ", why));
}

// Calls `step` until everything is unpacked, giving it room as it needs it.
absl::StatusOr<std::string> UnpackInSteps(absl::string_view compression, absl::string_view packed,
                                          uint64_t most, StepUse step) {
  std::string unpacked;
  size_t filled = 0;
  while (true) {
    if (filled == unpacked.size()) {
      // One byte more than there may be shows that there are more.
      unpacked.resize(std::min<uint64_t>(most + 1, std::max(kFirstRoom, 2 * filled)));
    }
    ASSIGN_OR_RETURN(const UnpackStep done,
                     step(packed, unpacked.data() + filled, unpacked.size() - filled));
    packed.remove_prefix(done.taken);
    filled += done.given;
    if (filled > most) return Broken(compression, absl::StrCat("more than ", most, " bytes"));
    if (done.at_end) break;
    if (done.taken == 0 && done.given == 0) return Broken(compression, "it ends too early");
  }
  unpacked.resize(filled);
  return unpacked;
}

absl::StatusOr<std::string> UnpackZstd(absl::string_view packed, uint64_t most) {
  const std::unique_ptr<ZSTD_DCtx, size_t (*)(ZSTD_DCtx*)> state(ZSTD_createDCtx(), &ZSTD_freeDCtx);
  return UnpackInSteps(
      "zstd", packed, most,
      [&](absl::string_view from, char* to, size_t room) -> absl::StatusOr<UnpackStep> {
        ZSTD_inBuffer in{from.data(), from.size(), 0};
        ZSTD_outBuffer out{to, room, 0};
        const size_t left = ZSTD_decompressStream(state.get(), &out, &in);
        if (ZSTD_isError(left)) return Broken("zstd", ZSTD_getErrorName(left));
        return UnpackStep{in.pos, out.pos, left == 0 && in.pos == from.size()};
      });
}

absl::StatusOr<std::string> UnpackLz4(absl::string_view packed, uint64_t most) {
  LZ4F_dctx* context = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&context, LZ4F_VERSION))) {
    return absl::ResourceExhaustedError("no memory to unpack lz4");
  }
  const std::unique_ptr<LZ4F_dctx, LZ4F_errorCode_t (*)(LZ4F_dctx*)> state(
      context, &LZ4F_freeDecompressionContext);
  return UnpackInSteps(
      "lz4", packed, most,
      [&](absl::string_view from, char* to, size_t room) -> absl::StatusOr<UnpackStep> {
        size_t taken = from.size();
        size_t given = room;
        const size_t left = LZ4F_decompress(state.get(), to, &given, from.data(), &taken, nullptr);
        if (LZ4F_isError(left)) return Broken("lz4", LZ4F_getErrorName(left));
        return UnpackStep{taken, given, left == 0 && taken == from.size()};
      });
}

absl::StatusOr<std::string> UnpackBz2(absl::string_view packed, uint64_t most) {
  bz_stream stream = {};
  if (BZ2_bzDecompressInit(&stream, 0, 0) != BZ_OK) {
    return absl::ResourceExhaustedError("no memory to unpack bz2");
  }
  const std::unique_ptr<bz_stream, int (*)(bz_stream*)> state(&stream, &BZ2_bzDecompressEnd);
  return UnpackInSteps(
      "bz2", packed, most,
      [&](absl::string_view from, char* to, size_t room) -> absl::StatusOr<UnpackStep> {
        stream.next_in = const_cast<char*>(from.data());  // The bytes are only read.
        stream.avail_in = static_cast<unsigned>(from.size());
        stream.next_out = to;
        stream.avail_out = static_cast<unsigned>(room);
        const int result = BZ2_bzDecompress(&stream);
        if (result != BZ_OK && result != BZ_STREAM_END) {
          return Broken("bz2", absl::StrCat("error ", result));
        }
        return UnpackStep{from.size() - stream.avail_in, room - stream.avail_out,
                          result == BZ_STREAM_END};
      });
}

absl::StatusOr<std::string> UnpackBy(absl::string_view compression, absl::string_view packed,
                                     uint64_t most) {
  if (packed.size() > kMostBagBytes) return Broken(compression, "too many bytes");
  if (compression == "zstd") return UnpackZstd(packed, most);
  if (compression == "lz4") return UnpackLz4(packed, most);
  if (compression == "bz2") return UnpackBz2(packed, most);
  return absl::UnimplementedError(
      absl::StrCat("compression '", compression, "': known are zstd, lz4, bz2 and none"));
}

}  // namespace

absl::StatusOr<std::string> Unpack(absl::string_view compression, absl::string_view packed,
                                   std::optional<uint64_t> size) {
  const uint64_t most = size.value_or(kMostBagBytes);
  if (most > kMostBagBytes) {
    return absl::InvalidArgumentError(absl::StrCat("an unpacked size of ", most, " bytes, at most ",
                                                   kMostBagBytes, " are taken"));
  }
  ASSIGN_OR_RETURN(std::string unpacked, UnpackBy(compression, packed, most));
  if (!size.has_value() || unpacked.size() == *size) return unpacked;
  return absl::InvalidArgumentError(
      absl::StrCat("it unpacks to ", unpacked.size(), " bytes, ", *size, " are announced"));
}

}  // namespace corbslam::client_agent
