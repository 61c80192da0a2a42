#include "tests/bench/worker_simulation.h"

#include <algorithm>
#include <functional>
#include <map>
#include <queue>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "services/client/remote/worker_choice.h"
#include "services/server/work_turns.h"

namespace corbslam::tests {
namespace {

using services::WorkerStanding;
using services::WorkTurns;

// A worker that says nothing is given up after (services/client/remote/channel.h).
constexpr double kSilence_s = 30;
// A store whose workers took nothing asks again after.
constexpr double kRetry_s = 1;

struct Request {
  int mission = 0;
  bool adjusts = false;
  double since_s = 0;
  int worker = -1;  // That has it.
  uint64_t attempt = 0;
};

struct Worker {
  bool is_dead = false;
  double hangs_until_s = 0;
  int running = 0;
  uint64_t life = 0;  // Grows when it dies: what it had is lost.
  WorkTurns turns;
  int held = 0;
};

class Simulation {
 public:
  explicit Simulation(const WorkersOptions& options)
      : options_(options),
        random_(options.seed),
        workers_(static_cast<size_t>(options.workers)),
        answered_(static_cast<size_t>(options.stores * options.missions_per_store), 0) {
    for (int store = 0; store < options.stores; ++store) {
      standings_.emplace_back(workers_.size());
      first_.push_back(static_cast<size_t>(store) % workers_.size());
    }
    for (int mission = 0; mission < static_cast<int>(answered_.size()); ++mission) {
      Ask(mission, false);
      Ask(mission, true);
    }
    if (options.between_faults < absl::InfiniteDuration()) After(Wait(30), [this] { Harm(); });
  }

  WorkersResult Run() {
    const double end_s = absl::ToDoubleSeconds(options_.duration);
    while (!events_.empty() && events_.top().at_s <= end_s) {
      const Event event = events_.top();
      events_.pop();
      now_s_ = event.at_s;
      event.happens();
    }
    WorkersResult result = result_;
    result.waiting = requests_.size();
    result.fewest = UINT64_MAX;
    for (size_t mission = 0; mission < answered_.size(); ++mission) {
      result.most = std::max(result.most, answered_[mission]);
      if (!IsGreedy(static_cast<int>(mission))) {
        result.fewest = std::min(result.fewest, answered_[mission]);
      }
    }
    return result;
  }

 private:
  struct Event {
    double at_s;
    uint64_t number;
    std::function<void()> happens;
    bool operator<(const Event& other) const {
      return at_s != other.at_s ? at_s > other.at_s : number > other.number;
    }
  };

  void After(double wait_s, std::function<void()> happens) {
    events_.push({now_s_ + wait_s, ++last_event_, std::move(happens)});
  }
  double Wait(double mean_s) { return std::exponential_distribution<double>(1 / mean_s)(random_); }
  absl::Time Now() const { return absl::UnixEpoch() + absl::Seconds(now_s_); }
  bool IsGreedy(int mission) const { return mission % options_.missions_per_store == 0; }
  size_t StoreOf(int mission) const {
    return static_cast<size_t>(mission / options_.missions_per_store);
  }

  void Ask(int mission, bool adjusts) {
    const uint64_t id = ++last_request_;
    requests_[id] = {mission, adjusts, now_s_};
    Send(id, {});
  }

  // Asks one worker after the other, as RemoteFusionWorkers does.
  void Send(uint64_t id, std::vector<size_t> tried) {
    Request& request = requests_.at(id);
    const size_t store = StoreOf(request.mission);
    std::vector<WorkerStanding> standings = standings_[store];
    for (const size_t worker : tried) standings[worker].is_tried = true;
    const size_t chosen = services::ChooseWorker(standings, first_[store], Now());
    if (chosen == workers_.size()) {
      return After(kRetry_s, [this, id] { Send(id, {}); });
    }
    ++standings_[store][chosen].running;
    tried.push_back(chosen);
    request.worker = static_cast<int>(chosen);
    const uint64_t attempt = ++request.attempt;
    Worker& worker = workers_[chosen];
    if (worker.is_dead || worker.held >= options_.max_requests) return Refuse(id, tried);
    ++worker.held;
    worker.turns.Add({id, std::to_string(request.mission), request.adjusts}, Now());
    BeginAt(chosen);
    // What hangs answers no question either.
    Watch(id, attempt, tried);
  }

  void Watch(uint64_t id, uint64_t attempt, const std::vector<size_t>& tried) {
    After(10, [this, id, attempt, tried] {
      const auto it = requests_.find(id);
      if (it == requests_.end() || it->second.attempt != attempt) return;
      const Worker& worker = workers_[static_cast<size_t>(it->second.worker)];
      if (worker.hangs_until_s < now_s_ + kSilence_s - 10) return Watch(id, attempt, tried);
      After(kSilence_s - 10, [this, id, attempt, tried] {
        const auto still = requests_.find(id);
        if (still == requests_.end() || still->second.attempt != attempt) return;
        Refuse(id, tried);
      });
    });
  }

