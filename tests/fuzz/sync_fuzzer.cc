// Feeds an agent's stream as bytes: SyncRequests, through conversion and validation, to a live
// store.
#include <memory>
#include <optional>

#include "map_store/store/map_store.h"
#include "services/convert/keyframe_picture.h"
#include "services/convert/map_update.h"
#include "services/convert/shared_update.h"
#include "tests/fuzz/live_store.h"
#include "tests/fuzz/messages.h"

namespace corbslam::tests {

using map_store::MapStore;
using services::BatchAssembler;
using services::CameraBook;
using services::FromProto;

namespace {

// Does what SyncReactor does, without its threads.
class FuzzedStream {
 public:
  explicit FuzzedStream(MapStore& store) : store_(store) {}
  ~FuzzedStream() {
    if (session_.has_value()) store_.CloseSession(*session_);
  }

  bool Handle(const v1::SyncRequest& request) {
    if (request.has_open()) return Open(request.open());
    if (!session_.has_value()) return false;
    if (request.has_picture()) {
      return store_.KeepPicture(*session_, FromProto(request.picture())).ok();
    }
    return request.has_batch() && Apply(request.batch());
  }

 private:
  bool Open(const v1::OpenSession& proto) {
    const absl::StatusOr<SessionRequest> request = FromProto(proto);
    if (!request.ok() || session_.has_value()) return false;
    const auto opened = store_.OpenSession(*request);
    if (opened.ok()) session_ = opened->session_id;
    return opened.ok();
  }
  bool Apply(const v1::MapUpdateBatch& part) {
    const auto batch = assembler_.Add(part, cameras_);
    if (!batch.ok()) return false;
    return !batch->has_value() || store_.Apply(*session_, **batch).ok();
  }

  MapStore& store_;
  std::optional<uint64_t> session_;
  CameraBook cameras_;
  BatchAssembler assembler_;
};

}  // namespace
}  // namespace corbslam::tests

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace corbslam;         // NOLINT
  using namespace corbslam::tests;  // NOLINT
  absl::string_view input = AsText(data, size);
  const std::unique_ptr<MapStore> store = MakeLiveStore();
  auto stream = std::make_unique<FuzzedStream>(*store);
  while (!input.empty()) {
    const absl::string_view message = TakeMessage(input);
    v1::SyncRequest request;
    const bool good = request.ParseFromArray(message.data(), static_cast<int>(message.size())) &&
                      stream->Handle(request);
    // An error ends a stream; the agent opens another one.
    if (!good) stream = std::make_unique<FuzzedStream>(*store);
  }
  stream.reset();
  LookAtEverything(*store);
  return 0;
}
