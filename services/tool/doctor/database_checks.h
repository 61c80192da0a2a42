// Checks the database that stores keep their missions in.
#ifndef CORBSLAM_SERVICES_TOOL_DOCTOR_DATABASE_CHECKS_H_
#define CORBSLAM_SERVICES_TOOL_DOCTOR_DATABASE_CHECKS_H_

#include <optional>
#include <string>
#include <vector>

#include "map_store/fleet/directory.h"
#include "map_store/fleet/fleet_counts.h"
#include "services/programs/store_journal.h"
#include "services/security/finding.h"

namespace corbslam::services {

// Returns what is the matter with the standbys that commits wait for; nullopt: nothing is known.
Finding JudgeStandbys(const std::optional<map_store::StandbyCounts>& standbys);
// Returns what is the matter with stores that share missions. None: there are none.
Findings JudgeStores(const std::vector<map_store::DirectoryStore>& stores);
// Checks whether the database is reached, takes writes, has the tables that this program needs and
// the standbys that its commits wait for, and whether stores that share its missions live.
Findings CheckDatabase(const JournalFlags& journal);

}  // namespace corbslam::services

#endif  // CORBSLAM_SERVICES_TOOL_DOCTOR_DATABASE_CHECKS_H_
