// Holds a mission whose programs may come from two builds: this one and an older one.
#ifndef CORBSLAM_TESTS_FAULT_UPGRADE_FIXTURE_H_
#define CORBSLAM_TESTS_FAULT_UPGRADE_FIXTURE_H_

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "services/client/store/store_reader.h"
#include "services/runtime/child_process.h"
#include "slam/evaluation/trajectory.h"
#include "tests/fault/fault_fixture.h"

namespace corbslam::tests {

enum class Build { kOld, kNew };

// CORBSLAM_OLD_PROGRAMS: the folder of an older build's programs. Without it "old" ones are this
// build's, too: then it is a restart of everything, one after the other.
bool HasOldPrograms();

// What one process of a robot said in the end.
struct RobotAccount {
  std::string agent;
  uint64_t keyframes = 0;
  uint64_t frames = 0;
  uint64_t batches_left = 0;
  uint64_t local_maps_lost = 0;
  Trajectory poses;  // Of all its local maps, each in its own frame.
};

class UpgradeTest : public FaultTest {
 protected:
  static constexpr char kMission[] = "upgraded";

  // Each takes the address and the folder of the one before it, if there was one, which has ended.
  void StartWorker(Build build);
  void StartStore(Build build);
  // Asks the program to end and waits for it; it must end well.
  static void End(std::unique_ptr<services::ChildProcess>& process);

  // `options` are those of the source, `flags` further ones of the program.
  void StartRobot(Build build, const std::string& agent, const std::string& options,
                  const std::vector<std::string>& flags = {});
  // Ends the newest process of this agent, which stops driving and sends all that it has; 120 s at
  // most.
  void EndRobot(const std::string& agent);
  // Waits for the end of that process, 180 s at most, and returns how it ended.
  absl::Status WaitForRobot(const std::string& agent);
  // Waits until both robots reported frames beyond `before` or have ended; returns what they
  // reported.
  std::map<std::string, uint64_t> WaitForFrames(const std::map<std::string, uint64_t>& before);

  // Returns the account of each process of a robot, all of which have ended, oldest first.
  std::vector<RobotAccount> Accounts() const;
  // Compares what robots made with what the store has: keyframes, frames, where each frame was.
  // `robots`: how many agents there are; all must be fused into one island. What an earlier process
  // of an agent could not send is to be sent by the next.
  void ExpectNothingLost(size_t robots);

  services::StoreReader Reader();

  std::unique_ptr<services::ChildProcess> worker_;
  std::unique_ptr<services::ChildProcess> store_;
  std::string store_address_;

 private:
  struct Robot {
    std::string agent;
    std::string name;  // Of the process: its files begin with it.
    std::unique_ptr<services::ChildProcess> process;
  };
  Robot* Newest(const std::string& agent);
  // Returns whether the program of that build has a flag of this name.
  bool Knows(Build build, const std::string& program, const std::string& flag);
  std::unique_ptr<services::ChildProcess> StartOf(Build build, const std::string& name,
                                                  const std::string& program,
                                                  std::vector<std::string> arguments);
  void ExpectPosesStored(const RobotAccount& account);

  std::string worker_address_;
  std::vector<Robot> robots_;
  int starts_ = 0;
};

}  // namespace corbslam::tests

#endif  // CORBSLAM_TESTS_FAULT_UPGRADE_FIXTURE_H_
