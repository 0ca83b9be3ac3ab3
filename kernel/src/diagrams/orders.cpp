// Orders in which what belongs together stands together.
#include "diagrams/orders.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <numeric>
#include <queue>
#include <set>
#include <utility>
#include <vector>

namespace mcpn {

namespace {

// Members by what they are worth, the first as they stand among those that are worth most. A member whose worth
// changes is queued again, and its older entries are passed over.
class Queue {
 public:
  explicit Queue(const std::vector<std::uint32_t>& place) : place_(place), worth_(place.size()), here_(place.size()) {}

  bool holds(std::uint32_t member) const { return here_[member]; }
  void put(std::uint32_t member, std::int64_t worth) {
    if (here_[member] && worth == worth_[member]) return;
    worth_[member] = worth;
    here_[member] = true;
    queue_.push({worth, ~place_[member], member});
  }
  bool take(std::uint32_t& member) {
    while (!queue_.empty()) {
      const Entry first = queue_.top();
      queue_.pop();
      member = first.member;
      if (!here_[member] || first.worth != worth_[member]) continue;
      here_[member] = false;
      return true;
    }
    return false;
  }

 private:
  struct Entry {
    std::int64_t worth;
    std::uint32_t near, member;
    bool operator<(const Entry& other) const {
      return worth != other.worth ? worth < other.worth : near < other.near;
    }
  };
  const std::vector<std::uint32_t>& place_;
  std::vector<std::int64_t> worth_;
  std::vector<bool> here_;
  std::priority_queue<Entry> queue_;
};

std::vector<std::uint32_t> places_of(const std::vector<std::uint32_t>& order) {
  std::vector<std::uint32_t> place(order.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) place[order[i]] = i;
  return place;
}

std::vector<std::vector<std::uint32_t>> groups_of(const Groups& groups, std::size_t count) {
  std::vector<std::vector<std::uint32_t>> of(count);
  for (std::uint32_t g = 0; g < groups.size(); ++g)
    for (const std::uint32_t member : groups[g]) of[member].push_back(g);
  return of;
}

}  // namespace

// Each round moves every member to the mean of the centres of its groups, wide groups pulling less; the order of
// least total span, each divided by the group's width, is kept. It ends after ten rounds without a better one.
std::vector<std::uint32_t> force(const Groups& groups, const std::vector<std::uint32_t>& start, unsigned rounds) {
  const std::size_t count = start.size();
  std::vector<double> position(count), pulled(count), total(count, 0);
  for (std::size_t i = 0; i < count; ++i) position[start[i]] = double(i);
  for (const auto& group : groups)
    for (const std::uint32_t member : group) total[member] += 1.0 / double(group.size());
  const auto span = [&] {
    double sum = 0;
    for (const auto& group : groups) {
      if (group.empty()) continue;
      double least = position[group[0]], most = least;
      for (const std::uint32_t member : group) {
        least = std::min(least, position[member]);
        most = std::max(most, position[member]);
      }
      sum += (most - least) / double(group.size());
    }
    return sum;
  };
  std::vector<std::uint32_t> order = start, best = start;
  double least = span();
  for (unsigned round = 0, stale = 0; round < rounds && stale <= 10; ++round) {
    std::fill(pulled.begin(), pulled.end(), 0);
    for (const auto& group : groups) {
      double centre = 0;
      for (const std::uint32_t member : group) centre += position[member];
      const double width = double(group.size());
      for (const std::uint32_t member : group) pulled[member] += 1.0 / width * (centre / width);
    }
    for (std::size_t i = 0; i < count; ++i) pulled[i] = total[i] > 0 ? pulled[i] / total[i] : position[i];
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return pulled[a] < pulled[b]; });
    for (std::size_t i = 0; i < count; ++i) position[order[i]] = double(i);
    const double now = span();
    stale = now < least ? 0 : stale + 1;
    if (now < least) {
      least = now;
      best = order;
    }
  }
  return best;
}

