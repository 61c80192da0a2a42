// Opens a stream whose messages are any bytes at all: what a program that isn't ours may send.
#ifndef CORBSLAM_TESTS_FAULT_RAW_STREAM_H_
#define CORBSLAM_TESTS_FAULT_RAW_STREAM_H_

#include <grpcpp/channel.h>
#include <grpcpp/client_context.h>
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/client_callback.h>

#include <memory>
#include <optional>
#include <string>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/synchronization/mutex.h"
#include "absl/time/time.h"

namespace corbslam::tests {

// One call of a method of MapStore. One thread may use it; all calls block.
class RawStream : private grpc::ClientBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer> {
 public:
  explicit RawStream(const std::shared_ptr<grpc::Channel>& channel,
                     const std::string& method = "Sync");
  // Cancels the call.
  ~RawStream() override;

  // Returns whether the message went out; false once the call has ended.
  bool Send(const std::string& bytes);
  // Returns how the store ends the call; none where it does not within the time.
  std::optional<absl::Status> WaitForEnd(absl::Duration timeout);
  bool has_ended() const;
  // Returns the number of batches that came back acknowledged, of a Sync.
  int acknowledgements() const;

 private:
  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnDone(const grpc::Status& status) override;
  // Says that nothing more will be written.
  void LetGo();
  bool IsWritten() const ABSL_SHARED_LOCKS_REQUIRED(mutex_) { return !writing_; }
  bool IsDone() const ABSL_SHARED_LOCKS_REQUIRED(mutex_) { return end_.has_value(); }

  grpc::GenericStub stub_;
  grpc::ClientContext context_;
  bool held_ = true;
  grpc::ByteBuffer request_;
  grpc::ByteBuffer response_;
  mutable absl::Mutex mutex_;
  bool writing_ ABSL_GUARDED_BY(mutex_) = false;
  bool broken_ ABSL_GUARDED_BY(mutex_) = false;
  int acknowledgements_ ABSL_GUARDED_BY(mutex_) = 0;
  std::optional<absl::Status> end_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace corbslam::tests

#endif  // CORBSLAM_TESTS_FAULT_RAW_STREAM_H_
