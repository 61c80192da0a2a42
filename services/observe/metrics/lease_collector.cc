#include "services/observe/metrics/lease_collector.h"

#include "services/observe/metrics/families.h"

namespace corbslam::services {

using map_store::FleetCounts;

namespace {

double Count(uint64_t value) { return static_cast<double>(value); }

void AddLeases(const FleetCounts& counts, Families& families) {
  families.Gauge("corbslam_leases_held", "Missions of the database that this store has.",
                 Count(counts.held));
  families.Counter("corbslam_leases_lost_total",
                   "Missions that another store took over from this one.", Count(counts.lost));
  families.Counter("corbslam_writes_refused_total",
                   "Writes into missions that another store had taken over.",
                   Count(counts.refused_writes));
  const auto given = [&families](const char* why, uint64_t value) {
    families.Counter("corbslam_missions_given_total",
                     "Missions that this store gave to another one, by why.", Count(value),
                     {{"why", why}});
  };
  given("balance", counts.given_to_balance);
  given("asked", counts.given - counts.given_to_balance);
}

void AddDatabase(const FleetCounts& counts, Families& families) {
  families.Gauge("corbslam_database_reached",
                 "0: leases could not be prolonged the last time, as the database was not there.",
                 counts.reaches_database ? 1 : 0);
  families.Counter("corbslam_database_unreached_total", "How often that was so.",
                   Count(counts.unreached));
  families.Counter("corbslam_database_pool_busy_total",
                   "How often no connection to the database was free for ten seconds.",
                   Count(counts.busy_pool));
  if (!counts.standbys.has_value()) return;
  families.Gauge("corbslam_database_standbys_wanted",
                 "Standbys that commits of the database wait for; 0: for none.",
                 Count(counts.standbys->wanted));
  families.Gauge("corbslam_database_standbys_there",
                 "Standbys that are connected to the database, of those.",
                 Count(counts.standbys->there));
}

}  // namespace

std::vector<prometheus::MetricFamily> LeaseCollector::Collect() const {
  Families families;
  if (leases_ == nullptr) return families.Take();
  const FleetCounts counts = leases_->counts();
  AddLeases(counts, families);
  if (counts.load.has_value()) {
    families.Gauge("corbslam_store_load",
                   "Share of the processors or of the memory budget that is used, whichever is "
                   "larger, over half a minute.",
                   counts.load->Pressure());
  }
  AddDatabase(counts, families);
  return families.Take();
}

}  // namespace corbslam::services
