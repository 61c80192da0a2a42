// Converts the requests to fusion workers and their results, to and from sequences of
// messages: a header, chunks, an end with a checksum.
#ifndef CORBSLAM_SERVICES_CONVERT_WORK_WORK_H_
#define CORBSLAM_SERVICES_CONVERT_WORK_WORK_H_

#include <cstdint>
#include <functional>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "corbslam/v1/fusion_worker_service.pb.h"
#include "services/convert/errors.h"
#include "services/convert/limits.h"
#include "services/convert/work/locate_frame.h"
#include "services/convert/work/map_view.h"
#include "services/convert/work/result_items.h"
#include "slam/exchange/fusion_worker.h"
#include "slam/util/checksum.h"

namespace corbslam::services {

// The call's header with the mission whose request it is (docs/wire.md).
inline constexpr char kMissionHeader[] = "corbslam-mission";

// These collect what is read of one kind of request. All errors are INVALID_ARGUMENT, naming the
// item, unless said otherwise. Not thread-safe.
class VerifyOverlapRequestReader {
 public:
  absl::Status AddHeader(const v1::VerifyOverlapRequest::Header& header);
  absl::Status AddChunk(const v1::MapChunk& chunk);
  absl::StatusOr<VerifyOverlapRequest> Finish();

 private:
  VerifyOverlapRequest request_;
  MapViewReader query_view_{/*descriptors_optional=*/false, Covisibility::kCounted};
  MapViewReader candidate_view_{/*descriptors_optional=*/false, Covisibility::kCounted};
};

class FuseMapsRequestReader {
 public:
  absl::Status AddHeader(const v1::FuseMapsRequest::Header& header);
  absl::Status AddChunk(const v1::MapChunk& chunk);
  absl::StatusOr<FuseMapsRequest> Finish();

 private:
  FuseMapsRequest request_;
  MapViewReader target_{/*descriptors_optional=*/false, Covisibility::kGiven};
  MapViewReader source_{/*descriptors_optional=*/false, Covisibility::kGiven};
};

class AdjustBundleRequestReader {
 public:
  absl::Status AddHeader(const v1::AdjustBundleRequest::Header& header);
  absl::Status AddChunk(const v1::MapChunk& chunk);
  absl::StatusOr<AdjustBundleRequest> Finish();

 private:
  AdjustBundleRequest request_;
  MapViewReader view_{/*descriptors_optional=*/true, Covisibility::kGiven};
};

// These return the headers of requests and results.
v1::VerifyOverlapRequest::Header HeaderOf(const VerifyOverlapRequest& request);
v1::FuseMapsRequest::Header HeaderOf(const FuseMapsRequest& request);
v1::AdjustBundleRequest::Header HeaderOf(const AdjustBundleRequest& request);
v1::VerifyOverlapResponse::Header HeaderOf(const VerifyOverlapResult& result);
v1::FuseMapsResponse::Header HeaderOf(const FuseMapsResult& result);
v1::AdjustBundleResponse::Header HeaderOf(const AdjustBundleResult& result);

// These write what follows the headers, and return false if the sink did.
bool WriteChunks(const VerifyOverlapRequest& request, const ChunkSink& sink);
bool WriteChunks(const FuseMapsRequest& request, const ChunkSink& sink);
bool WriteChunks(const AdjustBundleRequest& request, const ChunkSink& sink);
bool WriteChunks(const VerifyOverlapResult& result, const ChunkSink& sink);
bool WriteChunks(const FuseMapsResult& result, const ChunkSink& sink);
bool WriteChunks(const AdjustBundleResult& result, const ChunkSink& sink);

// These make a result from its header and all its items.
absl::StatusOr<VerifyOverlapResult> MakeResult(const v1::VerifyOverlapResponse::Header& header,
                                               ResultItems items);
absl::StatusOr<FuseMapsResult> MakeResult(const v1::FuseMapsResponse::Header& header,
                                          ResultItems items);
absl::StatusOr<AdjustBundleResult> MakeResult(const v1::AdjustBundleResponse::Header& header,
                                              ResultItems items);

// Collects a result. Not thread-safe.
template <typename Response>
class ResultReader {
 public:
  using Header = typename Response::Header;

