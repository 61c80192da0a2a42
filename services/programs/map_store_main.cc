// map_store collects the agents' maps, has them fused, and shares the result.
#include <glog/logging.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "fusion_worker/local_fusion_worker.h"
#include "map_store/mission/mission_load.h"
#include "map_store/store/map_store.h"
#include "services/command_line/setting.h"
#include "services/convert/resource_names.h"
#include "services/map_store_service/map_store_service.h"
#include "services/programs/backup_flags.h"
#include "services/programs/checks.h"
#include "services/programs/default_vocabulary.h"
#include "services/programs/limit_flags.h"
#include "services/programs/observe_flags.h"
#include "services/programs/program.h"
#include "services/programs/start_lines.h"
#include "services/programs/store_address.h"
#include "services/programs/store_backups.h"
#include "services/programs/store_journal.h"
#include "services/programs/store_observers.h"
#include "services/programs/store_workers.h"
#include "services/security/flags.h"
#include "services/server/memory_limit.h"
#include "services/server/readiness_watch.h"
#include "services/server/self_watch.h"
#include "services/server/server.h"
#include "slam/util/status_macros.h"
#include "slam/vocabulary/vocabulary.h"

namespace corbslam::services {

using fusion_worker::MakeLocalFusionWorker;
using map_store::MapStore;
using map_store::MapStoreOptions;

namespace {

// More of a mission has none.
constexpr double kMostItems = double{uint64_t{1} << 50};

constexpr double kSleepAfter_s = 600;

struct Flags {
  Flags() {
    store.sleep_after_s = kSleepAfter_s;
    store.wake_in_background = true;
  }

  std::string listen = "127.0.0.1:50051";
  std::vector<std::string> workers;
  bool in_process_worker = false;
  std::string vocabulary = DefaultVocabularyPath();
  JournalFlags journal;
  BackupFlags backup;
  // Nullopt: DefaultMemoryBudget().
  std::optional<uint64_t> memory_budget_bytes;
  bool keep_everything = false;
  bool keep_local_maps_apart = false;
  MapStoreOptions store;
  MapStoreServiceOptions service;
  SecurityOptions security;
  ObserveFlags observe;
  double drain_s = 2;
};

// Returns three quarters of the memory limit. The rest is for short-lived data: views for workers,
// snapshots, messages.
uint64_t DefaultMemoryBudget() { return MemoryLimitBytes() / 4 * 3; }

// Fusion in this process, or by workers; with neither, maps are not fused.
struct Fusion {
  std::unique_ptr<FusionWorker> here;
  std::unique_ptr<StoreWorkers> elsewhere;