// Greedy: the next member is the one that brings groups under way nearest to their end and begins the fewest. One
// of k members that are missing to a group counts 1/k, a group that begins costs a part of that; the sum is divided
// by the number of the member's groups to the power of 3/4, so that members of many groups neither come all at once
// nor all at last. Equals stand as at the start.
std::vector<std::uint32_t> closing(const Groups& groups, const std::vector<std::uint32_t>& start) {
  constexpr std::int64_t kUnit = 720'720, kBegins = kUnit * 3 / 10;
  const auto of = groups_of(groups, start.size());
  const auto place = places_of(start);
  std::vector<std::uint32_t> placed(groups.size(), 0);
  const auto gain = [&](std::uint32_t group) {
    return placed[group] ? kUnit / std::int64_t(groups[group].size() - placed[group]) : -kBegins;
  };
  std::vector<std::int64_t> gains(start.size()), changes(start.size(), 0);
  Queue queue(place);
  const auto put = [&](std::uint32_t member) {
    const auto degree = double(std::max<std::size_t>(of[member].size(), 1));
    queue.put(member, std::int64_t(double(gains[member]) / std::sqrt(degree * std::sqrt(degree))));
  };
  for (const std::uint32_t member : start) {
    gains[member] = -kBegins * std::int64_t(of[member].size());
    put(member);
  }
  std::vector<std::uint32_t> order, changed;
  for (std::uint32_t member; queue.take(member);) {
    order.push_back(member);
    changed.clear();
    for (const std::uint32_t group : of[member]) {
      const std::int64_t before = gain(group);
      if (++placed[group] == groups[group].size()) continue;
      const std::int64_t after = gain(group);
      for (const std::uint32_t other : groups[group])
        if (queue.holds(other)) {
          if (changes[other] == 0) changed.push_back(other);
          changes[other] += after - before;
        }
    }
    for (const std::uint32_t other : changed) {
      gains[other] += changes[other];
      changes[other] = 0;
      put(other);
    }
  }
  return order;
}

// Sloan (Int. J. Numer. Methods Eng. 23, 1986): from one end of the graph, in which members of a group are
// neighbours, to the other, so that few are met whose neighbours are not all placed.
std::vector<std::uint32_t> sloan(const Groups& groups, const std::vector<std::uint32_t>& start) {
  constexpr std::int64_t kFar = 1, kMet = 2;  // weights of the distance from the end, and of unmet neighbours
  constexpr std::uint32_t kNowhere = std::numeric_limits<std::uint32_t>::max();
  const std::size_t count = start.size();
  std::vector<std::vector<std::uint32_t>> near(count);
  for (const auto& group : groups)
    for (const std::uint32_t member : group)
      for (const std::uint32_t other : group)
        if (other != member) near[member].push_back(other);
  for (auto& beside : near) {
    std::sort(beside.begin(), beside.end());
    beside.erase(std::unique(beside.begin(), beside.end()), beside.end());
  }
  std::vector<std::uint32_t> distance(count, kNowhere), found;
  const auto farthest = [&](std::uint32_t from) {  // of the least degree; distances are those from there
    for (const std::uint32_t member : found) distance[member] = kNowhere;
    found.assign(1, from);
    distance[from] = 0;
    for (std::size_t i = 0; i < found.size(); ++i)
      for (const std::uint32_t other : near[found[i]])
        if (distance[other] == kNowhere) {
          distance[other] = distance[found[i]] + 1;
          found.push_back(other);
        }
    std::uint32_t best = from;
    for (const std::uint32_t member : found)
      if (distance[member] > distance[best] ||
          (distance[member] == distance[best] && near[member].size() < near[best].size()))
        best = member;
    return best;
  };
  enum Status : std::uint8_t { unseen, seen, active, done };
  std::vector<Status> status(count, unseen);
  std::vector<std::int64_t> worth(count);
  std::vector<std::uint32_t> order, numbers(count);
  std::iota(numbers.begin(), numbers.end(), 0u);
  Queue queue(numbers);
  for (const std::uint32_t first : start) {
    if (status[first] == done) continue;
    found.clear();
    const std::uint32_t begin = farthest(farthest(first));
    for (const std::uint32_t member : found)
      worth[member] = kFar * std::int64_t(distance[member]) - kMet * std::int64_t(near[member].size() + 1);
    const auto raise = [&](std::uint32_t member) {
      worth[member] += kMet;
      if (status[member] == unseen) status[member] = seen;
      queue.put(member, worth[member]);
    };
    status[begin] = seen;
    queue.put(begin, worth[begin]);
    for (std::uint32_t member; queue.take(member);) {
      if (status[member] == seen)
        for (const std::uint32_t other : near[member])
          if (status[other] != done) raise(other);
      order.push_back(member);
      status[member] = done;
      for (const std::uint32_t other : near[member])
        if (status[other] == seen) {
          raise(other);
          status[other] = active;
          for (const std::uint32_t next : near[other])
            if (status[next] != done) raise(next);
        }
    }
    for (const std::uint32_t member : found) distance[member] = kNowhere;
  }
  return order;
}