  absl::Status AddHeader(const Header& header) {
    header_ = header;
    return absl::OkStatus();
  }
  absl::Status AddChunk(const v1::ResultChunk& chunk) { return ReadResultChunk(chunk, items_); }
  auto Finish() { return MakeResult(header_, std::move(items_)); }

 private:
  Header header_;
  ResultItems items_;
};

// Sends a request or a result through `send`, which takes a Message and says whether to go on.
// Returns false if `send` did.
template <typename Message, typename Work>
bool WriteWork(const Work& work, const std::function<bool(Message)>& send) {
  Message message;
  *message.mutable_header() = HeaderOf(work);
  if (!send(std::move(message))) return false;
  uint32_t chunks = 0;
  uint32_t crc = 0;
  const bool all = WriteChunks(work, [&](std::string data) {
    ++chunks;
    crc = ExtendCrc32c(crc, data);
    Message part;
    part.mutable_chunk()->set_data(std::move(data));
    return send(std::move(part));
  });
  if (!all) return false;
  Message end;
  end.mutable_end()->set_chunks(chunks);
  end.mutable_end()->set_crc32c(crc);
  return send(std::move(end));
}

// Checks the order, the sizes and the checksum of a sequence and feeds `Reader`. ChunkMessage is
// the type of the chunks' data: v1::MapChunk or v1::ResultChunk.
template <typename Reader, typename ChunkMessage>
class WorkReader {
 public:
  // Takes a message, which has a header, a chunk or the end. RESOURCE_EXHAUSTED: there are more
  // than kMaxWorkBytes together.
  template <typename Message>
  absl::Status Add(const Message& message) {
    if (ended_) return absl::InvalidArgumentError("a message came after the end");
    if (message.has_header() != !begun_) {
      return absl::InvalidArgumentError(begun_ ? "a second header came"
                                               : "the header must be first");
    }
    if (message.has_header()) {
      begun_ = true;
      return reader_.AddHeader(message.header());
    }
    if (message.has_chunk()) return AddChunk(message.chunk().data());
    if (message.has_end()) return AddEnd(message.end());
    return absl::InvalidArgumentError("a message has no part, or one that is not expected here");
  }
  bool ended() const { return ended_; }
  auto Finish() { return reader_.Finish(); }

 private:
  absl::Status AddChunk(const std::string& data) {
    if (data.empty() || data.size() > kMaxChunkBytes) {
      return OutOfRange("size of a chunk in bytes", data.size(), size_t{1}, kMaxChunkBytes);
    }
    bytes_ += data.size();
    if (bytes_ > kMaxWorkBytes) {
      return absl::ResourceExhaustedError(
          absl::StrCat("the chunks have more than ", kMaxWorkBytes, " bytes"));
    }
    ++chunks_;
    crc_ = ExtendCrc32c(crc_, data);
    ChunkMessage chunk;
    if (!chunk.ParseFromString(data)) {
      return absl::InvalidArgumentError(absl::StrCat("chunk ", chunks_, " can't be parsed"));
    }
    return Locate(reader_.AddChunk(chunk), absl::StrCat("chunk ", chunks_));
  }

  absl::Status AddEnd(const v1::ChunksEnd& end) {
    if (end.chunks() != chunks_ || end.crc32c() != crc_) {
      return absl::InvalidArgumentError(absl::StrCat("the end names ", end.chunks(),
                                                     " chunks with checksum ", end.crc32c(),
                                                     ", but ", chunks_, " came with ", crc_));
    }
    ended_ = true;
    return absl::OkStatus();
  }

  Reader reader_;
  bool begun_ = false;
  bool ended_ = false;
  size_t bytes_ = 0;
  uint32_t chunks_ = 0;
  uint32_t crc_ = 0;
};

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_CONVERT_WORK_WORK_H_