  FusionWorker* worker() const { return elsewhere != nullptr ? elsewhere->worker() : here.get(); }
};

absl::StatusOr<Fusion> MakeFusion(const Flags& flags) {
  if (flags.in_process_worker && !flags.workers.empty()) {
    return absl::InvalidArgumentError("--worker and --in-process-worker exclude each other");
  }
  Fusion fusion;
  if (flags.in_process_worker) {
    fusion.here = MakeLocalFusionWorker();
    return fusion;
  }
  if (flags.workers.empty() && !flags.journal.is_shared()) {
    LOG(WARNING) << "no --worker and no --in-process-worker: maps are collected but never fused";
    return fusion;
  }
  ASSIGN_OR_RETURN(fusion.elsewhere, StoreWorkers::Connect(flags.workers, flags.security));
  return fusion;
}

std::vector<absl::Status> CheckWorkers(const Flags& flags) {
  std::vector<absl::Status> found;
  for (const std::string& worker : flags.workers) {
    found.push_back(CheckFlagServer("--worker", worker));
  }
  return found;
}

std::vector<absl::Status> Check(const Flags& flags) {
  std::vector<absl::Status> found = {
      flags.store.Validate(),
      flags.service.streams.Validate(),
      CheckFlagAddress("--listen", flags.listen),
      CheckServerSecurity(flags.security),
      MakeFusion(flags).status(),
      CheckVocabulary(flags.vocabulary),
  };
  const std::vector<absl::Status> workers = CheckWorkers(flags);
  found.insert(found.end(), workers.begin(), workers.end());
  found.push_back(CheckJournalFlags(flags.journal));
  found.push_back(CheckBackupFlags(flags.backup, flags.journal.data_dir));
  const std::vector<absl::Status> observing = CheckObserving(flags.observe);
  found.insert(found.end(), observing.begin(), observing.end());
  return found;
}

// Returns bytes for people, such as "1.5 MiB" or "20.0 GiB".
std::string FormatBytes(uint64_t bytes) {
  const double mib = static_cast<double>(bytes) / (1 << 20);
  return mib < 10000 ? absl::StrFormat("%.1f MiB", mib) : absl::StrFormat("%.1f GiB", mib / 1024);
}

std::string DescribeMissions(const JournalFlags& journal, size_t missions) {
  if (journal.lease_s > 0) return absl::StrCat("shares the missions in ", DescribeJournal(journal));
  return absl::StrCat(missions, missions == 1 ? " mission in " : " missions in ",
                      DescribeJournal(journal));
}

std::string DescribeFusion(const Flags& flags) {
  if (flags.in_process_worker) return "itself";
  if (flags.workers.empty()) return flags.journal.is_shared() ? "other stores' workers" : "nobody";
  return absl::StrJoin(flags.workers, ", ");
}

std::string DescribeStart(const Flags& flags, const std::string& address, size_t missions) {
  return absl::StrCat(
      "serves ", address, " ", DescribeServing(flags.security), "; ",
      DescribeMissions(flags.journal, missions), "; fusion by ", DescribeFusion(flags),
      "; memory budget ",
      flags.store.memory_budget_bytes == 0 ? "none" : FormatBytes(flags.store.memory_budget_bytes));
}

absl::Status Run(Flags flags) {
  flags.store.memory_budget_bytes = flags.memory_budget_bytes.value_or(DefaultMemoryBudget());
  flags.store.retire = !flags.keep_everything;
  flags.store.join_local_maps = !flags.keep_everything && !flags.keep_local_maps_apart;
  // Other stores' workers may do something for it, too.
  const int least_threads = flags.journal.is_shared() ? 2 : 1;
  flags.store.fusion_threads = std::max(least_threads, static_cast<int>(flags.workers.size()));
  flags.journal.workers = flags.workers;
  RETURN_IF_ERROR(flags.store.Validate());
  RETURN_IF_ERROR(flags.service.streams.Validate());
  RETURN_IF_ERROR(CheckBackupFlags(flags.backup, flags.journal.data_dir));
  for (const absl::Status& worker : CheckWorkers(flags)) RETURN_IF_ERROR(worker);
  ASSIGN_OR_RETURN(ServerSecurity security, MakeServerSecurity(flags.security));
  StoreObservers observers(flags.observe);
  ASSIGN_OR_RETURN(std::shared_ptr<const Vocabulary> vocabulary,
                   Vocabulary::Load(flags.vocabulary));
  ASSIGN_OR_RETURN(const Fusion fusion, MakeFusion(flags));
  ASSIGN_OR_RETURN(OpenedJournal opened, OpenJournal(flags.journal, flags.backup.scrub_mb_per_s));
  MapStore store(flags.store, vocabulary, observers.Watch(std::move(opened.journal)),
                 observers.Watch(fusion.worker()));
  store.SetExpiryListener(
      [auditor = security.server.auditor](const std::string& mission, const std::string& why) {
        if (auditor != nullptr) auditor->OnOwnDoing("mission_expired", MissionName(mission), why);
      });
  store.SetUidListener(
      [auditor = security.server.auditor](const std::string& mission, const std::string& uid) {
        if (auditor != nullptr) auditor->OnOwnDoing("mission_named", MissionName(mission), uid);
      });
  RETURN_IF_ERROR(store.Recover());
  ASSIGN_OR_RETURN(const std::unique_ptr<StoreBackups> backups,
                   StoreBackups::Make(flags.backup, &store, opened.rocks));
  MapStoreServiceOptions service_options = flags.service;
  service_options.door = security.access;
  service_options.observers = observers.OfStreams();
  service_options.backups = backups->backups();
  MapStoreService service(&store, service_options);
  ASSIGN_OR_RETURN(
      const auto metrics,
      observers.Serve(store, service, backups->MakeCollector(),
                      {{"journal", flags.journal.data_dir, flags.journal.min_free_mb << 20},
                       {"backups", opened.rocks == nullptr ? "" : flags.backup.directory}}));
  security.server.rpc_observer = observers.OfCalls();
  ASSIGN_OR_RETURN(const std::unique_ptr<Server> server,
                   Server::Start(flags.listen, {&service}, security.server));
  LOG(INFO) << DescribeStart(flags, server->address(), store.ListLoads().size());
  if (store.leases() != nullptr) {
    ASSIGN_OR_RETURN(const std::string name,
                     AnnounceStore(flags.journal.advertise, server->address(), *store.leases()));
    LOG(INFO) << "others send robots here as to " << name;
  }
  std::unique_ptr<OfferWatch> offers;
  if (store.leases() != nullptr && fusion.elsewhere != nullptr) {
    offers = std::make_unique<OfferWatch>(fusion.elsewhere.get(), store.leases());
  }
  AnnounceAddress(server->address());
  SelfWatch watch(
      {.address = server->reachable(),
       .on_change = [&server](const absl::Status& status) { server->SetAlive(status.ok()); }});
  ReadinessWatch readiness(server.get(), [&store, &watch]() -> absl::Status {
    RETURN_IF_ERROR(watch.status());
    return store.CheckWritable();
  });
  backups->Start();
  WaitForStopSignal();
  watch.Stop();
  readiness.Stop();
  offers.reset();
  server->SetReady(false);
  backups->Stop();
  service.EndStreams();
  server->Shutdown(absl::Seconds(flags.drain_s));
  return absl::OkStatus();
}

std::vector<Setting> PlaceRows(Flags& flags) {
  return {
      {"--listen", &flags.listen, "HOST:PORT to serve on; port 0: any free one"},
      {"--worker",
       &flags.workers,
       "HOST:PORT of a fusion worker; may be repeated",
       {.delimiter = ','}},
      {"--in-process-worker", &flags.in_process_worker, "Fuse in this process"},
      {"--data-dir", &flags.journal.data_dir,
       "Folder that keeps the missions; made if it is not there. Without, and without --journal: "
       "in memory"},
      {"--journal",
       &flags.journal.journal,
       "Database that keeps the missions instead: postgres:URI, as libpq takes it",
       {.unit = "URI"}},
      {"--journal-password-file", &flags.journal.password_file,
       "File with the database's password alone, read again for each connection", kRare},
      {"--journal-lease", &flags.journal.lease_s,
       "Share the database's missions with other stores: each has those that it was asked for "
       "first, until it sleeps, or was silent for so many seconds, at least 3; 0: this one takes "
       "all",
       RareWithin(0, 3600)},
      {"--balance-above", &flags.journal.balance_above,
       "With --journal-lease: share of its processors or of --memory-budget beyond which a store "
       "gives missions to others that have less to do, one a minute at most; 0: never",
       RareWithin(0, 1)},
      {"--advertise", &flags.journal.advertise,
       "HOST:PORT where other stores of the database send robots, tools and viewers of this one's "
       "missions. Default: --listen, with the machine's name for all addresses",
       kRare},
      {"--min-free-mb", &flags.journal.min_free_mb,
       "MiB that are left free on its disk; with less, agents are told to wait",
       RareWithin(0, 1 << 20)},
      {"--vocabulary", &flags.vocabulary, "File of the bag of words"},
      // A number without a unit is one of bytes, which is hardly ever meant.
      {"--memory-budget",
       &flags.memory_budget_bytes,
       "Memory of the process, as 6GiB or 600MiB, beyond which nothing is taken in; 0: no limit. "
       "Default: three quarters of the container's or the machine's",
       {.in = Bytes(uint64_t{64} << 20, kMostBytes, "no limit")}},
  };
}

std::vector<Setting> WorkRows(Flags& flags) {
  return {
      {"--sleep-after", &flags.store.sleep_after_s,
       "Seconds after which a mission that nobody uses leaves memory, and is read again when "
       "somebody wants it; needs --data-dir or --journal; 0: never",
       Within(0, 1e9)},
      {"--threads", &flags.service.threads, "Threads that apply batches and answer",
       Within(1, 256)},
      {"--adjust-threads", &flags.store.adjust_threads, "Solver threads of a bundle adjustment",
       RareWithin(1, 64)},
      {"--cull-share", &flags.store.cull_share,
       "Keyframes whose points three others see to this share are culled; 0: none",
       RareWithin(0, 1)},
      {"--cull-target", &flags.store.cull_target,
       "Keyframes of an island beyond which the most redundant are culled; 0: none",
       RareWithin(0, kMostItems)},
      {"--keep-everything", &flags.keep_everything,
       "Keep also keyframes of closed sessions that others stand in for, and points that have "
       "vanished"},
      {"--keep-local-maps-apart", &flags.keep_local_maps_apart,
       "Keep a local map of each session of a robot, also of old ones that fusion joined", kRare},
      {"--keep-local-maps", &flags.store.keep_local_maps,
       "A robot's newest closed local maps that stay as they are", RareWithin(0, kMostItems)},
      {"--max-shared-keyframes", &flags.store.max_shared_keyframes,
       "Others' keyframes that one agent is sent at most", Within(0, kMostItems)},
      {"--shared-bytes", &flags.service.shared_bytes, "Bytes of one shared update, about",
       RareWithin(1024, 2 << 20)},
      {"--drain", &flags.drain_s, "Seconds that streams have to end after SIGTERM",
       Within(0, 3600)},
  };
}

void AddFlags(CLI::App& app, Flags& flags) {
  AddSettings(app, PlaceRows(flags));
  AddBackupFlags(app, flags.backup);
  AddSettings(app, WorkRows(flags));
  AddStoreLimitFlags(app, flags.store);
  AddStreamLimitFlags(app, flags.service.streams);
  AddTlsFlags(app, flags.security);
  AddServerFlags(app, flags.security);
  AddClientFlags(app, flags.security);
  AddMetricsFlag(app, flags.observe);
}

}  // namespace
}  // namespace corbslam::services

int main(int argc, char** argv) {
  corbslam::services::BlockStopSignals();
  corbslam::services::Flags flags;
  CLI::App app("Collects the maps of agents, has them fused, and shares the result", "map_store");
  corbslam::services::AddFlags(app, flags);
  return corbslam::services::RunProgram(app, argc, argv,
                                        {[&] { return corbslam::services::Run(flags); },
                                         [&] { return corbslam::services::Check(flags); }});
}
