// mortal_worker KIND NUMBER MOMENT: a fusion worker that is killed (SIGKILL) in its NUMBERth
// request of a kind (verify, fuse or adjust), while it computes or when it has the result.
#include <glog/logging.h>
#include <signal.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>

#include "fusion_worker/local_fusion_worker.h"
#include "services/fusion_worker_service/fusion_worker_service.h"
#include "services/server/server.h"

namespace corbslam::tests {

using fusion_worker::MakeLocalFusionWorker;

namespace {

class MortalWorker : public FusionWorker {
 public:
  MortalWorker(std::string kind, int last, bool dies_midway)
      : kind_(std::move(kind)), dies_midway_(dies_midway), left_(last) {}

  absl::StatusOr<VerifyOverlapResult> VerifyOverlap(const VerifyOverlapRequest& request,
                                                    const ProgressCallback& progress) override {
    return Do("verify", progress, [&](const ProgressCallback& mortal) {
      return worker_->VerifyOverlap(request, mortal);
    });
  }
  absl::StatusOr<FuseMapsResult> FuseMaps(const FuseMapsRequest& request,
                                          const ProgressCallback& progress) override {
    return Do("fuse", progress,
              [&](const ProgressCallback& mortal) { return worker_->FuseMaps(request, mortal); });
  }
  absl::StatusOr<AdjustBundleResult> AdjustBundle(const AdjustBundleRequest& request,
                                                  const ProgressCallback& progress) override {
    return Do("adjust", progress, [&](const ProgressCallback& mortal) {
      return worker_->AdjustBundle(request, mortal);
    });
  }

 private:
  template <typename Work>
  std::invoke_result_t<Work, ProgressCallback> Do(const std::string& kind,
                                                  const ProgressCallback& progress,
                                                  const Work& work) {
    const bool is_due = kind == kind_ && --left_ <= 0;
    const auto result = work([&](double part) {
      if (is_due && dies_midway_ && part >= Midway(kind)) Die();
      return progress == nullptr || progress(part);
    });
    // The work is done and nobody knows.
    if (is_due && !dies_midway_) Die();
    return result;
  }
  // Verifying reports between candidates only, of which there may be one.
  static double Midway(const std::string& kind) { return kind == "verify" ? 0 : 0.3; }
  static void Die() { kill(getpid(), SIGKILL); }

  const std::string kind_;
  const bool dies_midway_;
  std::atomic<int> left_;
  const std::unique_ptr<FusionWorker> worker_ = MakeLocalFusionWorker();
};

}  // namespace
}  // namespace corbslam::tests

int main(int argc, char** argv) {
  corbslam::services::BlockStopSignals();
  std::string kind;
  int number = 1;
  std::string moment;
  std::string listen = "127.0.0.1:0";
  CLI::App app("A fusion worker that is killed in a request", "mortal_worker");
  app.add_option("kind", kind, "verify, fuse or adjust")
      ->required()
      ->check(CLI::IsMember({"verify", "fuse", "adjust"}));
  app.add_option("number", number, "Of the request of that kind")->required();
  app.add_option("moment", moment, "midway or done")
      ->required()
      ->check(CLI::IsMember({"midway", "done"}));
  app.add_option("--listen", listen, "HOST:PORT to serve on");
  bool insecure = false;
  app.add_flag("--insecure", insecure, "Without TLS, which it always is");
  CLI11_PARSE(app, argc, argv);
  corbslam::tests::MortalWorker worker(kind, number, moment == "midway");
  corbslam::services::FusionWorkerService service(&worker);
  const auto server = corbslam::services::Server::Start(listen, {&service});
  if (!server.ok()) {
    LOG(ERROR) << server.status();
    return 1;
  }
  corbslam::services::AnnounceAddress((*server)->address());
  corbslam::services::WaitForStopSignal();
  return 0;
}
