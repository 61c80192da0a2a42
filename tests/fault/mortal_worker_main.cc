// mortal_worker KIND NUMBER: a fusion worker that is killed (SIGKILL) in the middle of its
// NUMBERth request of a kind (verify, fuse or adjust).
#include <glog/logging.h>
#include <signal.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <memory>
#include <string>

#include "fusion_worker/local_fusion_worker.h"
#include "services/fusion_worker_service/fusion_worker_service.h"
#include "services/server/server.h"

namespace corbslam {
namespace {

class MortalWorker : public FusionWorker {
 public:
  MortalWorker(std::string kind, int last) : kind_(std::move(kind)), left_(last) {}

  absl::StatusOr<VerifyOverlapResult> VerifyOverlap(const VerifyOverlapRequest& request,
                                                    const ProgressCallback& progress) override {
    const auto result = worker_->VerifyOverlap(request, progress);
    MeetFate("verify");
    return result;
  }
  absl::StatusOr<FuseMapsResult> FuseMaps(const FuseMapsRequest& request,
                                          const ProgressCallback& progress) override {
    const auto result = worker_->FuseMaps(request, progress);
    MeetFate("fuse");
    return result;
  }
  absl::StatusOr<AdjustBundleResult> AdjustBundle(const AdjustBundleRequest& request,
                                                  const ProgressCallback& progress) override {
    const auto result = worker_->AdjustBundle(request, progress);
    MeetFate("adjust");
    return result;
  }

 private:
  // The work is done and nobody knows: the worst moment.
  void MeetFate(const std::string& kind) {
    if (kind == kind_ && --left_ == 0) kill(getpid(), SIGKILL);
  }

  const std::string kind_;
  std::atomic<int> left_;
  const std::unique_ptr<FusionWorker> worker_ = MakeLocalFusionWorker();
};

}  // namespace
}  // namespace corbslam

int main(int argc, char** argv) {
  corbslam::BlockStopSignals();
  std::string kind;
  int number = 1;
  std::string listen = "127.0.0.1:0";
  CLI::App app("A fusion worker that is killed in the middle of a request", "mortal_worker");
  app.add_option("kind", kind, "verify, fuse or adjust")
      ->required()
      ->check(CLI::IsMember({"verify", "fuse", "adjust"}));
  app.add_option("number", number, "Of the request of that kind")->required();
  app.add_option("--listen", listen, "HOST:PORT to serve on");
  bool insecure = false;
  app.add_flag("--insecure", insecure, "Without TLS, which it always is");
  CLI11_PARSE(app, argc, argv);
  corbslam::MortalWorker worker(kind, number);
  corbslam::FusionWorkerService service(&worker);
  const auto server = corbslam::Server::Start(listen, {&service});
  if (!server.ok()) {
    LOG(ERROR) << server.status();
    return 1;
  }
  corbslam::AnnounceAddress((*server)->address());
  corbslam::WaitForStopSignal();
  return 0;
}
