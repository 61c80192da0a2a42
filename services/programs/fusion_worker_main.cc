// fusion_worker computes for map stores.
#include <glog/logging.h>

#include <filesystem>
#include <memory>
#include <string>
#include <system_error>
#include <vector>

#include "absl/strings/str_cat.h"
#include "fusion_worker/local_fusion_worker.h"
#include "services/command_line/setting.h"
#include "services/fusion_worker_service/fusion_worker_service.h"
#include "services/observe/adjustment_files/saving_fusion_worker.h"
#include "services/programs/checks.h"
#include "services/programs/observe_flags.h"
#include "services/programs/program.h"
#include "services/programs/start_lines.h"
#include "services/programs/worker_observers.h"
#include "services/security/flags.h"
#include "services/server/self_watch.h"
#include "services/server/server.h"
#include "slam/util/memory_returner.h"
#include "slam/util/status_macros.h"
#include "slam/util/thread_priority.h"

namespace corbslam::services {

using fusion_worker::FusionWorkerOptions;
using fusion_worker::MakeLocalFusionWorker;

namespace {

struct Flags {
  std::string listen = "127.0.0.1:50052";
  FusionWorkerOptions worker;
  FusionWorkerServiceOptions service;
  SecurityOptions security;
  // Steps by which the process lowers its priority. It may share the machine with a map store, and
  // robots wait for that one.
  int niceness = 5;
  // Limit on a connection's age: if many workers have one name, stores get to know new workers by
  // new connections.
  double max_connection_age_s = 300;
  ObserveFlags observe;
  double drain_s = 2;
  std::string keep_adjustments;
};

std::vector<absl::Status> Check(const Flags& flags) {
  std::vector<absl::Status> found = CheckObserving(flags.observe);
  found.push_back(CheckFlagAddress("--listen", flags.listen));
  found.push_back(CheckServerSecurity(flags.security));
  if (!flags.keep_adjustments.empty()) {
    found.push_back(CheckFolder("--keep-adjustments", flags.keep_adjustments));
  }
  return found;
}

// Makes a worker that keeps adjustments in `folder`; null if `folder` is empty.
absl::StatusOr<std::unique_ptr<FusionWorker>> Keep(const std::string& folder,
                                                   FusionWorker* worker) {
  if (folder.empty()) return nullptr;
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) {
    return absl::UnavailableError(
        absl::StrCat("--keep-adjustments ", folder, ": ", error.message()));
  }
  return MakeSavingFusionWorker(worker, folder);
}

absl::Status Run(Flags flags) {
  // The priority counts for this thread and all threads that it will start.
  RETURN_IF_ERROR(LowerThreadPriority(flags.niceness));
  ASSIGN_OR_RETURN(ServerSecurity security, MakeServerSecurity(flags.security));
  security.server.max_connection_age = absl::Seconds(flags.max_connection_age_s);
  WorkerObservers observers(flags.observe);
  const std::unique_ptr<FusionWorker> local = MakeLocalFusionWorker(flags.worker);
  ASSIGN_OR_RETURN(const std::unique_ptr<FusionWorker> keeping,
                   Keep(flags.keep_adjustments, local.get()));
  FusionWorker* const worker = keeping != nullptr ? keeping.get() : local.get();
  MemoryReturner returner;
  returner.Start();
  flags.service.when_done = [&returner] { returner.Wake(); };
  FusionWorkerService service(observers.Watch(worker), flags.service);
  ASSIGN_OR_RETURN(const auto metrics, observers.Serve(service));
  security.server.rpc_observer = observers.OfCalls();
  ASSIGN_OR_RETURN(const std::unique_ptr<Server> server,
                   Server::Start(flags.listen, {&service}, security.server));
  LOG(INFO) << "serves " << server->address() << " " << DescribeServing(flags.security)
            << "; works on " << flags.service.threads << " requests at once, holds "
            << flags.service.max_requests;
  AnnounceAddress(server->address());
  SelfWatch watch(
      {.address = server->reachable(), .on_change = [&server](const absl::Status& status) {
         server->SetAlive(status.ok());
         server->SetReady(status.ok());
       }});
  WaitForStopSignal();
  watch.Stop();
  server->Shutdown(absl::Seconds(flags.drain_s));
  return absl::OkStatus();
}

void AddFlags(CLI::App& app, Flags& flags) {
  AddSettings(
      app,
      {
          {"--listen", &flags.listen, "HOST:PORT to serve on; port 0: any free one"},
          {"--requests", &flags.service.threads, "Requests that are worked on at once",
           Within(1, 256)},
          {"--max-requests", &flags.service.max_requests,
           "Requests that are held at once; further ones are sent elsewhere", Within(1, 10000)},
          {"--threads", &flags.worker.threads, "Solver threads of fusing a request", Within(1, 64)},
          {"--seed", &flags.worker.seed, "Of all random choices"},
          {"--niceness", &flags.niceness,
           "Steps that its threads are nicer than it was started: 0 like others, 19 only when "
           "nobody else wants the processor",
           Within(0, 19)},
          {"--max-connection-age", &flags.max_connection_age_s,
           "Seconds after which a store is asked to connect anew", Within(1, 1e6)},
          {"--drain", &flags.drain_s, "Seconds that requests have to end after SIGTERM",
           Within(0, 3600)},
          {"--keep-adjustments", &flags.keep_adjustments,
           "Folder that each request to adjust is written to, to find out why a map is as it is; "
           "nothing in it is deleted"},
      });
  AddTlsFlags(app, flags.security);
  AddServerFlags(app, flags.security);
  AddMetricsFlag(app, flags.observe);
}

}  // namespace
}  // namespace corbslam::services

int main(int argc, char** argv) {
  corbslam::services::BlockStopSignals();
  corbslam::services::Flags flags;
  CLI::App app("Verifies overlaps, fuses maps and adjusts bundles for map stores", "fusion_worker");
  corbslam::services::AddFlags(app, flags);
  return corbslam::services::RunProgram(app, argc, argv,
                                        {[&] { return corbslam::services::Run(flags); },
                                         [&] { return corbslam::services::Check(flags); }});
}
