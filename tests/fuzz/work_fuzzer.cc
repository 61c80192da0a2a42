// Feeds requests to fusion workers and their results, as streams of messages. The first byte says
// which; its highest bit asks for a last message that is right about the chunks.
#include <string>

#include "services/convert/work/work.h"
#include "tests/fuzz/messages.h"

namespace corbslam::tests {

using services::AdjustBundleRequestReader;
using services::FuseMapsRequestReader;
using services::ResultReader;
using services::VerifyOverlapRequestReader;
using services::WorkReader;

namespace {

template <typename Message, typename Reader, typename Chunk>
void Read(absl::string_view input, bool ends_right) {
  WorkReader<Reader, Chunk> reader;
  uint32_t chunks = 0;
  uint32_t crc = 0;
  while (!input.empty()) {
    const absl::string_view bytes = TakeMessage(input);
    Message message;
    if (!message.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) return;
    if (!reader.Add(message).ok()) return;
    if (!message.has_chunk()) continue;
    ++chunks;
    crc = ExtendCrc32c(crc, message.chunk().data());
  }
  if (ends_right && !reader.ended()) {
    Message end;
    end.mutable_end()->set_chunks(chunks);
    end.mutable_end()->set_crc32c(crc);
    if (!reader.Add(end).ok()) return;
  }
  if (reader.ended()) (void)reader.Finish();
}

template <typename Response>
void ReadResult(absl::string_view input, bool ends_right) {
  Read<Response, ResultReader<Response>, v1::ResultChunk>(input, ends_right);
}

}  // namespace
}  // namespace corbslam::tests

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace corbslam;         // NOLINT
  using namespace corbslam::tests;  // NOLINT
  if (size == 0) return 0;
  const absl::string_view input = AsText(data + 1, size - 1);
  const bool ends_right = (data[0] & 0x80) != 0;
  switch (data[0] & 0x7f) {
    case 0:
      Read<v1::VerifyOverlapRequest, VerifyOverlapRequestReader, v1::MapChunk>(input, ends_right);
      break;
    case 1:
      Read<v1::FuseMapsRequest, FuseMapsRequestReader, v1::MapChunk>(input, ends_right);
      break;
    case 2:
      Read<v1::AdjustBundleRequest, AdjustBundleRequestReader, v1::MapChunk>(input, ends_right);
      break;
    case 3:
      ReadResult<v1::VerifyOverlapResponse>(input, ends_right);
      break;
    case 4:
      ReadResult<v1::FuseMapsResponse>(input, ends_right);
      break;
    case 5:
      ReadResult<v1::AdjustBundleResponse>(input, ends_right);
      break;
    default:
      break;
  }
  return 0;
}