  void Refuse(uint64_t id, const std::vector<size_t>& tried) {
    Request& request = requests_.at(id);
    WorkerStanding& standing =
        standings_[StoreOf(request.mission)][static_cast<size_t>(request.worker)];
    --standing.running;
    standing.refused_at = Now();
    // What the worker still has of it is nobody's.
    request.worker = -1;
    ++request.attempt;
    ++result_.asked_again;
    After(0.01, [this, id, tried] { Send(id, tried); });
  }

  void BeginAt(size_t at) {
    Worker& worker = workers_[at];
    while (worker.running < options_.threads && worker.turns.waiting() > 0) {
      const WorkTurns::Request next = worker.turns.Begin(Now());
      const auto it = requests_.find(next.id);
      const bool is_wanted = it != requests_.end() && it->second.worker == static_cast<int>(at);
      if (!is_wanted) {  // Its caller has gone.
        worker.turns.End(next.mission);
        --worker.held;
        continue;
      }
      ++worker.running;
      const double takes_s = it->second.adjusts
                                 ? std::uniform_real_distribution<double>(1, 20)(random_)
                                 : std::uniform_real_distribution<double>(0.05, 0.6)(random_);
      Finish(at, worker.life, next, it->second.attempt, takes_s);
    }
  }

  void Finish(size_t at, uint64_t life, const WorkTurns::Request& done, uint64_t attempt,
              double takes_s) {
    After(takes_s, [this, at, life, done, attempt] {
      Worker& worker = workers_[at];
      if (worker.life != life) return;
      if (worker.hangs_until_s > now_s_) {
        return Finish(at, life, done, attempt, worker.hangs_until_s - now_s_ + 0.1);
      }
      --worker.running;
      --worker.held;
      worker.turns.End(done.mission);
      const auto it = requests_.find(done.id);
      if (it != requests_.end() && it->second.attempt == attempt) Answer(done.id);
      BeginAt(at);
    });
  }

  void Answer(uint64_t id) {
    const Request request = requests_.at(id);
    requests_.erase(id);
    --standings_[StoreOf(request.mission)][static_cast<size_t>(request.worker)].running;
    double& longest = request.adjusts ? result_.longest_adjustment_s : result_.longest_overlap_s;
    longest = std::max(longest, now_s_ - request.since_s);
    ++(request.adjusts ? result_.adjustments : result_.overlaps);
    if (!request.adjusts) ++answered_[static_cast<size_t>(request.mission)];
    const double mean_s = absl::ToDoubleSeconds(options_.between_requests);
    const double wait_s = IsGreedy(request.mission) ? 0.001 : Wait(request.adjusts ? 60 : mean_s);
    After(wait_s, [this, request] { Ask(request.mission, request.adjusts); });
  }

  void Harm() {
    After(Wait(absl::ToDoubleSeconds(options_.between_faults)), [this] { Harm(); });
    const size_t at = std::uniform_int_distribution<size_t>(0, workers_.size() - 1)(random_);
    Worker& worker = workers_[at];
    if (worker.is_dead || worker.hangs_until_s > now_s_) return;
    if (std::bernoulli_distribution(0.5)(random_)) {
      worker.hangs_until_s = now_s_ + std::uniform_real_distribution<double>(1, 120)(random_);
      return;
    }
    // All that it had is lost, and its callers see the line break.
    const uint64_t life = worker.life + 1;
    worker = Worker();
    worker.life = life;
    worker.is_dead = true;
    for (auto& [id, request] : requests_) {
      if (request.worker != static_cast<int>(at)) continue;
      const uint64_t lost = id;
      const uint64_t attempt = request.attempt;
      After(0.02, [this, lost, attempt, at] {
        const auto it = requests_.find(lost);
        if (it != requests_.end() && it->second.attempt == attempt) Refuse(lost, {at});
      });
    }
    After(std::uniform_real_distribution<double>(1, 60)(random_),
          [this, at] { workers_[at].is_dead = false; });
  }

  const WorkersOptions options_;
  std::mt19937_64 random_;
  double now_s_ = 0;
  std::priority_queue<Event> events_;
  uint64_t last_event_ = 0;
  std::vector<Worker> workers_;
  std::vector<std::vector<WorkerStanding>> standings_;  // Of each store.
  std::vector<size_t> first_;                           // Of each store: its own worker.
  std::map<uint64_t, Request> requests_;
  uint64_t last_request_ = 0;
  std::vector<uint64_t> answered_;
  WorkersResult result_;
};

}  // namespace

WorkersResult SimulateWorkers(const WorkersOptions& options) { return Simulation(options).Run(); }

}  // namespace corbslam::tests
