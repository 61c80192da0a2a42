#include "tests/fault/raw_stream.h"

#include "absl/time/clock.h"
#include "corbslam/v1/map_store_service.pb.h"
#include "services/convert/status.h"

namespace corbslam::tests {

using services::FromGrpcStatus;

namespace {

bool IsAcknowledgement(const grpc::ByteBuffer& response) {
  grpc::Slice bytes;
  v1::SyncResponse message;
  return response.DumpToSingleSlice(&bytes).ok() &&
         message.ParseFromArray(bytes.begin(), static_cast<int>(bytes.size())) &&
         message.has_acknowledgement();
}

}  // namespace

RawStream::RawStream(const std::shared_ptr<grpc::Channel>& channel, const std::string& method)
    : stub_(channel) {
  stub_.PrepareBidiStreamingCall(&context_, "/corbslam.v1.MapStore/" + method, grpc::StubOptions(),
                                 this);
  StartRead(&response_);
  // The hold lasts until the end, because Send starts writes from outside of reactions.
  AddHold();
  StartCall();
}

RawStream::~RawStream() {
  context_.TryCancel();
  {
    absl::MutexLock lock(&mutex_);
    mutex_.Await(absl::Condition(this, &RawStream::IsWritten));
  }
  LetGo();
  absl::MutexLock lock(&mutex_);
  mutex_.Await(absl::Condition(this, &RawStream::IsDone));
}

bool RawStream::Send(const std::string& bytes) {
  {
    absl::MutexLock lock(&mutex_);
    if (broken_) return false;
    writing_ = true;
  }
  const grpc::Slice slice(bytes);
  request_ = grpc::ByteBuffer(&slice, 1);
  StartWrite(&request_);
  absl::MutexLock lock(&mutex_);
  mutex_.Await(absl::Condition(this, &RawStream::IsWritten));
  return !broken_;
}

std::optional<absl::Status> RawStream::WaitForEnd(absl::Duration timeout) {
  const absl::Time deadline = absl::Now() + timeout;
  while (!has_ended() && absl::Now() < deadline) absl::SleepFor(absl::Milliseconds(1));
  if (!has_ended()) return std::nullopt;
  // There is nothing more to read or write.
  LetGo();
  absl::MutexLock lock(&mutex_);
  mutex_.Await(absl::Condition(this, &RawStream::IsDone));
  return end_;
}

void RawStream::LetGo() {
  if (held_) RemoveHold();
  held_ = false;
}

bool RawStream::has_ended() const {
  absl::MutexLock lock(&mutex_);
  return broken_;
}

int RawStream::acknowledgements() const {
  absl::MutexLock lock(&mutex_);
  return acknowledgements_;
}

void RawStream::OnReadDone(bool ok) {
  const bool is_acknowledgement = ok && IsAcknowledgement(response_);
  {
    absl::MutexLock lock(&mutex_);
    acknowledgements_ += is_acknowledgement;
    broken_ |= !ok;
  }
  if (ok) StartRead(&response_);
}

void RawStream::OnWriteDone(bool ok) {
  absl::MutexLock lock(&mutex_);
  writing_ = false;
  broken_ |= !ok;
}

void RawStream::OnDone(const grpc::Status& status) {
  absl::MutexLock lock(&mutex_);
  end_ = FromGrpcStatus(status);
}

}  // namespace corbslam::tests
