#include "services/tool/doctor/database_checks.h"

#include <algorithm>
#include <memory>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "map_store/fleet/balance.h"
#include "map_store/postgres/fleet_directory.h"
#include "map_store/postgres/schema.h"
#include "map_store/postgres/sql_pool.h"

namespace corbslam::services {

using map_store::DirectoryStore;
using map_store::FleetDirectory;
using map_store::SqlPool;
using map_store::StandbyCounts;

namespace {

constexpr char kDatabase[] = "database";

Finding Failed(const absl::Status& status) {
  return {Level::kFail, kDatabase, std::string(status.message()),
          absl::IsUnavailable(status) ? "see whether the server runs, and who may connect to it"
                                      : "see docs/fleet.md, \"Setting it up\""};
}

}  // namespace

Finding JudgeStandbys(const std::optional<StandbyCounts>& standbys) {
  if (!standbys.has_value()) {
    return {Level::kOk, "standbys", "the database does not say whether commits wait for any", ""};
  }
  if (standbys->wanted == 0) {
    return {Level::kWarn, "standbys",
            "commits wait for no standby: what was acknowledged is lost with the primary's disk",
            "set synchronous_standby_names, as ANY 1 (...), where there are standbys"};
  }
  const std::string text = absl::StrCat("commits wait for ", standbys->wanted, " standbys, and ",
                                        standbys->there, " are connected");
  if (standbys->there < standbys->wanted) {
    return {Level::kFail, "standbys", text + ": nothing is acknowledged",
            "bring the standby back, or take it out of synchronous_standby_names"};
  }
  if (standbys->there > standbys->wanted) return {Level::kOk, "standbys", text, ""};
  return {Level::kWarn, "standbys", text + ": the next one that fails stops all commits",
          "have one standby more than commits wait for"};
}

Findings JudgeStores(const std::vector<DirectoryStore>& stores) {
  Findings findings;
  const size_t takers = static_cast<size_t>(
      std::count_if(stores.begin(), stores.end(),
                    [](const DirectoryStore& one) { return one.IsAlive() && !one.is_cordoned; }));
  for (const DirectoryStore& store : stores) {
    const std::string check = "store " + store.name;
    if (!store.IsAlive()) {
      findings.push_back({Level::kWarn, check, "it is gone",
                          "start it, if it is to be there; after a week it is forgotten"});
    } else if (store.load.has_value() && store.load->Pressure() > map_store::BalanceRules().above) {
      findings.push_back({Level::kWarn, check,
                          absl::StrFormat("its load is %.0f %%", store.load->Pressure() * 100),
                          "start another store, if this lasts and others have as much to do"});
    } else {
      findings.push_back({Level::kOk, check,
                          absl::StrCat("has ", store.missions, " missions",
                                       store.is_cordoned ? ", and takes no more" : ""),
                          ""});
    }
  }
  if (!stores.empty() && takers == 0) {
    findings.push_back({Level::kFail, "stores", "none is alive and takes missions",
                        "start one, or uncordon one (corbslam fleet)"});
  }
  return findings;
}

Findings CheckDatabase(const JournalFlags& journal) {
  if (const absl::Status flags = CheckJournalFlags(journal); !flags.ok()) return {Failed(flags)};
  const absl::StatusOr<std::unique_ptr<SqlPool>> pool = SqlPool::Make(PostgresOptionsOf(journal));
  if (!pool.ok()) return {Failed(pool.status())};
  absl::Status fit = (*pool)->CheckWrites();
  if (fit.ok()) fit = map_store::CheckSchema(**pool);
  if (!fit.ok()) return {Failed(fit)};
  Findings findings = {{Level::kOk, kDatabase,
                        absl::StrCat((*pool)->name(), " takes writes, and has the tables"), ""}};
  if (!(*pool)->warning().empty()) {
    findings.push_back({Level::kWarn, kDatabase, (*pool)->warning(), "see docs/fleet.md"});
  }
  const FleetDirectory fleet(pool->get());
  const absl::StatusOr<StandbyCounts> standbys = fleet.CountStandbys();
  findings.push_back(JudgeStandbys(standbys.ok() ? std::optional(*standbys) : std::nullopt));
  const absl::StatusOr<std::vector<DirectoryStore>> stores = fleet.ListStores();
  if (!stores.ok()) {
    findings.push_back(Failed(stores.status()));
    return findings;
  }
  const Findings of_stores = JudgeStores(*stores);
  findings.insert(findings.end(), of_stores.begin(), of_stores.end());
  return findings;
}

}  // namespace corbslam::services
