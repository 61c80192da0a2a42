// Tests a fusion worker behind its contract, through the remote worker in one process.
#include "services/fusion_worker_service/fusion_worker_service.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <set>
#include <thread>
#include <vector>

#include "absl/synchronization/notification.h"
#include "absl/time/clock.h"
#include "services/client/remote/channel.h"
#include "services/client/remote/remote_fusion_worker.h"
#include "services/convert/testing/test_data.h"
#include "services/convert/work/work.h"
#include "services/server/server.h"

namespace corbslam::services {
namespace {

using test_data::kMap;
using test_data::kOtherMap;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

bool GoOn(double) { return true; }

// Answers with what it was asked.
class FakeFusionWorker : public FusionWorker {
 public:
  absl::StatusOr<VerifyOverlapResult> VerifyOverlap(const VerifyOverlapRequest& request,
                                                    const ProgressCallback& progress) override {
    progress(0.5);
    std::mt19937 random(1);
    VerifyOverlapResult result;
    result.base_revision = request.base_revision;
    for (const auto& candidate : request.candidates) {
      result.overlaps.push_back(test_data::MakeOverlap(random, request.query, candidate.id));
    }
    return result;
  }
  absl::StatusOr<FuseMapsResult> FuseMaps(const FuseMapsRequest&,
                                          const ProgressCallback&) override {
    return absl::InvalidArgumentError("overlaps name nothing");
  }
  // Works until it is cancelled.
  absl::StatusOr<AdjustBundleResult> AdjustBundle(const AdjustBundleRequest& request,
                                                  const ProgressCallback& progress) override {
    if (!begun_.exchange(true)) started.Notify();
    if (request.max_iterations == 1) {
      AdjustBundleResult result;
      result.keyframes = static_cast<int>(request.view.keyframes().size());
      return result;
    }
    while (progress(0.1)) absl::SleepFor(absl::Milliseconds(1));
    if (!ended_.exchange(true)) cancelled.Notify();
    return absl::CancelledError("cancelled");
  }

  absl::Notification started;
  absl::Notification cancelled;

 private:
  std::atomic<bool> begun_{false};
  std::atomic<bool> ended_{false};
};

class FusionWorkerServiceTest : public ::testing::Test {
 protected:
  void SetUp() override {
    auto server = Server::Start("127.0.0.1:0", {&service_});
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
    channel_ = server_->InProcessChannel();
    remote_ = MakeRemoteFusionWorker({channel_});
  }
  void TearDown() override { server_->Shutdown(absl::ZeroDuration()); }

  static VerifyOverlapRequest MakeVerification() {
    std::mt19937 random(2);
    VerifyOverlapRequest request;
    request.base_revision = 12;
    request.query_view = std::make_shared<const Map>(test_data::MakeMap(random, kMap, 5));
    request.candidate_view = test_data::MakeMap(random, kOtherMap, 5);
    request.query = {kMap, 2};
    request.candidates = {{{kOtherMap, 1}, 20}, {{kOtherMap, 3}, 15}};
    return request;
  }
  static AdjustBundleRequest MakeAdjustment() {
    std::mt19937 random(3);
    AdjustBundleRequest request;
    request.view = test_data::MakeMap(random, kMap, 4);
    request.fixed = {{kMap, 0}};
    return request;
  }

