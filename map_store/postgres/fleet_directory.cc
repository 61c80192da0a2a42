#include "map_store/postgres/fleet_directory.h"

#include <algorithm>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "map_store/postgres/mission_row.h"
#include "map_store/postgres/sql_pool.h"
#include "slam/exchange/mission_elsewhere.h"
#include "slam/util/status_macros.h"

namespace corbslam::map_store {
namespace {

constexpr char kLook[] =
    "SELECT name, state, holder, holder_name,"
    " (SELECT address FROM corbslam.stores WHERE stores.holder = missions.holder LIMIT 1), epoch,"
    " coalesce(ceil(extract(epoch FROM lease_until - clock_timestamp()) * 1000), 0)::bigint, bytes,"
    " summary, summary_checksum, mission_id, wanted_store,"
    " (SELECT address FROM corbslam.stores WHERE stores.name = missions.wanted_store"
    " AND cordoned = 0 AND stores.lease_until > clock_timestamp())"
    " FROM corbslam.missions WHERE name = $1";
constexpr char kList[] =
    "SELECT name, state, holder, holder_name,"
    " (SELECT address FROM corbslam.stores WHERE stores.holder = missions.holder LIMIT 1), epoch,"
    " coalesce(ceil(extract(epoch FROM lease_until - clock_timestamp()) * 1000), 0)::bigint, bytes,"
    " summary, summary_checksum, mission_id, wanted_store,"
    " (SELECT address FROM corbslam.stores WHERE stores.name = missions.wanted_store"
    " AND cordoned = 0 AND stores.lease_until > clock_timestamp())"
    " FROM corbslam.missions WHERE name > $1 AND state IN (0, 3) ORDER BY name LIMIT $2";

absl::Duration LeaseLeft(int64_t milliseconds) {
  return std::max(absl::Milliseconds(milliseconds), absl::ZeroDuration());
}

double Thousandths(int64_t number) { return static_cast<double>(number) * 1e-3; }

// Returns how many standbys a value of synchronous_standby_names has commits wait for: "ANY 2 (a,
// b, c)", "FIRST 1 (a, b)", "2 (a, b)", and "a, b", of which one is waited for.
uint64_t CountWantedStandbys(absl::string_view names) {
  names = absl::StripAsciiWhitespace(names);
  if (names.empty()) return 0;
  const std::string words = absl::AsciiStrToLower(names.substr(0, names.find('(')));
  uint64_t wanted = 1;
  for (const absl::string_view word : absl::StrSplit(words, ' ', absl::SkipEmpty())) {
    if (absl::SimpleAtoi(word, &wanted)) break;
  }
  return names.find('(') == absl::string_view::npos ? 1 : wanted;
}

DirectoryMission MissionOf(const SqlResult& rows, int i, int64_t own) {
  DirectoryMission mission;
  mission.name = rows.Text(i, 0);
  mission.is_asleep = rows.Number(i, 1) == static_cast<int64_t>(MissionStage::kAside);
  mission.is_own = own != 0 && rows.Number(i, 2) == own && !mission.is_asleep;
  if (!mission.is_asleep) {
    mission.holder = rows.Text(i, 3);
    mission.address = rows.Text(i, 4);
    mission.lease_left = LeaseLeft(rows.Number(i, 6));
  }
  mission.epoch = rows.Number(i, 5);
  mission.bytes = rows.Bits(i, 7);
  std::string summary = rows.Text(i, 8);
  if (SummaryChecksum(summary) == rows.Bits(i, 9)) mission.summary = std::move(summary);
  mission.wanted = rows.Text(i, 11);
  mission.wanted_address = rows.Text(i, 12);
  return mission;
}

DirectoryStore StoreOf(const SqlResult& rows, int i, int64_t own) {
  DirectoryStore store;
  store.name = rows.Text(i, 0);
  store.is_own = own != 0 && rows.Number(i, 1) == own;
  store.address = rows.Text(i, 2);
  store.machine = rows.Text(i, 3);
  store.version = rows.Text(i, 4);
  store.is_cordoned = rows.Number(i, 5) != 0;
  store.is_drained = rows.Number(i, 5) == static_cast<int64_t>(FleetDirectory::Duty::kDrained);
  store.lease_left = LeaseLeft(rows.Number(i, 6));
  store.missions = rows.Bits(i, 7);
  if (!rows.IsNull(i, 8)) {
    store.load = StoreLoad{Thousandths(rows.Number(i, 8)), Thousandths(rows.Number(i, 9)),
                           rows.Bits(i, 10), rows.Bits(i, 11), Thousandths(rows.Number(i, 12))};
  }
  store.waiting_requests = rows.Bits(i, 13);
  store.workers = absl::StrSplit(rows.Text(i, 14), ',', absl::SkipEmpty());
  if (!rows.IsNull(i, 15)) store.since_balanced = absl::Milliseconds(rows.Number(i, 15));
  return store;
}

}  // namespace

absl::StatusOr<std::vector<DirectoryStore>> FleetDirectory::ListStores() const {
  ASSIGN_OR_RETURN(
      const std::vector<SqlResult> read,
      pool_.Read({{"SELECT name, holder, address, machine, version, cordoned,"
                   " coalesce(ceil(extract(epoch FROM lease_until - clock_timestamp()) * 1000),"
                   " 0)::bigint, (SELECT count(*) FROM corbslam.missions WHERE state = 0"
                   " AND missions.holder = stores.holder AND missions.lease_until >"
                   " clock_timestamp()), CASE WHEN load_until >= lease_until THEN busy_milli END,"
                   " processors_milli, resident_bytes, budget_bytes, keyframes_milli,"
                   " CASE WHEN load_until >= lease_until THEN waiting_requests END,"
                   " CASE WHEN load_until >= lease_until THEN workers END,"
                   " (extract(epoch FROM clock_timestamp() - balanced_at) * 1000)::bigint"
                   " FROM corbslam.stores ORDER BY name"}}));
  std::vector<DirectoryStore> stores;
  for (int i = 0; i < read.front().rows(); ++i) stores.push_back(StoreOf(read.front(), i, own_));
  return stores;
}

absl::StatusOr<std::vector<DirectoryMission>> FleetDirectory::List(absl::string_view after,
                                                                   size_t count) const {
  ASSIGN_OR_RETURN(
      const std::vector<SqlResult> read,
      pool_.Read({{kList, {SqlValue::Text(std::string(after)), SqlValue::Bits(count)}}}));
  std::vector<DirectoryMission> missions;
  for (int i = 0; i < read.front().rows(); ++i) {
    missions.push_back(MissionOf(read.front(), i, own_));
  }
  return missions;
}

absl::StatusOr<DirectoryMission> FleetDirectory::Look(absl::string_view name,
                                                      int64_t* row_id) const {
  ASSIGN_OR_RETURN(const std::vector<SqlResult> read,
                   pool_.Read({{kLook, {SqlValue::Text(std::string(name))}}}));
  if (read.front().rows() == 0) {
    return absl::NotFoundError(absl::StrCat(pool_.name(), " has no mission ", name));
  }
  if (row_id != nullptr) *row_id = read.front().Number(0, 10);
  return MissionOf(read.front(), 0, own_);
}

absl::StatusOr<DirectoryStore> FleetDirectory::FindStore(const std::string& store) const {
  ASSIGN_OR_RETURN(const std::vector<DirectoryStore> stores, ListStores());
  const DirectoryStore* found = nullptr;
  for (const DirectoryStore& one : stores) {
    if (one.name == store) return one;
    if (one.address != store) continue;
    if (found != nullptr) {
      return absl::FailedPreconditionError(absl::StrCat(pool_.name(), " has several stores at ",
                                                        store, ": ", found->name, ", ", one.name));
    }
    found = &one;
  }
  if (found != nullptr) return *found;
  return absl::NotFoundError(
      absl::StrCat(pool_.name(), " has no store ", store, " (corbslam fleet show lists them)"));
}

absl::StatusOr<std::string> FleetDirectory::SetDuty(const std::string& store, Duty duty) {
  ASSIGN_OR_RETURN(const DirectoryStore found, FindStore(store));
  RETURN_IF_ERROR(pool_
                      .WriteAgain({{"UPDATE corbslam.stores SET cordoned = $2 WHERE name = $1",
                                    {SqlValue::Text(found.name),
                                     SqlValue::Number(static_cast<int64_t>(duty))}}})
                      .status());
  return found.name;
}

absl::Status FleetDirectory::Move(const std::string& mission, const std::string& store) {
  ASSIGN_OR_RETURN(const DirectoryStore found, FindStore(store));
  if (!found.IsAlive() || found.is_cordoned) {
    return absl::FailedPreconditionError(
        absl::StrCat("store ", found.name,
                     found.IsAlive() ? " takes no missions: it is cordoned" : " is not alive"));
  }
  RETURN_IF_ERROR(Look(mission).status());
  return pool_
      .WriteAgain({{"UPDATE corbslam.missions SET wanted_store = $2 WHERE name = $1",
                    {SqlValue::Text(mission), SqlValue::Text(found.name)}}})
      .status();
}

absl::StatusOr<bool> FleetDirectory::BeginBalancing(const std::string& giver,
                                                    const std::string& taker,
                                                    absl::Duration rest) const {
  // Each row is looked at again once it is locked; a giver whose taker has gone to another one just
  // now rests in vain.
  ASSIGN_OR_RETURN(
      const std::vector<SqlResult> done,
      pool_.WriteAgain(
          {{"UPDATE corbslam.stores SET balanced_at = clock_timestamp() WHERE name IN ($1, $2)"
            " AND cordoned = 0 AND lease_until > clock_timestamp() AND (balanced_at IS NULL OR"
            " balanced_at <= clock_timestamp() - $3 * interval '1 millisecond')"
            " AND (SELECT count(*) FROM corbslam.stores AS pair WHERE pair.name IN ($1, $2)"
            " AND pair.cordoned = 0 AND pair.lease_until > clock_timestamp()"
            " AND (pair.balanced_at IS NULL OR pair.balanced_at <="
            " clock_timestamp() - $3 * interval '1 millisecond')) = 2",
            {SqlValue::Text(giver), SqlValue::Text(taker),
             SqlValue::Number(absl::ToInt64Milliseconds(rest))}}}));
  return done.front().changed() == 2;
}

absl::StatusOr<StandbyCounts> FleetDirectory::CountStandbys() const {
  // Who may not read statistics sees that standbys are connected, and not whether commits wait for
  // them.
  ASSIGN_OR_RETURN(
      const std::vector<SqlResult> read,
      pool_.Read({{"SELECT current_setting('synchronous_standby_names'),"
                   " (SELECT count(*) FROM pg_stat_replication WHERE sync_state IS NULL"
                   " OR sync_state IN ('sync', 'quorum'))"}}));
  return StandbyCounts{CountWantedStandbys(read.front().Text(0, 0)), read.front().Bits(0, 1)};
}

}  // namespace corbslam::map_store