// Clusters: two members pull each other by each group that holds both, less the wider it is; the two clusters that
// pull most, divided by a power of their sizes, are made one, again and again.
std::vector<std::uint32_t> clustered(const Groups& groups, const std::vector<std::uint32_t>& start) {
  constexpr double kWidth = 2, kSize = 0.75;  // powers of a group's other members, and of the two sizes
  struct Cluster {
    double mean;  // of the places that its members have at the start
    std::vector<std::uint32_t> members;
    std::map<std::uint32_t, double> pulls;  // by later number too
  };
  struct Pair {
    double pull;
    std::uint32_t first, second;
    bool operator<(const Pair& other) const {
      return pull != other.pull ? pull < other.pull : std::pair(first, second) > std::pair(other.first, other.second);
    }
  };
  const auto place = places_of(start);
  std::vector<Cluster> clusters(start.size());
  std::set<std::uint32_t> whole;  // those that are no part of another
  for (std::uint32_t i = 0; i < clusters.size(); ++i) {
    clusters[i] = {double(place[i]), {i}, {}};
    whole.insert(whole.end(), i);
  }
  for (const auto& group : groups) {
    const double pull = group.size() < 2 ? 0 : std::pow(double(group.size() - 1), -kWidth);
    for (std::size_t i = 0; i < group.size(); ++i)
      for (std::size_t j = 0; j < i; ++j) {
        if (group[i] == group[j]) continue;
        clusters[group[i]].pulls[group[j]] += pull;
        clusters[group[j]].pulls[group[i]] += pull;
      }
  }
  std::priority_queue<Pair> queue;
  for (const std::uint32_t i : whole)
    for (const auto& [other, pull] : clusters[i].pulls)
      if (other < i) queue.push({pull, other, i});
  const auto above = [&](std::uint32_t a, std::uint32_t b) {
    return clusters[a].mean != clusters[b].mean ? clusters[a].mean < clusters[b].mean
                                                : clusters[a].members < clusters[b].members;
  };
  while (!queue.empty()) {
    auto [pull, upper, lower] = queue.top();
    queue.pop();
    if (!whole.contains(upper) || !whole.contains(lower)) continue;
    if (above(lower, upper)) std::swap(upper, lower);
    const auto number = std::uint32_t(clusters.size());
    Cluster made = std::move(clusters[upper]);
    const Cluster under = std::move(clusters[lower]);
    const auto size = double(made.members.size()), below = double(under.members.size());
    made.mean = (made.mean * size + under.mean * below) / (size + below);
    made.members.insert(made.members.end(), under.members.begin(), under.members.end());
    for (const auto& [other, also] : under.pulls) made.pulls[other] += also;
    made.pulls.erase(upper);
    made.pulls.erase(lower);
    whole.erase(upper);
    whole.erase(lower);
    for (const auto& [other, together] : made.pulls) {
      Cluster& beside = clusters[other];
      beside.pulls.erase(upper);
      beside.pulls.erase(lower);
      beside.pulls[number] = together;
      const double sizes = double(made.members.size()) * double(beside.members.size());
      queue.push({together / std::pow(sizes, kSize), other, number});
    }
    clusters.push_back(std::move(made));
    whole.insert(whole.end(), number);
  }
  std::vector<std::uint32_t> numbers(whole.begin(), whole.end()), order;
  std::sort(numbers.begin(), numbers.end(), above);
  for (const std::uint32_t number : numbers)
    order.insert(order.end(), clusters[number].members.begin(), clusters[number].members.end());
  return order;
}

}  // namespace mcpn
