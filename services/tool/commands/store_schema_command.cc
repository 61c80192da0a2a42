// Implements `corbslam store-schema`.
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "map_store/postgres/schema.h"
#include "services/tool/commands/commands.h"
#include "services/tool/output/result.h"
#include "slam/util/status_macros.h"

namespace corbslam::services {
namespace {

absl::Status PrintSchema(const std::string& role) {
  ASSIGN_OR_RETURN(const std::string sql, map_store::MakeSchemaSql(role));
  PrintResult(sql, {{"version", map_store::kSchemaVersion}, {"role", role}, {"sql", sql}});
  return absl::OkStatus();
}

}  // namespace

void AddStoreSchemaCommand(CLI::App& app, Command& chosen) {
  CLI::App* schema = app.add_subcommand(
      "store-schema",
      "Print the SQL of the tables of map_store --journal postgres:URI, for the database's "
      "administrator; it may be run again, and after an upgrade it is");
  auto role = std::make_shared<std::string>("corbslam");
  schema->add_option("--role", *role, "The role that map_store connects as; it must be there")
      ->capture_default_str();
  schema->callback([role, &chosen] { chosen = [role] { return PrintSchema(*role); }; });
}

}  // namespace corbslam::services
