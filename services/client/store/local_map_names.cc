#include "services/client/store/local_map_names.h"

#include <cstddef>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "services/convert/resource_names.h"

namespace corbslam::services {
namespace {

std::string ShortName(const std::string& agent, uint32_t number) {
  return absl::StrCat(agent, "/", number);
}

}  // namespace

LocalMapNames ShortNames(const std::vector<v1::LocalMap>& local_maps) {
  LocalMapNames names;
  std::map<std::string, uint32_t> counts;
  for (const v1::LocalMap& local_map : local_maps) {
    const std::string agent = LastSegment(local_map.agent());
    const uint32_t count = ++counts[agent];
    const uint32_t number = local_map.number() == 0 ? count : local_map.number();
    names[local_map.name()] = ShortName(agent, number);
    for (int i = 0; i < local_map.joined_local_maps_size(); ++i) {
      const bool is_numbered = i < local_map.joined_numbers_size();
      names[local_map.joined_local_maps(i)] =
          ShortName(agent, is_numbered ? local_map.joined_numbers(i) : number);
    }
  }
  return names;
}

std::string DescribeNumbers(const std::string& agent, const std::vector<uint32_t>& numbers) {
  std::vector<std::string> runs;
  for (size_t first = 0; first < numbers.size();) {
    size_t last = first;
    while (last + 1 < numbers.size() && numbers[last + 1] == numbers[last] + 1) ++last;
    runs.push_back(ShortName(agent, numbers[first]));
    if (last > first) absl::StrAppend(&runs.back(), " to ", ShortName(agent, numbers[last]));
    first = last + 1;
  }
  return absl::StrJoin(runs, ", ");
}

}  // namespace corbslam::services