  FakeFusionWorker worker_;
  std::atomic<int> done_{0};
  FusionWorkerService service_{&worker_,
                               {.threads = 1, .max_requests = 2, .when_done = [this] { ++done_; }}};
  std::unique_ptr<Server> server_;
  std::shared_ptr<grpc::Channel> channel_;
  std::unique_ptr<FusionWorker> remote_;
};

TEST_F(FusionWorkerServiceTest, ARequestGoesThereAndItsResultComesBack) {
  std::set<double> progress;
  const auto result = remote_->VerifyOverlap(MakeVerification(), [&](double fraction) {
    progress.insert(fraction);
    return true;
  });
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->base_revision, 12u);
  ASSERT_EQ(result->overlaps.size(), 2u);
  EXPECT_EQ(result->overlaps[1].candidate, (KeyframeId{kOtherMap, 3}));
  EXPECT_EQ(result->overlaps[1].inliers.size(), 2u);
  EXPECT_THAT(progress, ElementsAre(0, 0.5));
}

// Whoever gives free memory back hears of it however a request ended.
TEST_F(FusionWorkerServiceTest, SaysWhenARequestHasGone) {
  const auto wait_for = [this](int count) {
    const absl::Time deadline = absl::Now() + absl::Seconds(20);
    while (done_ < count && absl::Now() < deadline) absl::SleepFor(absl::Milliseconds(1));
    return done_.load();
  };
  ASSERT_TRUE(remote_->VerifyOverlap(MakeVerification(), GoOn).ok());
  EXPECT_EQ(wait_for(1), 1);
  ASSERT_FALSE(remote_->FuseMaps(FuseMapsRequest(), GoOn).ok());
  EXPECT_EQ(wait_for(2), 2);
  remote_->AdjustBundle(MakeAdjustment(), [](double fraction) { return fraction < 0.1; })
      .status()
      .IgnoreError();
  EXPECT_EQ(wait_for(3), 3);
}

TEST_F(FusionWorkerServiceTest, ErrorsComeBackAsTheyAre) {
  const auto result = remote_->FuseMaps(FuseMapsRequest(), GoOn);
  EXPECT_EQ(result.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(result.status().message()), HasSubstr("overlaps name nothing"));
}

TEST_F(FusionWorkerServiceTest, ARefusedRequestSaysWhy) {
  VerifyOverlapRequest request = MakeVerification();
  request.query = {kMap, 99};
  const auto result = remote_->VerifyOverlap(request, GoOn);
  EXPECT_EQ(result.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(result.status().message()),
              HasSubstr("query c0ffee00c0ffee01:99 is not in the first view"));
}

TEST_F(FusionWorkerServiceTest, CancellingStopsTheWorkThere) {
  const auto result =
      remote_->AdjustBundle(MakeAdjustment(), [](double fraction) { return fraction < 0.1; });
  EXPECT_EQ(result.status().code(), absl::StatusCode::kCancelled);
  EXPECT_TRUE(worker_.cancelled.WaitForNotificationWithTimeout(absl::Seconds(20)));
}

TEST_F(FusionWorkerServiceTest, ARequestThatWaitsForItsTurnCanBeCancelled) {
  std::atomic<bool> first_wanted = true;
  std::thread first([&] {
    remote_->AdjustBundle(MakeAdjustment(), [&](double) { return first_wanted.load(); })
        .status()
        .IgnoreError();
  });
  EXPECT_TRUE(worker_.started.WaitForNotificationWithTimeout(absl::Seconds(20)));
  const auto result = remote_->AdjustBundle(
      MakeAdjustment(), [&](double) { return service_.waiting_requests() == 0; });
  EXPECT_EQ(result.status().code(), absl::StatusCode::kCancelled);
  EXPECT_FALSE(worker_.cancelled.HasBeenNotified()) << "the first one goes on";
  const absl::Time deadline = absl::Now() + absl::Seconds(20);
  while (service_.requests() > 1 && absl::Now() < deadline) absl::SleepFor(absl::Milliseconds(1));
  EXPECT_EQ(service_.requests(), 1) << "its place is free, though no thread has seen it";
  first_wanted = false;
  first.join();
}

// Takes calls and reads nothing of them.
class StuckService : public v1::FusionWorker::CallbackService {
 public:
  grpc::ServerBidiReactor<v1::AdjustBundleRequest, v1::AdjustBundleResponse>* AdjustBundle(
      grpc::CallbackServerContext*) override {
    class Reactor
        : public grpc::ServerBidiReactor<v1::AdjustBundleRequest, v1::AdjustBundleResponse> {
      void OnCancel() override { Finish(grpc::Status::CANCELLED); }
      void OnDone() override { delete this; }
    };
    begun.Notify();
    return new Reactor();
  }

  absl::Notification begun;
};

TEST_F(FusionWorkerServiceTest, ARequestThatIsStillBeingSentCanBeCancelled) {
  StuckService stuck;
  const auto server = Server::Start("127.0.0.1:0", {&stuck});
  ASSERT_TRUE(server.ok()) << server.status();
  std::mt19937 random(3);
  AdjustBundleRequest request = MakeAdjustment();
  request.view = test_data::MakeMap(random, kMap, 1000);
  const auto result =
      MakeRemoteFusionWorker({MakeChannel((*server)->address())})
          ->AdjustBundle(request, [&](double) { return !stuck.begun.HasBeenNotified(); });
  EXPECT_EQ(result.status().code(), absl::StatusCode::kCancelled) << result.status();
}

TEST_F(FusionWorkerServiceTest, ACallThatIsClosedIsCancelled) {
  const auto stub = v1::FusionWorker::NewStub(channel_);
  grpc::ClientContext context;
  const auto stream = stub->AdjustBundle(&context);
  WriteWork<v1::AdjustBundleRequest>(
      MakeAdjustment(), std::function<bool(v1::AdjustBundleRequest)>(
                            [&](v1::AdjustBundleRequest part) { return stream->Write(part); }));
  ASSERT_TRUE(worker_.started.WaitForNotificationWithTimeout(absl::Seconds(20)));
  context.TryCancel();
  EXPECT_TRUE(worker_.cancelled.WaitForNotificationWithTimeout(absl::Seconds(20)));
}

TEST_F(FusionWorkerServiceTest, AnEarlyEndIsRefused) {
  const auto stub = v1::FusionWorker::NewStub(channel_);
  grpc::ClientContext context;
  const auto stream = stub->FuseMaps(&context);
  v1::FuseMapsRequest header;
  header.mutable_header()->set_base_revision(1);
  stream->Write(header);
  stream->WritesDone();
  v1::FuseMapsResponse response;
  EXPECT_FALSE(stream->Read(&response));
  EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::INVALID_ARGUMENT);
}

