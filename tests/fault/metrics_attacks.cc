#include "tests/fault/metrics_attacks.h"

#include <algorithm>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "services/http/testing/raw_http.h"

namespace corbslam::tests {
namespace {

using testing::Ask;
using testing::BodyOf;
using testing::MakeRequest;
using testing::RawConnection;
using testing::StatusOf;

constexpr absl::Duration kBetweenBytes = absl::Milliseconds(100);

std::string NameOf(const std::string& answer) {
  return answer.empty() ? "closed" : absl::StrCat(StatusOf(answer));
}

std::vector<std::string> Headers() {
  std::string many;
  for (int i = 0; i < 10000; ++i) absl::StrAppend(&many, "X", i, ": y\r\n");
  return {"",
          "Content-Length: 9223372036854775807\r\n",
          "Content-Length: -1\r\n",
          "Transfer-Encoding: chunked\r\n",
          "Expect: 100-continue\r\n",
          "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Key: eA==\r\n",
          "Connection: Upgrade, HTTP2-Settings\r\nUpgrade: h2c\r\nHTTP2-Settings: AA\r\n",
          "Range: bytes=0-0,0-0,0-0,-1,5-2\r\n",
          "Accept-Encoding: gzip, br;q=999999999999999\r\n",
          ": \r\n",
          absl::StrCat("Cookie: ", std::string(100000, 'c'), "\r\n"),
          many};
}

// Returns whether the server has closed it by now.
bool HasEnded(RawConnection& connection) {
  connection.ReadToEnd(absl::ZeroDuration());
  return connection.has_ended();
}

}  // namespace

void MetricsAttacker::Count(absl::string_view request, Ends& ends) {
  ++ends[NameOf(Ask(address_, request))];
}

MetricsAttacker::Ends MetricsAttacker::AndStillScraped(Ends ends) {
  const std::string answer = Ask(address_, MakeRequest("GET", "/metrics"));
  const bool good =
      StatusOf(answer) == 200 && absl::StrContains(BodyOf(answer), "corbslam_build_info");
  ends["scraped"] += good ? 1 : 0;
  return ends;
}

MetricsAttacker::Ends MetricsAttacker::AskForEverything() {
  Ends ends;
  for (const char* method : {"GET", "HEAD", "POST", "PUT", "DELETE", "OPTIONS", "TRACE", "CONNECT",
                             "PATCH", "PRI", "BREW", "get"}) {
    for (const std::string& path :
         {std::string("/metrics"), std::string("/"), std::string("/nowhere"), std::string("*"),
          std::string("/../../etc/passwd"), std::string("/metrics/"), std::string("/%00%ff"),
          std::string("http://x/metrics"), "/" + std::string(100000, 'a')}) {
      Count(MakeRequest(method, path), ends);
    }
  }
  for (const std::string& headers : Headers()) {
    for (const char* method : {"GET", "POST"}) {
      Count(MakeRequest(method, "/metrics", headers), ends);
    }
  }
  return AndStillScraped(std::move(ends));
}

std::string MetricsAttacker::Mutate(std::string request) {
  const auto pick = [this](size_t end) {
    return std::uniform_int_distribution<size_t>(0, end - 1)(random_);
  };
  if (pick(4) == 0) request.resize(pick(request.size()));
  if (pick(4) == 0) request.append(request);
  if (request.empty()) request = "\n";
  const size_t changes = pick(20);
  for (size_t i = 0; i < changes; ++i) request[pick(request.size())] = static_cast<char>(pick(256));
  return request;
}

MetricsAttacker::Ends MetricsAttacker::SendMutatedRequests(int requests) {
  const std::string good = MakeRequest("GET", "/metrics", "Accept: text/plain\r\nA: b\r\n");
  Ends ends;
  for (int i = 0; i < requests; ++i) {
    RawConnection connection(address_);
    connection.Send(Mutate(good));
    // Some are no whole request any more; the server would wait for the rest.
    connection.EndSending();
    const std::string answer = connection.ReadToEnd();
    ++ends[connection.has_ended() ? NameOf(answer) : "open"];
  }
  return AndStillScraped(std::move(ends));
}

MetricsAttacker::Ends MetricsAttacker::HoldConnections(int connections, absl::Duration patience) {
  std::vector<RawConnection> held;
  for (int i = 0; i < connections; ++i) held.emplace_back(address_);
  Ends ends = AndStillScraped({});
  const absl::Time deadline = absl::Now() + patience;
  const std::string request = MakeRequest("GET", "/metrics");
  for (size_t byte = 0; absl::Now() < deadline; ++byte) {
    for (size_t i = 0; i < held.size(); i += 2) {
      held[i].Send(request.substr(byte % (request.size() - 4), 1));
    }
    if (std::all_of(held.begin(), held.end(), HasEnded)) break;
    absl::SleepFor(kBetweenBytes);
  }
  for (RawConnection& connection : held) ++ends[HasEnded(connection) ? "closed" : "open"];
  return AndStillScraped(std::move(ends));
}

MetricsAttacker::Ends MetricsAttacker::OpenAndClose(int connections) {
  Ends ends;
  for (int i = 0; i < connections; ++i) {
    ++ends[RawConnection(address_).is_connected() ? "closed" : "refused"];
  }
  return AndStillScraped(std::move(ends));
}

MetricsAttacker::Ends MetricsAttacker::ScrapeWithoutReading(int connections,
                                                            absl::Duration patience) {
  std::vector<RawConnection> asking;
  for (int i = 0; i < connections; ++i) {
    asking.emplace_back(address_);
    asking.back().Send(MakeRequest("GET", "/metrics"));
  }
  Ends ends = AndStillScraped({});
  const absl::Time deadline = absl::Now() + patience;
  for (RawConnection& connection : asking) {
    const std::string answer =
        connection.ReadToEnd(std::max(deadline - absl::Now(), absl::ZeroDuration()));
    ++ends[connection.has_ended() ? NameOf(answer) : "open"];
  }
  return AndStillScraped(std::move(ends));
}

}  // namespace corbslam::tests
