// Simulates fleets (fleet_simulation.h) and prints what came of it, as a table and as JSON: many
// small ones with all that goes wrong, and one of a size that no machine here has, with a disaster.
// Ends with 1 if anything was that must not be.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/bench/fleet_simulation.h"

namespace corbslam::tests {
namespace {

using Json = nlohmann::ordered_json;

struct Flags {
  int seeds = 300;
  uint64_t first_seed = 1;
  FleetOptions small;
  bool large = false;
  int databases = 100;
  int stores = 1000;
  int missions = 100000;
  int robots = 1000000;
  std::string json;
};

// What small fleets came to, all together.
struct Sum {
  uint64_t fleets = 0;
  FleetResult all;
  double worst_p99_s = 0;
};

void Add(const FleetResult& one, Sum& sum) {
  ++sum.fleets;
  FleetResult& all = sum.all;
  all.events += one.events;
  all.acknowledged += one.acknowledged;
  all.faults += one.faults;
  all.takes += one.takes;
  all.lost += one.lost;
  all.refused_writes += one.refused_writes;
  all.balancing_moves += one.balancing_moves;
  all.drained_moves += one.drained_moves;
  all.redirects += one.redirects;
  all.interruptions += one.interruptions;
  all.interruption_max_s = std::max(all.interruption_max_s, one.interruption_max_s);
  all.violations.insert(all.violations.end(), one.violations.begin(), one.violations.end());
}

Json SimulateSmall(const Flags& flags, bool& good) {
  Sum sum;
  for (int i = 0; i < flags.seeds; ++i) {
    FleetOptions options = flags.small;
    options.seed = flags.first_seed + static_cast<uint64_t>(i);
    // Fleets of two to six stores, some of them under more than they bear.
    options.stores_per_database = 2 + static_cast<int>(options.seed % 5);
    options.missions_per_database = 4 * options.stores_per_database;
    Add(SimulateFleet(options), sum);
  }
  for (const std::string& violation : sum.all.violations) std::printf("%s\n", violation.c_str());
  good = good && sum.all.violations.empty();
  const FleetResult& all = sum.all;
  std::printf(
      "| fleets | faults | events | acknowledged | taken | lost | refused writes | balanced | "
      "drained | redirects | broken invariants |\n");
  std::printf("| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n");
  std::printf("| %lu | %lu | %lu | %lu | %lu | %lu | %lu | %lu | %lu | %lu | %zu |\n",
              static_cast<unsigned long>(sum.fleets), static_cast<unsigned long>(all.faults),
              static_cast<unsigned long>(all.events), static_cast<unsigned long>(all.acknowledged),
              static_cast<unsigned long>(all.takes), static_cast<unsigned long>(all.lost),
              static_cast<unsigned long>(all.refused_writes),
              static_cast<unsigned long>(all.balancing_moves),
              static_cast<unsigned long>(all.drained_moves),
              static_cast<unsigned long>(all.redirects), all.violations.size());
  return {{"fleets", sum.fleets},
          {"faults", all.faults},
          {"events", all.events},
          {"acknowledged", all.acknowledged},
          {"takes", all.takes},
          {"lost", all.lost},
          {"refused_writes", all.refused_writes},
          {"balancing_moves", all.balancing_moves},
          {"drained_moves", all.drained_moves},
          {"redirects", all.redirects},
          {"longest_interruption_s", all.interruption_max_s},
          {"violations", all.violations}};
}

Json SimulateLarge(const Flags& flags, bool& good) {
  const std::vector<std::pair<Disaster, const char*>> disasters = {
      {Disaster::kLostRack, "a tenth of the stores at once"},
      {Disaster::kLostDatabase, "one database for a minute"},
      {Disaster::kHerd, "all robots lose all stores for a minute"}};
  FleetOptions options;
  options.seed = flags.first_seed;
  options.databases = flags.databases;
  options.stores_per_database = flags.stores / flags.databases;
  options.missions_per_database = flags.missions / flags.databases;
  options.robots_per_mission = flags.robots / flags.missions;
  options.duration = absl::Minutes(3);
  options.calm = absl::Minutes(2);
  options.between_batches = absl::Seconds(10);
  options.between_faults = absl::InfiniteDuration();
  options.clock_error = 1e-3;
  Json all = Json::array();
  std::printf(
      "%d stores, %d databases, %d missions, %d robots\n"
      "| disaster | events | attempts/s at once | statements/s | most | appends/s | most | "
      "99 %% served after | all after | broken invariants |\n"
      "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n",
      flags.stores, flags.databases, flags.missions, flags.robots);
  for (const auto& [disaster, name] : disasters) {
    options.disaster = disaster;
    const FleetResult one = SimulateFleet(options);
    for (const std::string& violation : one.violations) std::printf("%s\n", violation.c_str());
    good = good && one.violations.empty();
    std::printf("| %s | %lu | %lu | %.1f | %lu | %.1f | %lu | %.1f s | %.1f s | %zu |\n", name,
                static_cast<unsigned long>(one.events),
                static_cast<unsigned long>(one.most_attempts), one.directory_statements,
                static_cast<unsigned long>(one.most_directory_statements), one.appends,
                static_cast<unsigned long>(one.most_appends), one.most_served_after_s,
                one.all_served_after_s, one.violations.size());
    std::fflush(stdout);
    all.push_back({{"disaster", name},
                   {"events", one.events},
                   {"most_attempts_a_second_and_database", one.most_attempts},
                   {"statements_a_second_and_database", one.directory_statements},
                   {"most_statements_a_second_and_database", one.most_directory_statements},
                   {"appends_a_second_and_database", one.appends},
                   {"most_appends_a_second_and_database", one.most_appends},
                   {"served_after_s_p99", one.most_served_after_s},
                   {"served_after_s_max", one.all_served_after_s},
                   {"balancing_moves", one.balancing_moves},
                   {"violations", one.violations}});
  }
  return all;
}

int Run(const Flags& flags) {
  bool good = true;
  Json json;
  if (flags.seeds > 0) json["small"] = SimulateSmall(flags, good);
  if (flags.large) json["large"] = SimulateLarge(flags, good);
  if (!flags.json.empty()) std::ofstream(flags.json) << json.dump(2) << '\n';
  return good ? 0 : 1;
}

}  // namespace
}  // namespace corbslam::tests

int main(int argc, char** argv) {
  corbslam::tests::Flags flags;
  CLI::App app("Simulates fleets of stores that share missions", "fleet_scale");
  app.add_option("--seeds", flags.seeds, "Small fleets, each of a seed of its own");
  app.add_option("--first-seed", flags.first_seed, "The first seed");
  app.add_flag("--large", flags.large, "Simulate the large fleet, with each disaster");
  app.add_option("--databases", flags.databases, "Of the large fleet");
  app.add_option("--stores", flags.stores, "Of the large fleet");
  app.add_option("--missions", flags.missions, "Of the large fleet");
  app.add_option("--robots", flags.robots, "Of the large fleet");
  app.add_option("--json", flags.json, "File for the figures");
  CLI11_PARSE(app, argc, argv);
  return corbslam::tests::Run(flags);
}