TEST_F(FusionWorkerServiceTest, ADeadWorkerIsReplacedByAnother) {
  const auto pool = MakeRemoteFusionWorker({MakeChannel("127.0.0.1:1"), channel_});
  for (int i = 0; i < 3; ++i) {
    const auto result = pool->VerifyOverlap(MakeVerification(), GoOn);
    EXPECT_TRUE(result.ok()) << result.status();
  }
  const auto nobody = MakeRemoteFusionWorker({MakeChannel("127.0.0.1:1")});
  EXPECT_EQ(nobody->VerifyOverlap(MakeVerification(), GoOn).status().code(),
            absl::StatusCode::kUnavailable);
  EXPECT_EQ(MakeRemoteFusionWorker({})->VerifyOverlap(MakeVerification(), GoOn).status().code(),
            absl::StatusCode::kUnavailable);
}

// An address of another server in the list costs nothing but a try.
TEST_F(FusionWorkerServiceTest, AServerThatIsNoWorkerIsPassedOver) {
  const auto other = Server::Start("127.0.0.1:0", {});
  ASSERT_TRUE(other.ok()) << other.status();
  const auto pool = MakeRemoteFusionWorker({MakeChannel((*other)->address()), channel_});
  EXPECT_TRUE(pool->VerifyOverlap(MakeVerification(), GoOn).ok());
  RemoteFusionWorkerOptions options;
  options.explain = [](size_t worker, const absl::Status& seen) {
    EXPECT_EQ(worker, 0u);
    EXPECT_TRUE(absl::IsUnimplemented(seen)) << seen;
    return absl::UnavailableError("it is no fusion worker");
  };
  const auto none = MakeRemoteFusionWorker({MakeChannel((*other)->address())}, options);
  EXPECT_EQ(none->VerifyOverlap(MakeVerification(), GoOn).status(),
            absl::UnavailableError("it is no fusion worker"));
}

// The worker's server ends in the orderly way, but not so late that the request is done.
TEST_F(FusionWorkerServiceTest, AWorkerThatIsStoppedInTheMiddleIsReplaced) {
  class QuickWorker : public FakeFusionWorker {
    absl::StatusOr<AdjustBundleResult> AdjustBundle(const AdjustBundleRequest&,
                                                    const ProgressCallback&) override {
      AdjustBundleResult result;
      result.keyframes = 7;
      return result;
    }
  } quick;
  FusionWorkerService spare(&quick);
  const auto spare_server = Server::Start("127.0.0.1:0", {&spare});
  ASSERT_TRUE(spare_server.ok()) << spare_server.status();
  const auto pool = MakeRemoteFusionWorker(
      {MakeChannel(server_->address()), MakeChannel((*spare_server)->address())});
  absl::StatusOr<AdjustBundleResult> result = absl::UnknownError("not asked yet");
  std::thread asking([&] { result = pool->AdjustBundle(MakeAdjustment(), GoOn); });
  EXPECT_TRUE(worker_.started.WaitForNotificationWithTimeout(absl::Seconds(20)));
  const absl::Time start = absl::Now();
  server_->Shutdown(absl::Milliseconds(100));
  asking.join();
  EXPECT_LT(absl::Now() - start, absl::Seconds(10));
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->keyframes, 7);
}

TEST_F(FusionWorkerServiceTest, AFullWorkerSendsItsCallersElsewhere) {
  const auto stub = v1::FusionWorker::NewStub(channel_);
  grpc::ClientContext contexts[2];
  std::vector<
      std::unique_ptr<grpc::ClientReaderWriter<v1::AdjustBundleRequest, v1::AdjustBundleResponse>>>
      streams;
  for (grpc::ClientContext& context : contexts) streams.push_back(stub->AdjustBundle(&context));
  // Calls whose headers were written have arrived.
  for (const auto& stream : streams) {
    WriteWork<v1::AdjustBundleRequest>(
        MakeAdjustment(), std::function<bool(v1::AdjustBundleRequest)>(
                              [&](v1::AdjustBundleRequest part) { return stream->Write(part); }));
  }
  ASSERT_TRUE(worker_.started.WaitForNotificationWithTimeout(absl::Seconds(20)));
  const auto result = remote_->VerifyOverlap(MakeVerification(), GoOn);
  EXPECT_EQ(result.status().code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(std::string(result.status().message()), HasSubstr("2 requests already"));
  for (grpc::ClientContext& context : contexts) context.TryCancel();
}

}  // namespace
}  // namespace corbslam::services
