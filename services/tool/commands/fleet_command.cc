// Implements `corbslam fleet`: the stores that share the missions of a database.
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "map_store/postgres/fleet_directory.h"
#include "map_store/postgres/schema.h"
#include "map_store/postgres/sql_pool.h"
#include "services/programs/store_journal.h"
#include "services/tool/commands/commands.h"
#include "services/tool/output/result.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {

using map_store::DirectoryMission;
using map_store::DirectoryStore;
using map_store::FleetDirectory;
using map_store::SqlPool;
using map_store::StandbyCounts;

namespace {

constexpr size_t kListedAtOnce = 500;

struct FleetArguments {
  JournalFlags journal;
  std::string store;
  std::string mission;
};

absl::StatusOr<std::unique_ptr<SqlPool>> OpenDatabase(const FleetArguments& arguments) {
  RETURN_IF_ERROR(CheckJournalFlags(arguments.journal));
  ASSIGN_OR_RETURN(std::unique_ptr<SqlPool> pool,
                   SqlPool::Make(PostgresOptionsOf(arguments.journal)));
  RETURN_IF_ERROR(map_store::CheckSchema(*pool));
  return pool;
}

std::string StateOf(const DirectoryStore& store) {
  if (!store.IsAlive()) return store.is_cordoned ? "gone, cordoned" : "gone";
  if (store.is_drained) return "drained";
  return store.is_cordoned ? "cordoned" : "alive";
}

std::string StateOf(const DirectoryMission& mission) {
  if (mission.is_asleep) return "asleep";
  return mission.lease_left > absl::ZeroDuration() ? "held" : "free";
}

std::string Seconds(absl::Duration left) {
  return left > absl::ZeroDuration() ? absl::StrFormat("%.1f s", absl::ToDoubleSeconds(left)) : "-";
}

// Returns null where the store does not say.
nlohmann::ordered_json LoadOf(const DirectoryStore& store) {
  if (!store.load.has_value() || !store.IsAlive()) return nullptr;
  return {{"pressure", store.load->Pressure()},
          {"busy_processors", store.load->busy_processors},
          {"processors", store.load->processors},
          {"resident_bytes", store.load->resident_bytes},
          {"memory_budget_bytes", store.load->budget_bytes},
          {"keyframes_per_s", store.load->keyframes_per_s},
          {"fusion_requests_waiting", store.waiting_requests}};
}

nlohmann::ordered_json ToJson(const DirectoryStore& store) {
  return {{"name", store.name},
          {"address", store.address},
          {"machine", store.machine},
          {"version", store.version},
          {"state", StateOf(store)},
          {"missions", store.missions},
          {"lease_left_s", absl::ToDoubleSeconds(store.lease_left)},
          {"load", LoadOf(store)},
          {"workers", store.workers}};
}

std::string Describe(const DirectoryStore& store) {
  std::string load = "load not known";
  if (store.load.has_value()) {
    load = absl::StrFormat(
        "load %3.0f %%: %.1f of %.1f processors, %.0f MiB, %.1f keyframes/s",
        store.load->Pressure() * 100, store.load->busy_processors, store.load->processors,
        static_cast<double>(store.load->resident_bytes) / (1 << 20), store.load->keyframes_per_s);
  }
  return absl::StrFormat("%-32s %-9s %4d missions %8s  %s%s\n", store.name, StateOf(store),
                         store.missions, Seconds(store.lease_left), store.version,
                         store.IsAlive() ? "  " + load : "");
}

nlohmann::ordered_json ToJson(const DirectoryMission& mission) {
  return {
      {"name", mission.name},        {"state", StateOf(mission)},
      {"address", mission.address},  {"process", mission.holder},
      {"epoch", mission.epoch},      {"lease_left_s", absl::ToDoubleSeconds(mission.lease_left)},
      {"wanted_at", mission.wanted}, {"bytes", mission.bytes}};
}

std::string Describe(const DirectoryMission& mission) {
  const bool is_held = mission.lease_left > absl::ZeroDuration();
  const std::string address = mission.address.empty() ? mission.holder : mission.address;
  return absl::StrFormat("%-32s %-7s %-28s epoch %-5d %8s %10.1f MiB%s\n", mission.name,
                         StateOf(mission), is_held ? address : "-", mission.epoch,
                         Seconds(mission.lease_left),
                         static_cast<double>(mission.bytes) / (1 << 20),
                         mission.wanted.empty() ? "" : ", wanted at " + mission.wanted);
}

absl::StatusOr<std::vector<DirectoryMission>> ListAll(const FleetDirectory& fleet) {
  std::vector<DirectoryMission> missions;
  while (true) {
    ASSIGN_OR_RETURN(const std::vector<DirectoryMission> page,
                     fleet.List(missions.empty() ? "" : missions.back().name, kListedAtOnce));
    if (page.empty()) return missions;
    missions.insert(missions.end(), page.begin(), page.end());
  }
}

// Sums up the whole fleet.
nlohmann::ordered_json TotalsOf(const std::vector<DirectoryStore>& stores,
                                const std::vector<DirectoryMission>& missions) {
  uint64_t alive = 0;
  uint64_t waiting = 0;
  double keyframes_per_s = 0;
  std::set<std::string> workers;
  for (const DirectoryStore& store : stores) {
    if (!store.IsAlive()) continue;
    ++alive;
    waiting += store.waiting_requests;
    keyframes_per_s += store.load.has_value() ? store.load->keyframes_per_s : 0;
    workers.insert(store.workers.begin(), store.workers.end());
  }
  std::map<std::string, uint64_t> states = {{"asleep", 0}, {"held", 0}, {"free", 0}};
  uint64_t bytes = 0;
  for (const DirectoryMission& mission : missions) {
    ++states[StateOf(mission)];
    bytes += mission.bytes;
  }
  return {{"stores_alive", alive},
          {"missions", missions.size()},
          {"missions_held", states["held"]},
          {"missions_asleep", states["asleep"]},
          {"missions_free", states["free"]},
          {"bytes", bytes},
          {"keyframes_per_s", keyframes_per_s},
          {"workers", workers.size()},
          {"fusion_requests_waiting", waiting}};
}

absl::Status Show(const FleetArguments& arguments) {
  ASSIGN_OR_RETURN(const std::unique_ptr<SqlPool> pool, OpenDatabase(arguments));
  const FleetDirectory fleet(pool.get());
  ASSIGN_OR_RETURN(const std::vector<DirectoryStore> stores, fleet.ListStores());
  ASSIGN_OR_RETURN(const std::vector<DirectoryMission> missions, ListAll(fleet));
  std::string text = absl::StrCat(stores.size(), " stores\n");
  nlohmann::ordered_json json = {{"totals", TotalsOf(stores, missions)},
                                 {"stores", nlohmann::ordered_json::array()},
                                 {"missions", nlohmann::ordered_json::array()}};
  for (const DirectoryStore& store : stores) {
    text += Describe(store);
    json["stores"].push_back(ToJson(store));
  }
  const absl::StatusOr<StandbyCounts> standbys = fleet.CountStandbys();
  if (standbys.ok()) {
    json["database"] = {{"standbys_wanted", standbys->wanted}, {"standbys_there", standbys->there}};
    if (standbys->there < standbys->wanted) {
      absl::StrAppend(&text, "the database's commits wait for ", standbys->wanted,
                      " standbys, and only ", standbys->there,
                      " are connected: nothing is acknowledged\n");
    }
  }
  absl::StrAppend(&text, missions.size(), " missions\n");
  for (const DirectoryMission& mission : missions) {
    text += Describe(mission);
    json["missions"].push_back(ToJson(mission));
  }
  PrintResult(text, json);
  return absl::OkStatus();
}

absl::Status SetDuty(const FleetArguments& arguments, FleetDirectory::Duty duty, const char* what) {
  ASSIGN_OR_RETURN(const std::unique_ptr<SqlPool> pool, OpenDatabase(arguments));
  ASSIGN_OR_RETURN(const std::string name,
                   FleetDirectory(pool.get()).SetDuty(arguments.store, duty));
  PrintResult(absl::StrCat("store ", name, " ", what, "\n"), {{"store", name}, {"says", what}});
  return absl::OkStatus();
}

absl::Status Move(const FleetArguments& arguments) {
  ASSIGN_OR_RETURN(const std::unique_ptr<SqlPool> pool, OpenDatabase(arguments));
  RETURN_IF_ERROR(FleetDirectory(pool.get()).Move(arguments.mission, arguments.store));
  PrintResult(absl::StrCat("mission ", arguments.mission, " goes to ", arguments.store,
                           " within a third of a lease\n"),
              {{"mission", arguments.mission}, {"store", arguments.store}});
  return absl::OkStatus();
}

using FleetRun = std::function<absl::Status(const FleetArguments& arguments)>;

CLI::App* AddAction(CLI::App& fleet, const char* name, const char* what, FleetRun run,
                    const std::shared_ptr<FleetArguments>& arguments, Command& chosen) {
  CLI::App* action = fleet.add_subcommand(name, what);
  action
      ->add_option("--journal", arguments->journal.journal,
                   "The stores' database, as map_store takes it: postgres:URI")
      ->required();
  action->add_option("--journal-password-file", arguments->journal.password_file,
                     "File with the database's password alone");
  action->callback(
      [run = std::move(run), arguments, &chosen] { chosen = [=] { return run(*arguments); }; });
  return action;
}

void AddDuty(CLI::App& fleet, const char* name, const char* what, FleetDirectory::Duty duty,
             const char* said, const std::shared_ptr<FleetArguments>& arguments, Command& chosen) {
  const auto run = [duty, said](const FleetArguments& given) { return SetDuty(given, duty, said); };
  AddAction(fleet, name, what, run, arguments, chosen)
      ->add_option("STORE", arguments->store, "Its name or address, as `show` has it")
      ->required();
}

}  // namespace

void AddFleetCommand(CLI::App& app, Command& chosen) {
  CLI::App* fleet =
      app.add_subcommand("fleet", "Stores that share the missions of a database (--journal-lease)");
  fleet->require_subcommand(1);
  const auto arguments = std::make_shared<FleetArguments>();
  AddAction(*fleet, "show", "Stores and missions: who has which, until when", Show, arguments,
            chosen);
  CLI::App* move = AddAction(*fleet, "move", "Have a mission go to another store, with its robots",
                             Move, arguments, chosen);
  move->add_option("MISSION", arguments->mission, "Its name")->required();
  move->add_option("STORE", arguments->store, "Its name or address, as `show` has it")->required();
  AddDuty(*fleet, "drain", "Have all missions of a store go to others; it takes no more",
          FleetDirectory::Duty::kDrained, "gives its missions away and takes no more", arguments,
          chosen);
  AddDuty(*fleet, "cordon", "Have a store take no more missions", FleetDirectory::Duty::kCordoned,
          "takes no more missions", arguments, chosen);
  AddDuty(*fleet, "uncordon", "Have a store take missions again",
          FleetDirectory::Duty::kTakesMissions, "takes missions", arguments, chosen);
}

}  // namespace corbslam::services
