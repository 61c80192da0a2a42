// Runs a mission by the real programs with everything on by which they can be watched.
#ifndef CORBSLAM_TESTS_INTEGRATION_OBSERVED_MISSION_H_
#define CORBSLAM_TESTS_INTEGRATION_OBSERVED_MISSION_H_

#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "services/runtime/child_process.h"

namespace corbslam::tests {

// Has a fusion worker, a map store with a journal and the robots alpha and bravo on the recording
// that ships: done, all acknowledged and fused, and all still running.
class ObservedMissionTest : public ::testing::Test {
 protected:
  // What one endpoint said, as scrape.py prints it.
  class Scrape {
   public:
    explicit Scrape(nlohmann::json families) : families_(std::move(families)) {}
    // Returns the value of the one series with these labels; a histogram's series have the endings
    // _count and _sum. Fails the test where there is no such series.
    double Value(const std::string& name,
                 const std::map<std::string, std::string>& labels = {}) const;
    // Returns the sum of all series that have these labels among theirs; 0 where none has.
    double Sum(const std::string& name,
               const std::map<std::string, std::string>& labels = {}) const;
    size_t Count(const std::string& name,
                 const std::map<std::string, std::string>& labels = {}) const;
    const nlohmann::json& families() const { return families_; }

   private:
    std::vector<double> Values(const std::string& name,
                               const std::map<std::string, std::string>& labels) const;

    const nlohmann::json families_;
  };

  void SetUp() override;
  void TearDown() override;

  // Scrapes the program that was started under this name. Fails the test where a parser objects.
  Scrape ScrapeOf(const std::string& name);
  // Returns where its metrics are.
  std::string MetricsAddressOf(const std::string& name) const;
  // Calls the store, which answers once.
  nlohmann::json Ask(const std::string& method, const nlohmann::json& request);
  // Runs one of this folder's scripts and returns what it printed.
  std::string RunScript(const std::string& script, const std::vector<std::string>& arguments);
  // Ends all programs, robots first.
  void StopAll();

  std::string FileOf(const std::string& name) const { return folder_ + "/" + name; }
  std::string LogOf(const std::string& name) const { return FileOf(name + ".log"); }
  // Returns the address of a robot's own services.
  std::string AddressOf(const std::string& name);

 private:
  void Start(const std::string& name, const std::string& program,
             std::vector<std::string> arguments);
  void StartRobot(const std::string& name, const std::string& frames);
  void WaitUntilFused();

  std::string folder_;
  std::string store_address_;
  // Processes in the order of their start.
  std::vector<std::unique_ptr<services::ChildProcess>> processes_;
};

}  // namespace corbslam::tests

#endif  // CORBSLAM_TESTS_INTEGRATION_OBSERVED_MISSION_H_
